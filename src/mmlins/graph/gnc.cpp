// SPDX-License-Identifier: MIT
#include "mmlins/graph/gnc.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mmlins/base/check.hpp"

namespace mmlins::graph {

double chi2_limit(int rank) {
  static constexpr std::array<double, 6> kQuantile999{10.828, 13.816, 16.266, 18.467, 20.515, 22.458};
  MMLINS_CHECK(rank >= 1 && rank <= 6);
  return kQuantile999[static_cast<std::size_t>(rank - 1)];
}

double first_convexity(double max_ratio) { return 1.0 / std::max(2.0 * max_ratio - 1.0, 1e-9); }

double truncated_weight(double ratio, double mu) {
  if (ratio <= mu / (mu + 1.0)) return 1.0;
  if (ratio >= (mu + 1.0) / mu) return 0.0;
  return std::sqrt(mu * (mu + 1.0) / ratio) - mu;
}

}  // namespace mmlins::graph

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

double first_width(double max_ratio) { return 2.0 * max_ratio; }

double graduated_weight(double ratio, double width) {
  const double root = width / (ratio + width);
  return root * root;
}

}  // namespace mmlins::graph

// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/soft_treatment.hpp"

#include <algorithm>

namespace mmlins::degeneracy {
namespace {

/// Scales the information along `u`, an axis of the block that begins at `judged`, with the other block free.
void scale_direction(Quadratic& q, const math::Vector3d& u, int judged, double share) {
  const int free = 3 - judged;
  const math::Matrix3d H_free = q.H.block<3, 3>(free, free);
  const math::Vector3d coupling = q.H.block<3, 3>(free, judged) * u;
  math::Vector6d lifted;
  lifted.segment<3>(judged) = u;
  lifted.segment<3>(free) = -H_free.completeOrthogonalDecomposition().solve(coupling);
  const math::Vector6d pull = q.H * lifted;
  const double information = lifted.dot(pull);
  if (information <= 0.0) return;
  const double taken = (1.0 - share) / information;
  q.b -= taken * lifted.dot(q.b) * pull;
  q.H -= taken * pull * pull.transpose();
}

}  // namespace

double kept_share(const Direction& direction, const ObservabilityConfig& config) {
  const double nu = direction.noise_share;
  if (nu <= config.weak_noise_share) return 1.0;
  return 1.0 - nu;
}

Quadratic soften(const Quadratic& quadratic, const Observability& observability, const ObservabilityConfig& config) {
  Quadratic result = quadratic;
  for (const Direction& direction : observability.translation) {
    const double share = kept_share(direction, config);
    if (share < 1.0) scale_direction(result, direction.axis, 3, share);
  }
  for (const Direction& direction : observability.rotation) {
    const double share = kept_share(direction, config);
    if (share < 1.0) scale_direction(result, direction.axis, 0, share);
  }
  return result;
}

}  // namespace mmlins::degeneracy

// SPDX-License-Identifier: MIT
#pragma once
// Takes from a scan's information what noisy normals feigned, so that the filter keeps the IMU's prediction in
// directions that the scan does not see. docs/math/degeneracy.md, section 2.

#include "mmlins/degeneracy/observability.hpp"

namespace mmlins::degeneracy {

/// The quadratic d^T H d + 2 b^T d that a scan makes of the pose error d = [rotation; translation].
struct Quadratic {
  math::Matrix6d H = math::Matrix6d::Zero();
  math::Vector6d b = math::Vector6d::Zero();
};

/// Share of a direction's information to keep: all while little of it is feigned, beyond that what is not. Eq. (6).
[[nodiscard]] double kept_share(const Direction& direction, const ObservabilityConfig& config);

/// The quadratic with the information along doubtful directions scaled down; its minimum stays where it was.
/// Directions of which everything is kept leave it untouched. Eq. (7).
[[nodiscard]] Quadratic soften(const Quadratic& quadratic, const Observability& observability,
                               const ObservabilityConfig& config);

}  // namespace mmlins::degeneracy

// SPDX-License-Identifier: MIT
#pragma once
// The transform that lays an estimated path onto the true one before errors are measured: where the
// odometry's frame begins is arbitrary and no error.

#include <optional>
#include <vector>

#include "mmlins/math/se3.hpp"

namespace mmlins::eval {

enum class Alignment {
  kSe3,   ///< rotation and translation
  kYaw,   ///< heading and translation: for estimates that know where down is
  kNone,  ///< frames are the same already
};

/// The T_truth_estimate that minimises the squared distances between corresponding positions [m].
/// Closed form: Umeyama 1991 without scale; for the heading alone, the angle of the summed products.
/// Nothing if the positions do not determine it: all at one place or (kSe3) on one straight line.
/// @pre both lists have the same length
[[nodiscard]] std::optional<math::SE3> align_positions(const std::vector<math::Vector3d>& p_truth,
                                                       const std::vector<math::Vector3d>& p_estimate,
                                                       Alignment alignment);

}  // namespace mmlins::eval

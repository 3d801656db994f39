// SPDX-License-Identifier: MIT
#pragma once
// What the IMU carried through a gap, seen from its end: whoever then finds out how fast he moves, which way is down and
// what the IMU gets wrong knows where the IMU has gone astray. docs/math/eskf.md, section 8.

#include <optional>

#include "mmlins/imu/propagation.hpp"

namespace mmlins::imu {

/// The carried estimate, as likely as it is given what was found at its end. Eqs. (26) to (28).
/// @param carried  with the covariance that grew on the way
/// @param found    at the same time, its velocity, gravity and biases with what was carried as their prior; its pose may be
///   in any frame, and is taken for granted
/// @return nothing if what was found is not what carrying can have led to
[[nodiscard]] std::optional<Estimate> in_hindsight(const Estimate& carried, const Estimate& found);

}  // namespace mmlins::imu

// SPDX-License-Identifier: MIT
#pragma once
// One LiDAR message, decoded, before anything is known about what its times count from.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/base/time.hpp"

namespace mmlins::io {

/// Valid points only; arrays of the same length, or empty if the message has no such field.
struct LidarCloud {
  Time stamp;
  std::vector<Eigen::Vector3f> points;  ///< [m]
  std::vector<float> intensities;
  std::vector<std::uint16_t> rings;
  std::vector<std::int64_t> times;  ///< [ns] after an origin that the message does not tell
  int num_invalid = 0;              ///< not finite, or at the origin
};

/// Times beyond this cannot come from a clock, and sums with a stamp must not overflow. [ns]
inline constexpr std::int64_t kMaxPointTime = 4'500'000'000'000'000'000;

/// Takes out the points with a time outside of [first, last] [ns], and counts them as invalid.
void drop_outside(LidarCloud& cloud, std::int64_t first, std::int64_t last);

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#pragma once
// The known sensors, as tables.

#include <memory>

#include "mmlins/sim/lidar_model.hpp"

namespace mmlins::sim {

struct RangeLimits {
  double nearest = 0.0;   ///< [m]
  double farthest = 0.0;  ///< [m]
};

[[nodiscard]] RangeLimits range_limits(LidarModelKind model);
/// The firing pattern of the configured sensor.
[[nodiscard]] std::unique_ptr<ScanPattern> make_pattern(const LidarConfig& config, std::uint64_t seed);

}  // namespace mmlins::sim

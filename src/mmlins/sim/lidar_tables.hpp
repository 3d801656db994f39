// SPDX-License-Identifier: MIT
#pragma once
// From a sensor's table to what it fires when.

#include <memory>

#include "mmlins/sim/lidar_model.hpp"
#include "mmlins/sim/sensor_table.hpp"

namespace mmlins::sim {

/// The firing pattern of the configured sensor.
[[nodiscard]] std::unique_ptr<ScanPattern> make_pattern(const LidarConfig& config, const SensorTable& table,
                                                        std::uint64_t seed);

}  // namespace mmlins::sim

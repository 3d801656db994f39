// SPDX-License-Identifier: MIT
#pragma once
// What the search for velocity, gravity and biases is given of a scan that was matched against a young map.

#include "mmlins/initialization/state_prior.hpp"
#include "mmlins/odometry/odometry_config.hpp"
#include "mmlins/odometry/scan_result.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::odometry {

/// The pose that the scan alone prefers, doubted by what a young map may be off as well.
/// docs/math/degeneracy.md, Eq. (10).
[[nodiscard]] initialization::PoseMeasurement measured_pose(const ScanResult& result, const RestartConfig& config);

/// What is known of the biases before anything is measured.
[[nodiscard]] initialization::BiasDeviation bias_deviation(const sensor::Rig& rig);

}  // namespace mmlins::odometry

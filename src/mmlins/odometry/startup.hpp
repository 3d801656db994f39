// SPDX-License-Identifier: MIT
#pragma once
// Where the odometry begins: finds attitude, velocity and biases from the first second or two, at rest
// or in motion, by running the odometry over that window again and again until the speed at its start
// has settled; and judges what was found, so that nothing begins on a guess. docs/math/eskf.md, section 5.

#include <memory>
#include <vector>

#include "mmlins/initialization/acceptance.hpp"
#include "mmlins/odometry/scan_tracker.hpp"

namespace mmlins::odometry {

using ScanPointer = std::shared_ptr<const sensor::LidarScan>;

/// A tracker that has been through the window, and what it said about each scan of it.
struct Start {
  std::unique_ptr<ScanTracker> tracker;
  std::vector<ScanResult> results;
  imu::Estimate prior;   ///< what the tracker began with
  bool at_rest = false;
  initialization::Acceptance acceptance;  ///< nothing may begin with a start that is not accepted
};

/// Whether the IMU alone would allow that the robot stands still throughout `samples`; not with fewer than ten.
[[nodiscard]] bool imu_is_quiet(const sensor::ImuSamples& samples, const StartConfig& config,
                                const initialization::BiasDeviation& biases);

/// The prior at the first sample, with attitude level and heading zero. Eqs. (20), (21).
/// @param at_rest  take the robot to stand still throughout `samples`
[[nodiscard]] imu::Estimate start_prior(const sensor::ImuSamples& samples, const OdometryConfig& config,
                                        const initialization::BiasDeviation& biases, bool at_rest);

/// Where the robot was at `times`, before the start, by the IMU alone.
/// @param times  in order, all before `begin`
[[nodiscard]] std::vector<imu::Estimate> carried_back(const imu::Estimate& begin, const std::vector<Time>& times,
                                                      const sensor::ImuBuffer& imu, const imu::ImuNoise& noise);

/// Finds a start and judges it. Nothing if the window is too short for a start in motion, and the robot is not at
/// rest: the IMU is not quiet, or it is but the scans say that something moves.
/// @param scans  in order of time; at least one
/// @param imu    must reach over all of them
[[nodiscard]] std::unique_ptr<Start> find_start(const OdometryConfig& config, const sensor::Rig& rig,
                                                const std::vector<ScanPointer>& scans, const sensor::ImuBuffer& imu);

}  // namespace mmlins::odometry

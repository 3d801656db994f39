// SPDX-License-Identifier: MIT
#pragma once
// The measurement update of the iterated error-state Kalman filter, for any measurement that depends on
// the pose. docs/math/eskf.md, section 3.

#include <functional>

#include "mmlins/imu/propagation.hpp"

namespace mmlins::filter {

/// The quadratic that a measurement makes of the pose error around one state: the sum of
/// w (r + J d)^2 over its residuals, with d = [rotation; position].
struct PoseInformation {
  math::Matrix6d H = math::Matrix6d::Zero();   ///< sum of w J^T J
  math::Vector6d b = math::Vector6d::Zero();   ///< sum of w J^T r
  double cost = 0.0;                           ///< sum of w r^2
  int num_residuals = 0;

  PoseInformation& operator+=(const PoseInformation& other);
};

/// Linearises the measurement around `state`. `P` is how uncertain that state is, for gating.
using MeasurementModel = std::function<PoseInformation(const imu::NavState& state, const imu::ErrorMatrix& P)>;

struct UpdateLimits {
  int max_iterations;
  int min_residuals;
  double rotation_tolerance = 3e-4;  ///< [rad]
  double position_tolerance = 1e-3;  ///< [m]
};

enum class UpdateStatus { kConverged, kIterationLimit, kTooFewResiduals };

struct UpdateReport {
  UpdateStatus status = UpdateStatus::kTooFewResiduals;
  int iterations = 0;
  imu::Estimate estimate;       ///< the prior itself if there were too few residuals
  PoseInformation information;  ///< of the last linearisation
  math::SE3 linearised_at;      ///< the pose of that
};

/// Fuses the measurement with the prior estimate. Eqs. (9)-(14).
/// @param start  where the iterations begin, if not at the prior: the result is the same unless the measurement has
///               several minima
[[nodiscard]] UpdateReport iterated_update(const imu::Estimate& prior, const MeasurementModel& measure,
                                           const UpdateLimits& limits, const imu::NavState* start = nullptr);

}  // namespace mmlins::filter

// SPDX-License-Identifier: MIT
#pragma once
// The least-squares problem of a window: what poses, IMU and prior say about the states at its poses,
// linearised. docs/math/initialization.md, section 3.

#include "mmlins/initialization/arrow_system.hpp"
#include "mmlins/initialization/state_prior.hpp"

namespace mmlins::initialization {

/// One state per pose; biases and gravity are the same in all.
using States = std::vector<imu::NavState>;

/// The shared unknowns: gyro bias, accelerometer bias, then gravity: as a vector of three, or as direction of
/// two.
inline constexpr int kSharedGyro = 0;
inline constexpr int kSharedAccel = 3;
inline constexpr int kSharedGravity = 6;
inline constexpr int kFreeGravity = 9;
inline constexpr int kDirectedGravity = 8;

struct Linearised {
  ArrowSystem system;
  double cost = 0.0;  ///< sum of the whitened squares
};

class WindowProblem {
 public:
  /// Integrates the IMU between the poses, at the biases of `prior`.
  WindowProblem(const Window& window, const StatePrior& prior);

  /// Poses as measured, velocities from their differences, the rest as in the prior.
  [[nodiscard]] States guess() const;

  /// With gravity as any vector, and of the prior only `bias_information`. Eqs. (8)-(12).
  [[nodiscard]] Linearised linearise_free(const States& states, const math::Matrix6d& bias_information) const;
  /// With gravity of known magnitude, and the whole prior.
  [[nodiscard]] Linearised linearise(const States& states, const PriorMatrix& prior_information) const;

  /// Squares minus unknowns, with gravity of known magnitude.
  [[nodiscard]] int degrees_of_freedom(const PriorMatrix& prior_information) const;
  [[nodiscard]] double longest_imu_step() const;

 private:
  [[nodiscard]] Linearised linearise_measurements(const States& states) const;

  PoseMeasurements poses_;
  imu::NavState prior_;
  std::vector<imu::Preintegration> motions_;
  std::vector<NodeMatrix> motion_information_;
};

/// What a prior says about part of its unknowns if it said nothing about `count` others from `first` on that
/// are not forgotten but marginalised: rows and columns of those are zero.
[[nodiscard]] PriorMatrix marginalised(const PriorMatrix& information, int first, int count);

}  // namespace mmlins::initialization

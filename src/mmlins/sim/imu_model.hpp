// SPDX-License-Identifier: MIT
#pragma once
// The inertial sensor: exact specific force and angular rate, plus bias and white noise.

#include <cstdint>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/sensor/imu_sample.hpp"
#include "mmlins/sim/motion.hpp"

namespace mmlins::sim {

/// Gravity points to -z of the world [m/s^2].
inline constexpr double kGravity = 9.81;

struct ImuConfig {
  double rate_hz = 200.0;
  bool perfect = false;
  double gyro_noise_density = 2.5e-4;
  double accel_noise_density = 2.0e-3;
  double gyro_bias_walk = 2.0e-5;
  double accel_bias_walk = 2.0e-4;
  double gyro_turn_on_bias = 2.0e-3;
  double accel_turn_on_bias = 0.03;

  [[nodiscard]] Fields fields();
};

struct ImuBias {
  math::Vector3d gyro = math::Vector3d::Zero();   ///< [rad/s]
  math::Vector3d accel = math::Vector3d::Zero();  ///< [m/s^2]
};

class ImuModel {
 public:
  /// @param duration  how long biases are needed for
  ImuModel(const ImuConfig& config, std::uint64_t seed, Duration duration);

  /// Time of the sample after the start of the recording.
  [[nodiscard]] Duration sample_time(std::int64_t index) const;
  /// The sample; its time is counted from the start of the recording.
  [[nodiscard]] sensor::ImuSample sample(const Motion& motion, std::int64_t index) const;
  /// Of the sample at or before this time.
  [[nodiscard]] ImuBias bias_at(Duration since_start) const;

 private:
  ImuConfig config_;
  std::uint64_t seed_;
  std::vector<ImuBias> biases_;  // one per sample
};

/// What an ideal IMU reads.
[[nodiscard]] sensor::ImuSample ideal_sample(const Kinematics& kinematics);

}  // namespace mmlins::sim

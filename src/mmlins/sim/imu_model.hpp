// SPDX-License-Identifier: MIT
#pragma once
// The inertial sensor: exact specific force and angular rate, and all that a real one makes of them.

#include <cstdint>
#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/sensor/imu_sample.hpp"
#include "mmlins/sim/motion.hpp"

namespace mmlins::sim {

/// Gravity points to -z of the world [m/s^2].
inline constexpr double kGravity = 9.81;

/// Classes of sensors; kCustom is what the fields say.
enum class ImuClass { kCustom, kBmi088, kConsumer, kTactical };

/// The classes by name, in the order of the enum.
[[nodiscard]] std::vector<std::string> imu_names();

struct ImuConfig {
  ImuClass model = ImuClass::kCustom;
  double rate_hz = 200.0;
  bool perfect = false;
  double gyro_noise_density = 2.5e-4;
  double accel_noise_density = 2.0e-3;
  double gyro_bias_walk = 2.0e-5;
  double accel_bias_walk = 2.0e-4;
  double gyro_turn_on_bias = 2.0e-3;
  double accel_turn_on_bias = 0.03;
  double scale_error = 0.0;
  double misalignment_deg = 0.0;
  double gyro_limit = 0.0;
  double accel_limit = 0.0;
  double vibration = 0.0;
  double vibration_hz = 45.0;
  double time_offset = 0.0;
  double stamp_jitter = 0.0;
  double drop_share = 0.0;

  [[nodiscard]] Fields fields();
  /// With the values of the class in all fields that are still at their defaults.
  [[nodiscard]] ImuConfig resolved() const;
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
  /// Whether the sample never arrives.
  [[nodiscard]] bool is_dropped(std::int64_t index) const;
  /// The sample as measured at sample_time(). Its stamp, counted from the start of the recording too, may
  /// differ from that time by an offset and jitter.
  [[nodiscard]] sensor::ImuSample sample(const Motion& motion, std::int64_t index) const;
  /// Of the sample at or before this time.
  [[nodiscard]] ImuBias bias_at(Duration since_start) const;

 private:
  [[nodiscard]] Duration stamp_error(std::int64_t index) const;
  void spoil_scale_and_axes(sensor::ImuSample& sample) const;
  void add_vibration(sensor::ImuSample& sample, double seconds) const;
  void saturate(sensor::ImuSample& sample) const;

  ImuConfig config_;
  std::uint64_t seed_;
  std::vector<ImuBias> biases_;                            // one per sample
  math::Matrix3d gyro_axes_ = math::Matrix3d::Identity();  // what the sensor makes of a true vector
  math::Matrix3d accel_axes_ = math::Matrix3d::Identity();
};

/// What an ideal IMU reads.
[[nodiscard]] sensor::ImuSample ideal_sample(const Kinematics& kinematics);

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// Learns what a gyroscope gets wrong in proportion to the rate: scale of its axes and their misalignment. Cheap ones
// are off by a percent, which is a degree in every quarter turn that nothing but the gyroscope sees. While scans are
// matched, every turn tells a little of it. docs/math/eskf.md, section 7.

#include <Eigen/Core>
#include <optional>

#include "mmlins/math/so3.hpp"
#include "mmlins/sensor/imu_buffer.hpp"

namespace mmlins::imu {

struct GyroCalibrationConfig {
  double scale_deviation = 0.01;  ///< of scale and misalignment before anything is known [-, rad]
  double turn_on_bias = 0.01;     ///< standard deviation of the bias at the beginning [rad/s]
  double bias_walk = 1e-4;        ///< [rad/s^2/sqrt(Hz)]
  double noise = 1e-3;            ///< of the gyroscope [rad/s/sqrt(Hz)]
};

class GyroCalibration {
 public:
  explicit GyroCalibration(const GyroCalibrationConfig& config);

  /// The sample with what is known by now taken out of its rate.
  [[nodiscard]] sensor::ImuSample apply(sensor::ImuSample sample) const;

  /// Learns from an attitude that scans confirm.
  /// @param imu  samples as apply() returned them, from needs_imu_since() to `time`
  void add(Time time, const math::Matrix3d& R_odom_imu, const sensor::ImuBuffer& imu);
  /// The attitude has not been confirmed for a while: the next one begins anew.
  void interrupt() { last_.reset(); }

  /// Error in proportion to the rate: measured = (I + M) rate + bias.
  [[nodiscard]] math::Matrix3d proportional_error() const;
  /// Standard deviation of each element of it.
  [[nodiscard]] math::Matrix3d deviation() const;
  /// The oldest time for which add() needs samples; nothing if none.
  [[nodiscard]] std::optional<Time> needs_imu_since() const;

 private:
  static constexpr int kSize = 12;  // columns of M, then the bias
  struct Attitude {
    Time time;
    math::Matrix3d R_odom_imu;
  };

  GyroCalibrationConfig config_;
  Eigen::Matrix<double, kSize, 1> x_ = Eigen::Matrix<double, kSize, 1>::Zero();
  Eigen::Matrix<double, kSize, kSize> P_;
  std::optional<Attitude> last_;
};

}  // namespace mmlins::imu

// SPDX-License-Identifier: MIT
#pragma once
// Windows with truth: a smooth motion in closed form, what an IMU reads on it, and poses with the noise that
// they declare.

#include <cmath>

#include "mmlins/imu/frame_change.hpp"
#include "mmlins/initialization/window.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::initialization {

inline constexpr double kImuRate = 200.0;   // [Hz]
inline constexpr double kScanPeriod = 0.1;  // [s]
inline constexpr double kRadians = 3.14159265358979323846 / 180.0;
/// Densities of a Bosch BMI088.
inline const imu::ImuNoise kBmi088{2.4e-4, 1.7e-3, 0.0, 0.0};
inline const Time kStart = time_from_ns(1700000000000000000);

[[nodiscard]] inline Time at(double seconds) { return kStart + from_seconds(seconds); }

/// Sinusoids on top of constant velocity and turn rate, in a world with z up.
struct Motion {
  math::Vector3d velocity{1.5, 0.0, 0.0};          ///< [m/s]
  double yaw_rate = 0.3;                           ///< [rad/s]
  math::Vector3d sway = math::Vector3d::Zero();    ///< amplitude of the position [m]
  math::Vector3d wobble = math::Vector3d::Zero();  ///< amplitude of roll, pitch, yaw [rad]
  math::Vector3d phase = math::Vector3d::Zero();
  double frequency = 6.0;  ///< [rad/s]

  [[nodiscard]] math::Vector3d wave(double t, int derivative) const {
    const double angle = frequency * t + 0.5 * 3.14159265358979323846 * derivative;
    return std::pow(frequency, derivative) * (phase.array() + angle).sin().matrix();
  }
  [[nodiscard]] math::Vector3d euler(double t) const {
    return wobble.cwiseProduct(wave(t, 0)) + math::Vector3d(0.0, 0.0, yaw_rate * t);
  }
  [[nodiscard]] math::Matrix3d R(double t) const {
    const math::Vector3d e = euler(t);
    return (Eigen::AngleAxisd(e.z(), math::Vector3d::UnitZ()) *
            Eigen::AngleAxisd(e.y(), math::Vector3d::UnitY()) *
            Eigen::AngleAxisd(e.x(), math::Vector3d::UnitX()))
        .toRotationMatrix();
  }
  [[nodiscard]] math::Vector3d turn_rate(double t) const {
    const math::Vector3d e = euler(t);
    const math::Vector3d d = wobble.cwiseProduct(wave(t, 1)) + math::Vector3d(0.0, 0.0, yaw_rate);
    return {d.x() - d.z() * std::sin(e.y()),
            d.y() * std::cos(e.x()) + d.z() * std::sin(e.x()) * std::cos(e.y()),
            -d.y() * std::sin(e.x()) + d.z() * std::cos(e.x()) * std::cos(e.y())};
  }
  [[nodiscard]] math::SE3 pose(double t) const {
    return {R(t), velocity * t + sway.cwiseProduct(wave(t, 0))};
  }
  [[nodiscard]] math::Vector3d v(double t) const { return velocity + sway.cwiseProduct(wave(t, 1)); }
  [[nodiscard]] math::Vector3d force(double t) const {
    return R(t).transpose() * (sway.cwiseProduct(wave(t, 2)) + math::Vector3d(0.0, 0.0, imu::kGravity));
  }
  [[nodiscard]] imu::NavState state(double t, const imu::ImuBias& bias) const {
    return {at(t), R(t), pose(t).t, v(t), bias.gyro, bias.accel, math::Vector3d(0.0, 0.0, -imu::kGravity)};
  }
};

/// A motion with accelerations of about `excitation` m/s^2 and turns of about half as many rad/s.
[[nodiscard]] inline Motion random_motion(math::Random& random, double excitation) {
  Motion motion;
  motion.velocity = {random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), random.uniform(-0.3, 0.3)};
  motion.yaw_rate = random.uniform(-0.5, 0.5);
  motion.sway = excitation / (motion.frequency * motion.frequency) * random.normal3();
  motion.wobble = 0.5 * excitation / motion.frequency * random.normal3();
  for (double& phase : motion.phase) phase = random.uniform(0.0, 6.28);
  return motion;
}

/// Readings from `begin` to `end` [s].
[[nodiscard]] inline sensor::ImuSamples read_imu(const Motion& motion, const imu::ImuBias& bias,
                                                 const imu::ImuNoise& noise, double begin, double end,
                                                 math::Random& random) {
  sensor::ImuSamples samples;
  const int count = static_cast<int>(std::lround((end - begin) * kImuRate));
  for (int i = 0; i <= count; ++i) {
    const double t = begin + i / kImuRate;
    samples.push_back({at(t),
                       motion.turn_rate(t) + bias.gyro + std::sqrt(kImuRate) * noise.gyro * random.normal3(),
                       motion.force(t) + bias.accel + std::sqrt(kImuRate) * noise.accel * random.normal3()});
  }
  return samples;
}

struct PoseNoise {
  double position = 0.01;             ///< [m]
  double rotation = 0.05 * kRadians;  ///< [rad]
};

/// Poses every 0.1 s from t = 0; the first is where the frame begins, and is exact.
[[nodiscard]] inline PoseMeasurements measure_poses(const Motion& motion, const math::SE3& T_odom_world,
                                                    int count, const PoseNoise& noise, math::Random& random) {
  PoseMeasurements poses{defining_pose(at(0.0), T_odom_world * motion.pose(0.0))};
  math::Vector6d sigma;
  sigma << math::Vector3d::Constant(noise.rotation), math::Vector3d::Constant(noise.position);
  for (int k = 1; k < count; ++k) {
    math::SE3 T = T_odom_world * motion.pose(kScanPeriod * k);
    T.R = T.R * math::so3_exp(noise.rotation * random.normal3());
    T.t += noise.position * random.normal3();
    poses.push_back(pose_with_covariance(at(kScanPeriod * k), T, sigma.cwiseAbs2().asDiagonal()));
  }
  return poses;
}

/// A window in the frame of its first pose, and the true state at its last.
struct SimulatedWindow {
  Window window;
  imu::NavState first;
  imu::NavState last;
};

[[nodiscard]] inline SimulatedWindow simulate_window(const Motion& motion, const imu::ImuBias& bias,
                                                     int count, const PoseNoise& noise,
                                                     math::Random& random) {
  const double end = kScanPeriod * (count - 1);
  const math::SE3 T_odom_world = motion.pose(0.0).inverse();
  return {{measure_poses(motion, T_odom_world, count, noise, random),
           read_imu(motion, bias, kBmi088, 0.0, end, random), kBmi088},
          imu::transformed(T_odom_world, motion.state(0.0, bias)),
          imu::transformed(T_odom_world, motion.state(end, bias))};
}

/// What the filter knew before a gap of `seconds`, carried to t = 0 by the IMU, in a frame of its own that
/// has drifted from the true one.
[[nodiscard]] inline imu::Estimate carried_over(const Motion& motion, const imu::ImuBias& bias,
                                                double seconds, math::Random& random) {
  imu::ErrorVector sigma;
  sigma << math::Vector3d::Constant(2e-3), math::Vector3d::Constant(0.02), math::Vector3d::Constant(0.02),
      math::Vector3d::Constant(2e-4), math::Vector3d::Constant(0.01), Eigen::Vector2d::Constant(2e-3);
  imu::Estimate estimate;
  estimate.P = sigma.cwiseAbs2().asDiagonal();
  imu::ErrorVector error;
  for (int i = 0; i < imu::kErrorSize; ++i) error(i) = sigma(i) * random.normal();
  estimate.state = imu::plus(motion.state(-seconds, bias), error);
  return imu::propagate(estimate, read_imu(motion, bias, kBmi088, -seconds, 0.0, random), kBmi088).estimate;
}

/// After that gap: a window whose frame begins at the carried-over pose, and the truth in that frame.
[[nodiscard]] inline SimulatedWindow window_after_gap(const Motion& motion, const imu::ImuBias& bias,
                                                      const imu::Estimate& carried, int count,
                                                      const PoseNoise& noise, math::Random& random) {
  const math::SE3 T_odom_world = carried.state.T_odom_imu() * motion.pose(0.0).inverse();
  const double end = kScanPeriod * (count - 1);
  return {{measure_poses(motion, T_odom_world, count, noise, random),
           read_imu(motion, bias, kBmi088, 0.0, end, random), kBmi088},
          imu::transformed(T_odom_world, motion.state(0.0, bias)),
          imu::transformed(T_odom_world, motion.state(end, bias))};
}

/// Angle between the directions of gravity as the IMU sees them [rad].
[[nodiscard]] inline double tilt_error(const imu::NavState& a, const imu::NavState& b) {
  const math::Vector3d down_a = a.R_odom_imu.transpose() * a.gravity_odom;
  const math::Vector3d down_b = b.R_odom_imu.transpose() * b.gravity_odom;
  return std::atan2(down_a.cross(down_b).norm(), down_a.dot(down_b));
}

}  // namespace mmlins::initialization

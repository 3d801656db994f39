// SPDX-License-Identifier: MIT
#include "mmlins/imu/gyro_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::imu {
namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr double kRate = 200.0;

/// A body that turns to and fro about all axes, and a gyroscope with errors.
struct Turner {
  Matrix3d M = Matrix3d::Zero();
  Vector3d bias = Vector3d::Zero();
  double noise = 0.0;  ///< of a reading [rad/s]
  math::Random random{7};
  Matrix3d R_odom_imu = Matrix3d::Identity();

  static Vector3d rate(double t) { return {0.3 * std::sin(2.1 * t), 0.3 * std::cos(1.3 * t), 0.8 * std::sin(0.4 * t)}; }

  sensor::ImuSample sample(double t) {
    sensor::ImuSample s;
    s.time = Time(from_seconds(t));
    s.gyro = (Matrix3d::Identity() + M) * rate(t) + bias;
    for (int i = 0; i < 3; ++i) s.gyro(i) += noise * random.normal();
    return s;
  }
};

GyroCalibration learn(Turner turner, double seconds, const GyroCalibrationConfig& config = {}) {
  GyroCalibration calibration(config);
  sensor::ImuBuffer imu;
  for (int k = 0; k <= static_cast<int>(seconds * kRate); ++k) {
    const double t = k / kRate;
    EXPECT_EQ(imu.add(calibration.apply(turner.sample(t))), sensor::ImuAdmission::kAccepted);
    if (k > 0) turner.R_odom_imu *= math::so3_exp((0.5 * (Turner::rate(t) + Turner::rate(t - 1.0 / kRate)) / kRate).eval());
    if (k % 20 == 0) calibration.add(Time(from_seconds(t)), turner.R_odom_imu, imu);
  }
  return calibration;
}

TEST(GyroCalibration, ScaleAndMisalignmentAreLearntWhileTheBodyTurns) {
  Turner turner;
  turner.M << 0.012, -0.006, 0.009, 0.004, -0.010, 0.013, -0.008, 0.005, 0.011;
  turner.bias = {0.008, -0.006, 0.004};
  turner.noise = 0.002;
  const GyroCalibration calibration = learn(turner, 60.0);
  // Of errors of a percent less than a tenth is left, and the filter knows how much.
  EXPECT_LT((calibration.proportional_error() - turner.M).cwiseAbs().maxCoeff(), 0.001);
  EXPECT_LT(((calibration.proportional_error() - turner.M).cwiseQuotient(calibration.deviation())).cwiseAbs().maxCoeff(), 4.0);
}

TEST(GyroCalibration, AFaultlessGyroscopeIsLeftAlone) {
  const GyroCalibration calibration = learn(Turner{}, 60.0);
  EXPECT_LT(calibration.proportional_error().cwiseAbs().maxCoeff(), 2e-4);
}

TEST(GyroCalibration, WhatNeverTurnsIsNotKnown) {
  GyroCalibration calibration{{}};
  sensor::ImuBuffer imu;
  for (int k = 0; k <= 4000; ++k) {
    sensor::ImuSample s;
    s.time = Time(from_seconds(k / kRate));
    s.gyro = {0.0, 0.0, 0.5 * 1.01};  // turns about z only
    ASSERT_EQ(imu.add(calibration.apply(s)), sensor::ImuAdmission::kAccepted);
    if (k % 20 == 0) calibration.add(s.time, math::so3_exp(Vector3d(0, 0, 0.5 * k / kRate)), imu);
  }
  EXPECT_NEAR(calibration.deviation()(0, 0), 0.01, 1e-3);
  EXPECT_NEAR(calibration.proportional_error()(0, 0), 0.0, 1e-3);
}

TEST(GyroCalibration, AnAttitudeThatIsFarOffTeachesNothing) {
  GyroCalibration calibration{{}};
  sensor::ImuBuffer imu;
  for (int k = 0; k <= 200; ++k) {
    ASSERT_EQ(imu.add({Time(from_seconds(k / kRate)), Vector3d(0, 0, 1), Vector3d::Zero()}), sensor::ImuAdmission::kAccepted);
  }
  calibration.add(Time{}, Matrix3d::Identity(), imu);
  calibration.add(Time(from_seconds(1.0)), math::so3_exp(Vector3d(0.3, 0, 1.0)), imu);
  EXPECT_EQ(calibration.proportional_error(), Matrix3d::Zero());
}

}  // namespace
}  // namespace mmlins::imu

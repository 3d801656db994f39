// SPDX-License-Identifier: MIT
#include "mmlins/sensor/rig.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace mmlins::sensor {
namespace {

std::string error_of(const Rig& rig) {
  const Status status = validate(rig, "my_rig.yaml");
  return status.ok() ? "accepted" : status.error().message;
}

TEST(Rig, TheDefaultIsValid) { EXPECT_EQ(error_of(Rig{}), "accepted"); }

TEST(Rig, TheDefaultsLieInTheirRanges) {
  Rig rig;
  for (const Field& field : rig.fields()) {
    if (const auto* number = std::get_if<double*>(&field.value)) {
      EXPECT_GE(**number, field.range.min) << field.name;
      EXPECT_LE(**number, field.range.max) << field.name;
    }
    EXPECT_FALSE(field.meaning.empty()) << field.name;
  }
}

TEST(Rig, AQuaternionThatIsNoRotationIsRefusedByName) {
  Rig rig;
  rig.q_imu_lidar_xyzw = {0.5, 0.5, 0.5, 0.6};
  EXPECT_EQ(error_of(rig).find("my_rig.yaml: q_imu_lidar_xyzw has length 1.0536"), 0U) << error_of(rig);
  rig.q_imu_lidar_xyzw = {0.0, 0.0, 0.0, 0.0};
  EXPECT_NE(error_of(rig), "accepted");
  rig.q_imu_lidar_xyzw = {0.0, 0.0, 0.0, std::numeric_limits<double>::quiet_NaN()};
  EXPECT_NE(error_of(rig), "accepted");
}

TEST(Rig, AQuaternionOfFewDigitsIsNormalised) {
  Rig rig;
  rig.q_imu_lidar_xyzw = {0.0, 0.0, 0.707, 0.707};
  EXPECT_EQ(error_of(rig), "accepted");
  EXPECT_TRUE((rig.T_imu_lidar().R * rig.T_imu_lidar().R.transpose()).isIdentity(1e-15));  // rounding only
}

TEST(Rig, RangesMustBeInOrder) {
  Rig rig;
  rig.min_range = 50.0;
  rig.max_range = 40.0;
  EXPECT_EQ(error_of(rig), "my_rig.yaml: min_range (50 m) must be below max_range (40 m)");
}

TEST(Rig, ExtrinsicsMapLidarPointsToTheImu) {
  Rig rig;
  rig.p_imu_lidar = {0.1, 0.2, 0.3};
  rig.q_imu_lidar_xyzw = {0.0, 0.0, std::sqrt(0.5), std::sqrt(0.5)};  // a quarter turn to the left
  const math::Vector3d p_imu = rig.T_imu_lidar() * math::Vector3d(1.0, 0.0, 0.0);
  EXPECT_LT((p_imu - math::Vector3d(0.1, 1.2, 0.3)).norm(), 1e-15);  // rounding only
}

}  // namespace
}  // namespace mmlins::sensor

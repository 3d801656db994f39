// SPDX-License-Identifier: MIT
#include "mmlins/odometry/restart.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace mmlins::odometry {
namespace {

using math::SE3;
using math::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

double angle_between(const SE3& a, const SE3& b) {
  return math::so3_log(math::Matrix3d(a.R.transpose() * b.R)).norm() / kDegree;
}

TEST(WithHeadingOf, KeepsTheTiltOfTheOneAndTheHeadingOfTheOther) {
  const SE3 level{math::so3_exp({0.02, -0.03, 0.0}), Vector3d::Zero()};
  const SE3 turned{math::so3_exp({0.0, 0.0, 1.3}), {4.0, 5.0, 6.0}};
  const SE3 both = with_heading_of({turned.R * level.R, turned.t}, level);
  EXPECT_LT((both.R - turned.R * level.R).norm(), 1e-12);
  EXPECT_EQ(both.t, turned.t);
}

// The heading of an upright axis is nothing that a small correction of the tilt may turn about.
TEST(WithHeadingOf, IsNotConfusedByAnImuMountedUpright) {
  for (const double roll : {-2.0, 1.0, 2.0}) {
    const SE3 upright{math::so3_exp({0.0, -90.0 * kDegree, 0.0}), Vector3d::Zero()};
    const SE3 corrected{math::so3_exp(Vector3d(roll, -1.5, 0.0) * kDegree) * upright.R, Vector3d::Zero()};
    EXPECT_LT(angle_between(with_heading_of(upright, corrected), upright), 2.6) << roll;
  }
}

}  // namespace
}  // namespace mmlins::odometry

// SPDX-License-Identifier: MIT
#include "mmlins/odometry/motion_agreement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mmlins::odometry {
namespace {

using math::Vector3d;

const Time kStart = time_from_ns(1700000000000000000);
constexpr double kRadians = std::numbers::pi / 180.0;
// Of the comparison: sums over 300 steps of numbers of size ten, and of times in whole nanoseconds.
constexpr double kRounding = 1e-8;

Time at(double seconds) { return kStart + from_seconds(seconds); }

/// What the body does, in odom axes; attitude and place are nil at first.
struct Body {
  Vector3d acceleration = Vector3d::Zero();  ///< [m/s^2]
  double turn_rate = 0.0;  ///< about the vertical, which is that of acceleration if there is one [rad/s]
};

/// Readings at 200 Hz of a perfect IMU on the body, which accelerates along z or turns about it.
sensor::ImuBuffer imu_of(const Body& body, double seconds) {
  sensor::ImuBuffer imu;
  for (int i = 0; i <= std::lround(seconds * 200.0); ++i) {
    EXPECT_EQ(imu.add({at(0.005 * i), Vector3d(0.0, 0.0, body.turn_rate),
                       body.acceleration + Vector3d(0.0, 0.0, imu::kGravity)}),
              sensor::ImuAdmission::kAccepted);
  }
  return imu;
}

/// Where the filter believes to be, following a LiDAR that sees it in uniform motion.
imu::Estimate seen(double seconds, const Vector3d& v_odom, double sigma = 1e-3) {
  imu::Estimate estimate;
  estimate.state.time = at(seconds);
  estimate.state.v_odom = v_odom;
  estimate.state.p_odom = seconds * v_odom;
  estimate.P = sigma * sigma * imu::ErrorMatrix::Identity();
  return estimate;
}

/// An agreement that has followed the LiDAR at 10 Hz up to and including `seconds`.
MotionAgreement followed(double seconds, const Vector3d& v_odom, double sigma = 1e-3,
                         const TrustConfig& config = {}) {
  MotionAgreement agreement(config, {.gyro = 1e-4, .accel = 1e-3}, from_seconds(0.1));
  for (int i = 0; i <= std::lround(seconds * 10.0); ++i) agreement.add(seen(0.1 * i, v_odom, sigma));
  return agreement;
}

TEST(MotionAgreement, OfAUniformMotionIsPerfect) {
  const Vector3d v(1.0, -2.0, 0.5);
  const auto result = followed(2.0, v).compare(seen(2.1, v), imu_of({}, 2.1));
  ASSERT_TRUE(result);
  EXPECT_LT(result->position, kRounding);
  EXPECT_LT(result->rotation, kRounding);
  EXPECT_FALSE(result->beyond_doubt);
}

// The bag: everything that is seen stands still, but the body accelerates. From rest it comes a t^2 / 2 far.
// The oldest estimate of 2.0 s is the one at 1.0 s, so that at 2.1 s the window is 1.1 s.
TEST(MotionAgreement, IsBrokenByAnAccelerationThatIsNotSeen) {
  const double a = 1.0;
  const auto result = followed(2.0, Vector3d::Zero())
                          .compare(seen(2.1, Vector3d::Zero()), imu_of({Vector3d(0.0, 0.0, a)}, 2.1));
  ASSERT_TRUE(result);
  const double way = 0.5 * a * 1.1 * 1.1;
  EXPECT_NEAR(result->position, way, kRounding);
  EXPECT_LT(result->rotation, kRounding);
  EXPECT_TRUE(result->beyond_doubt);
  EXPECT_LT((result->imu_alone.state.p_odom - Vector3d(0.0, 0.0, way)).norm(), kRounding);
  EXPECT_LT((result->imu_alone.state.v_odom - Vector3d(0.0, 0.0, 1.1 * a)).norm(), kRounding);
  EXPECT_EQ(result->imu_alone.state.time, at(2.1));
}

TEST(MotionAgreement, IsBrokenByATurnThatIsNotSeen) {
  const double rate = 5.0 * kRadians;
  const auto result = followed(2.0, Vector3d::Zero())
                          .compare(seen(2.1, Vector3d::Zero()), imu_of({Vector3d::Zero(), rate}, 2.1));
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->rotation, 1.1 * rate, kRounding);
  EXPECT_LT(result->position, kRounding);
  EXPECT_TRUE(result->beyond_doubt);
}

TEST(MotionAgreement, BearsWhatIsWithinTheLimits) {
  const TrustConfig config;
  const auto of = [&](const Body& body) {
    return followed(2.0, Vector3d::Zero()).compare(seen(2.1, Vector3d::Zero()), imu_of(body, 2.1));
  };
  const double turn = config.max_disagreement_deg * kRadians / 1.1;
  const Vector3d push(0.0, 0.0, 2.0 * config.max_disagreement / (1.1 * 1.1));
  EXPECT_FALSE(of({0.99 * push, 0.0})->beyond_doubt);
  EXPECT_FALSE(of({Vector3d::Zero(), 0.99 * turn})->beyond_doubt);
  // The doubt of an estimate with deviations of 1 mm, 1 mm/s and 1 mrad, and of 1 mm/s^2, adds 3 sigma of
  // less than 5 cm and 0.5 degrees.
  EXPECT_TRUE(of({1.2 * push, 0.0})->beyond_doubt);
  EXPECT_TRUE(of({Vector3d::Zero(), 1.4 * turn})->beyond_doubt);
}

TEST(MotionAgreement, BearsMoreWhenTheImuItselfIsInDoubt) {
  const sensor::ImuBuffer imu = imu_of({Vector3d(0.0, 0.0, 1.0)}, 2.1);
  EXPECT_TRUE(followed(2.0, Vector3d::Zero(), 0.003).compare(seen(2.1, Vector3d::Zero()), imu)->beyond_doubt);
  const auto result = followed(2.0, Vector3d::Zero(), 0.3).compare(seen(2.1, Vector3d::Zero()), imu);
  EXPECT_NEAR(result->position, 0.5 * 1.1 * 1.1, kRounding);
  EXPECT_FALSE(result->beyond_doubt);
}

TEST(MotionAgreement, SaysNothingBeforeAWholeWindow) {
  const sensor::ImuBuffer imu = imu_of({}, 2.0);
  EXPECT_FALSE(MotionAgreement({}, {}, from_seconds(0.1)).compare(seen(1.0, Vector3d::Zero()), imu));
  // The first second is for the velocity to settle.
  EXPECT_FALSE(followed(1.8, Vector3d::Zero()).compare(seen(1.9, Vector3d::Zero()), imu));
  EXPECT_TRUE(followed(1.9, Vector3d::Zero()).compare(seen(2.0, Vector3d::Zero()), imu));
}

TEST(MotionAgreement, SaysNothingWhenTheImuWasSilent) {
  const auto with_silence = [](double from, double to) {
    sensor::ImuBuffer imu;
    for (int i = 0; i <= 420; ++i) {
      if (0.005 * i > from && 0.005 * i < to) continue;
      EXPECT_EQ(imu.add({at(0.005 * i), Vector3d::Zero(), Vector3d(0.0, 0.0, imu::kGravity)}),
                sensor::ImuAdmission::kAccepted);
    }
    return imu;
  };
  const MotionAgreement agreement = followed(2.0, Vector3d::Zero());
  const imu::Estimate now = seen(2.1, Vector3d::Zero());
  EXPECT_FALSE(agreement.compare(now, with_silence(1.5, 1.7)));
  EXPECT_FALSE(agreement.compare(now, with_silence(1.9, 3.0)));
  EXPECT_TRUE(agreement.compare(now, with_silence(1.5, 1.59)));
  EXPECT_TRUE(agreement.compare(now, with_silence(0.5, 0.7)));  // before the window
}

TEST(MotionAgreement, BeginsAnewAfterItWasCleared) {
  MotionAgreement agreement = followed(2.0, Vector3d::Zero());
  agreement.clear();
  EXPECT_FALSE(agreement.needs_imu_since());
  const sensor::ImuBuffer imu = imu_of({}, 5.0);
  EXPECT_FALSE(agreement.compare(seen(2.1, Vector3d::Zero()), imu));
  for (int i = 21; i <= 39; ++i) agreement.add(seen(0.1 * i, Vector3d::Zero()));
  EXPECT_FALSE(agreement.compare(seen(4.0, Vector3d::Zero()), imu));
  agreement.add(seen(4.0, Vector3d::Zero()));
  EXPECT_TRUE(agreement.compare(seen(4.2, Vector3d::Zero()), imu));
}

TEST(MotionAgreement, NeedsTheImuOverItsWindowAndNoLonger) {
  EXPECT_FALSE(followed(-0.1, Vector3d::Zero()).needs_imu_since());
  EXPECT_FALSE(followed(0.5, Vector3d::Zero()).needs_imu_since());
  EXPECT_EQ(*followed(1.5, Vector3d::Zero()).needs_imu_since(), at(1.0));
  EXPECT_EQ(*followed(5.0, Vector3d::Zero()).needs_imu_since(), at(4.0));
  TrustConfig longer;
  longer.agreement_window = 2.5;
  EXPECT_EQ(*followed(5.0, Vector3d::Zero(), 1e-3, longer).needs_imu_since(), at(2.5));
}

}  // namespace
}  // namespace mmlins::odometry

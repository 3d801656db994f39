// SPDX-License-Identifier: MIT
#include "mmlins/odometry/rebuilt_map.hpp"

#include <gtest/gtest.h>

#include <random>

namespace mmlins::odometry {
namespace {

using math::SE3;

/// A room of 16 x 12 x 4 m around the origin of the map, its floor 1 m below.
constexpr double kX = 8.0, kY = 6.0, kBelow = 1.0, kAbove = 3.0;

sensor::Rig rig() {
  sensor::Rig rig;
  rig.range_noise = 0.01;
  return rig;
}

/// What is seen of the room from a pose in it; only what lies at x < x_max.
PlacedPoints seen_from(const SE3& T_map_imu, double x_max = kX) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1.0p-53;
  };
  auto points = std::make_shared<std::vector<Eigen::Vector3f>>();
  for (int i = 0; i < 12000; ++i) {
    const double x = uniform(-kX, kX), y = uniform(-kY, kY), z = uniform(-kBelow, kAbove);
    const math::Vector3d walls[] = {{-kX, y, z}, {kX, y, z},      {x, -kY, z},
                                    {x, kY, z},  {x, y, -kBelow}, {x, y, kAbove}};
    const math::Vector3d p_map = walls[i % 6];
    if (p_map.x() <= x_max) points->push_back((T_map_imu.inverse() * p_map).cast<float>());
  }
  return {points, T_map_imu};
}

SE3 pose(double x, double y, double yaw) { return {math::so3_exp({0.0, 0.0, yaw}), {x, y, 0.0}}; }

/// The back end has the known keyframes this far off.
const SE3 kOff = {math::so3_exp({0.001, -0.001, 0.003}), {0.04, -0.03, 0.02}};

std::vector<PlacedPoints> known(const SE3& T_off) {
  std::vector<PlacedPoints> keyframes;
  for (const SE3& T : {pose(-2.0, 1.0, 0.3), pose(0.0, 1.0, 0.2), pose(2.0, 1.5, -0.4)}) {
    keyframes.push_back({seen_from(T).points_imu, T_off * T});
  }
  return keyframes;
}

std::vector<PlacedPoints> recent() {
  return {seen_from(pose(-1.0, -2.0, 1.0)), seen_from(pose(0.0, -2.0, 0.8))};
}

imu::ErrorMatrix filter_covariance() { return 1e-6 * imu::ErrorMatrix::Identity(); }

double distance_between(const SE3& a, const SE3& b) {
  return (a.t - b.t).norm() + math::so3_log((a.R.transpose() * b.R).eval()).norm();
}

TEST(RebuiltMap, LiesWhereTheRecentKeyframesSeeIt) {
  const auto rebuilt = rebuild_map(known(kOff), recent(), OdometryConfig{}, rig());
  ASSERT_TRUE(rebuilt);
  // Points without noise leave what the prior of 5 cm and 0.2 degrees holds back, and planes fitted to
  // corners.
  EXPECT_LT(distance_between(rebuilt->local.T_map_cells * kOff, {}), 0.003);
}

TEST(RebuiltMap, IsNotMadeOfSurroundingsThatLieElsewhere) {
  EXPECT_FALSE(rebuild_map(known({{}, {0.4, 0.0, 0.0}}), recent(), OdometryConfig{}, rig()));
  EXPECT_FALSE(rebuild_map(known({{}, {30.0, 0.0, 0.0}}), recent(), OdometryConfig{}, rig()));
  EXPECT_FALSE(rebuild_map(known({}), {}, OdometryConfig{}, rig()));
}

TEST(RebuiltMap, OfNothingKnownIsWhatTheRecentKeyframesShow) {
  const auto rebuilt = rebuild_map({}, recent(), OdometryConfig{}, rig());
  ASSERT_TRUE(rebuilt);
  EXPECT_GT(rebuilt->local.map->num_cells(), 0U);
  EXPECT_EQ(distance_between(rebuilt->local.T_map_cells, {}), 0.0);
}

class OfferTest : public testing::Test {
 protected:
  MapOffer::Answer ask(MapOffer& offer) {
    return offer.consider(
        current_, {view_.points_imu ? *view_.points_imu : none_, view_.T_map_imu, filter_covariance()},
        config_, rig());
  }
  static LocalMapInPlace grown(const std::vector<PlacedPoints>& keyframes) {
    LocalMapInPlace local{make_local_map(LocalMapConfig{}, 0.01), {}};
    for (const auto& one : keyframes) local.insert(*one.points_imu, one.T_map_imu);
    return local;
  }

  OdometryConfig config_;
  std::vector<Eigen::Vector3f> none_;
  PlacedPoints view_ = seen_from(pose(0.5, -1.8, 0.7));
  LocalMapInPlace current_ = grown(recent());
};

TEST_F(OfferTest, IsTakenWithTheFirstScanAfterAllThatWasSeenSinceIsIn) {
  auto rebuilt = rebuild_map(known(kOff), recent(), config_, rig());
  ASSERT_TRUE(rebuilt);
  rebuilt->to_come = {seen_from(pose(0.2, -1.9, 0.8)), seen_from(pose(0.4, -1.9, 0.7))};
  const spatial::LocalMap* map = rebuilt->local.map.get();
  MapOffer offer(std::move(*rebuilt));
  EXPECT_EQ(ask(offer), MapOffer::Answer::kNotYet);
  EXPECT_EQ(ask(offer), MapOffer::Answer::kNotYet);
  EXPECT_NE(current_.map.get(), map);
  EXPECT_EQ(ask(offer), MapOffer::Answer::kTaken);
  EXPECT_EQ(current_.map.get(), map);
}

TEST_F(OfferTest, IsLaidUnderTheRobot) {
  // The robot is where the scan says, and the map on offer a little off: what moves is the map.
  LocalMapInPlace off{grown(known({})).map, kOff};
  MapOffer offer({std::move(off), {}});
  ASSERT_EQ(ask(offer), MapOffer::Answer::kTaken);
  EXPECT_LT(distance_between(current_.T_map_cells, {}), 0.003);  // as above
}

TEST_F(OfferTest, StaysWhereItIsIfItIsOffByLessThanAScanTells) {
  const SE3 little{{math::Matrix3d::Identity()}, {0.002, -0.001, 0.001}};
  MapOffer offer({{grown(known({})).map, little}, {}});
  ASSERT_EQ(ask(offer), MapOffer::Answer::kTaken);
  EXPECT_EQ(distance_between(current_.T_map_cells, little), 0.0);
}

TEST_F(OfferTest, IsRefusedIfItExplainsLess) {
  std::vector<PlacedPoints> half;
  for (const auto& one : recent()) half.push_back(seen_from(one.T_map_imu, 0.0));
  const spatial::LocalMap* map = current_.map.get();
  MapOffer offer({grown(half), {}});
  for (int i = 1; i < config_.rebuilt.patience; ++i) EXPECT_EQ(ask(offer), MapOffer::Answer::kNotYet);
  EXPECT_EQ(ask(offer), MapOffer::Answer::kRefused);
  EXPECT_EQ(current_.map.get(), map);
}

TEST_F(OfferTest, GrowsWithWhatGrowsTheMapInUse) {
  MapOffer offer({grown({}), {}});
  for (const auto& one : recent()) offer.insert(*one.points_imu, one.T_map_imu);
  EXPECT_EQ(ask(offer), MapOffer::Answer::kTaken);
}

}  // namespace
}  // namespace mmlins::odometry

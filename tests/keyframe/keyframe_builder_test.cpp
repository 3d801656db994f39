// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/keyframe_builder.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mmlins::keyframe {
namespace {

using math::SE3;
using math::Vector3d;

/// A scan, a tenth of a second after the one before, of points that stand still in the map.
struct Drive {
  KeyframeBuilder builder;
  std::vector<Eigen::Vector3f> points_map;
  int num_scans = 0;

  explicit Drive(const KeyframeConfig& config = {}) : builder(config) {}
  std::optional<Keyframe> scan(const SE3& T_map_imu, int map_id = 0, float intensity = -1.0F) {
    std::vector<Eigen::Vector3f> points_imu;
    for (const auto& p : points_map)
      points_imu.push_back((T_map_imu.inverse() * p.cast<double>()).cast<float>());
    const std::vector<float> intensities(intensity < 0.0F ? 0 : points_imu.size(), intensity);
    return builder.add({map_id, time_from_ns(100'000'000LL * num_scans++), T_map_imu,
                        T_map_imu.R.transpose() * -Vector3d::UnitZ(), points_imu, intensities});
  }
};

SE3 at(double x, double yaw = 0.0) { return {math::so3_exp({0.0, 0.0, yaw}), {x, 0.0, 0.0}}; }

TEST(KeyframeBuilder, MakesOneOfTheFirstScanAndThenOfEachMetre) {
  Drive drive({.distance = 1.0, .angle_deg = 180.0});
  std::vector<double> places;
  for (int i = 0; i <= 30; ++i) {
    if (const auto kf = drive.scan(at(0.15 * i))) places.push_back(kf->T_map_imu.t.x());
  }
  // The first scan at or beyond 1 m after the one before: 1.05 m each.
  ASSERT_EQ(places.size(), 5U);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_NEAR(places[i], 1.05 * static_cast<double>(i), 1e-12);
}

TEST(KeyframeBuilder, MakesOneOfATurnOnTheSpot) {
  Drive drive({.distance = 100.0, .angle_deg = 10.0});
  int count = 0;
  for (int deg = 0; deg <= 90; deg += 3) count += drive.scan(at(0.0, deg * M_PI / 180.0)).has_value() ? 1 : 0;
  EXPECT_EQ(count, 1 + 7);  // every 12 degrees up to 84
}

TEST(KeyframeBuilder, NumbersKeyframesAndKeepsWhatBelongsToThem) {
  Drive drive;
  drive.points_map = {{5, 1, 0}};
  EXPECT_EQ(drive.scan(at(0), 2)->id, 0);
  EXPECT_FALSE(drive.scan(at(0.5), 2));
  const SE3 tilted{math::so3_exp({0.1, 0.0, 0.0}), {1.5, 0.0, 0.0}};
  const auto second = drive.scan(tilted, 2);
  ASSERT_TRUE(second);
  EXPECT_EQ(second->id, 1);
  EXPECT_EQ(second->map_id, 2);
  EXPECT_EQ(second->time, time_from_ns(200'000'000));
  EXPECT_LT((second->T_map_imu.t - tilted.t).norm(), 1e-15);
  EXPECT_LT((tilted.R * second->down_imu + Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(KeyframeBuilder, PutsAllThatWasSeenSinceTheOneBeforeIntoItsOwnFrame) {
  Drive drive({.distance = 1.0, .voxel = 0.2});
  drive.points_map = {{4, 3, 1}};
  ASSERT_TRUE(drive.scan(at(0)));
  drive.points_map = {{-2, 0.5, 0}};  // seen on the way only
  EXPECT_FALSE(drive.scan(at(0.5, 0.05)));
  drive.points_map = {{4, 3, 1}};
  const auto kf = drive.scan(at(1.0, 0.1));
  ASSERT_TRUE(kf);
  ASSERT_EQ(kf->points_imu.size(), 2U);
  const std::vector<Vector3d> expected{{-2, 0.5, 0}, {4, 3, 1}};
  for (std::size_t i = 0; i < 2; ++i) {
    const Vector3d p_map = kf->T_map_imu * kf->points_imu[i].cast<double>();
    // Half a quantum along each axis.
    EXPECT_LT((p_map - expected[i]).cwiseAbs().maxCoeff(), kPointQuantum);
  }
}

TEST(KeyframeBuilder, KeepsOnePointOfEachVoxel) {
  Drive drive({.voxel = 0.2});
  for (int i = 0; i < 100; ++i)
    drive.points_map.emplace_back(5.0F + 1e-4F * static_cast<float>(i), 1.0F, 0.5F);
  const auto kf = drive.scan(at(0));
  ASSERT_TRUE(kf);
  EXPECT_LE(kf->points_imu.size(), 2U);  // 1 cm may lie across one face
}

TEST(KeyframeBuilder, GivesCoordinatesThatAreWholeQuantaWithinReach) {
  Drive drive({.voxel = 0.05});
  for (int i = 0; i < 200; ++i) {
    drive.points_map.emplace_back(0.7317F * static_cast<float>(i), 0.1234F * static_cast<float>(i), 0.0171F);
  }
  const auto kf = drive.scan(at(0.0, 0.3));
  ASSERT_TRUE(kf);
  for (const auto& p : kf->points_imu) {
    for (int axis = 0; axis < 3; ++axis) {
      const double steps = static_cast<double>(p(axis)) / kPointQuantum;
      EXPECT_NEAR(steps, std::round(steps), 0.01);      // floats of up to 131 m are good to 8 micrometres
      EXPECT_LE(std::abs(std::round(steps)), 32767.0);  // 16 bits
    }
  }
  EXPECT_LT(kf->points_imu.size(), 200U);  // the farthest were beyond reach
  EXPECT_GT(kf->points_imu.size(), 150U);
}

TEST(KeyframeBuilder, RoundsIntensitiesAndHasOneForEachPoint) {
  Drive drive;
  drive.points_map = {{5, 1, 0}, {6, 2, 0}};
  EXPECT_EQ(drive.scan(at(0), 0, 41.6F)->intensities, (std::vector<std::uint16_t>{42, 42}));
  EXPECT_EQ(drive.scan(at(2), 0, 1e6F)->intensities, (std::vector<std::uint16_t>{65535, 65535}));
  EXPECT_EQ(drive.scan(at(4))->intensities, (std::vector<std::uint16_t>{0, 0}));
}

TEST(KeyframeBuilder, EndsAMapWithALastKeyframeIfAnythingCameAfterTheOneBefore) {
  Drive drive;
  EXPECT_FALSE(drive.builder.finish());
  ASSERT_TRUE(drive.scan(at(0)));
  EXPECT_FALSE(drive.builder.finish());
  ASSERT_TRUE(drive.scan(at(0)));  // a new map begins with a keyframe again
  EXPECT_FALSE(drive.scan(at(0.4)));
  const auto last = drive.builder.finish();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->id, 2);
  EXPECT_NEAR(last->T_map_imu.t.x(), 0.4, 1e-12);
  ASSERT_TRUE(drive.scan(at(0.4), 1));
}

}  // namespace
}  // namespace mmlins::keyframe

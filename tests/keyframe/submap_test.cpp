// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/submap.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mmlins::keyframe {
namespace {

using math::Vector3d;

math::Matrix3d rotation(const Vector3d& w) { return math::so3_exp(w); }

/// A keyframe at a place of a map that is itself tilted: `up_map` is up in it.
KeyframePointer keyframe_at(int id, const math::SE3& T_map_imu, const Vector3d& up_map,
                            const std::vector<Vector3d>& points_map = {}) {
  Keyframe kf;
  kf.id = id;
  kf.map_id = 3;
  kf.time = time_from_ns(1'000'000'000LL * id);
  kf.T_map_imu = T_map_imu;
  kf.down_imu = -(T_map_imu.R.transpose() * up_map);
  for (const Vector3d& p : points_map) kf.points_imu.push_back((T_map_imu.inverse() * p).cast<float>());
  return std::make_shared<const Keyframe>(std::move(kf));
}

Keyframes straight_drive(int count, double step) {
  Keyframes keyframes;
  for (int i = 0; i < count; ++i) {
    keyframes.push_back(keyframe_at(i, {math::Matrix3d::Identity(), {step * i, 0, 0}}, Vector3d::UnitZ()));
  }
  return keyframes;
}

TEST(Submap, IsLevelHoweverTheImuAndTheMapAreTilted) {
  const Vector3d up_map = rotation({0.2, -0.3, 0.0}) * Vector3d::UnitZ();
  Keyframes keyframes;
  for (int i = 0; i < 5; ++i) {
    const math::SE3 T_map_imu{rotation({0.3, 0.1 * i, 1.0}), {1.0 * i, 2.0, 0.5}};
    keyframes.push_back(keyframe_at(i, T_map_imu, up_map));
  }
  const Submap submap = build_submap(keyframes, {});
  EXPECT_LT((submap.T_map_submap.R.col(2) - up_map).norm(), 1e-12);
  EXPECT_LT((submap.T_map_submap.R.transpose() * submap.T_map_submap.R - math::Matrix3d::Identity()).norm(),
            1e-12);
  EXPECT_EQ(submap.id, 2);
  EXPECT_LT((submap.T_map_submap.t - Vector3d(2.0, 2.0, 0.5)).norm(), 1e-12);
  // The heading is that of the IMU's x axis: no component to its left.
  const Vector3d x_submap = submap.T_map_submap.R.transpose() * keyframes[2]->T_map_imu.R.col(0);
  EXPECT_NEAR(x_submap.y(), 0.0, 1e-12);
  EXPECT_GT(x_submap.x(), 0.0);
}

TEST(Submap, PutsOnePointIntoEachVoxelAtTheMeanOfWhatWasSeenThere) {
  const Vector3d a(5.05, 1.1, 0.2), b(5.15, 1.1, 0.2);
  const Keyframes keyframes{keyframe_at(0, {}, Vector3d::UnitZ(), {a, {9.1, 0.1, 0.1}}),
                            keyframe_at(1, {rotation({0, 0, 1.2}), {0.1, 0, 0}}, Vector3d::UnitZ(), {b})};
  const Submap submap = build_submap(keyframes, {.voxel = 0.25});
  ASSERT_EQ(submap.points.size(), 2U);
  const Vector3d mean_map = submap.T_map_submap * submap.points[0].cast<double>();
  EXPECT_LT((mean_map - 0.5 * (a + b)).norm(), 1e-5);  // single precision at 5 m
  EXPECT_EQ(submap.views[0], 0);
  ASSERT_EQ(submap.viewpoints.size(), 2U);
}

TEST(Submap, LeavesOutWhatIsFartherThanTheRadius) {
  const Keyframes keyframes{keyframe_at(0, {}, Vector3d::UnitZ(), {{9.0, 0, 0}, {11.0, 0, 0}})};
  EXPECT_EQ(build_submap(keyframes, {.radius = 10.0}).points.size(), 1U);
}

TEST(Submap, DoesNotDependOnWhereTheMapHasItsOrigin) {
  const math::SE3 T_new_old{rotation({0, 0, 0.7}), {10, -20, 3}};
  Keyframes keyframes, moved;
  for (int i = 0; i < 4; ++i) {
    const math::SE3 T_map_imu{rotation({0, 0, 0.1 * i}), {1.0 * i, 0, 0}};
    const std::vector<Vector3d> points{{3.1, 2.2, 1.3}, {8.4, -1.1, 0.6}};
    keyframes.push_back(keyframe_at(i, T_map_imu, Vector3d::UnitZ(), points));
    Keyframe other = *keyframes.back();
    other.T_map_imu = T_new_old * other.T_map_imu;
    moved.push_back(std::make_shared<const Keyframe>(other));
  }
  const Submap a = build_submap(keyframes, {}), b = build_submap(moved, {});
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i) EXPECT_LT((a.points[i] - b.points[i]).norm(), 1e-5F);
}

TEST(SplitByTravel, EachRangeIsAsLongAsAskedAndOverlapsTheOneBeforeByHalf) {
  const Keyframes keyframes = straight_drive(101, 0.5);
  const auto ranges = split_by_travel(keyframes, {.travel = 10.0});
  ASSERT_GE(ranges.size(), 8U);
  EXPECT_EQ(ranges.back().last, keyframes.size());
  for (std::size_t i = 0; i + 1 < ranges.size(); ++i) {
    EXPECT_EQ(ranges[i].last - ranges[i].first, 21U);  // 20 steps of 0.5 m
    EXPECT_EQ(ranges[i + 1].first - ranges[i].first, 10U);
  }
}

TEST(SplitByTravel, NoRangeCrossesFromOneMapToAnother) {
  Keyframes keyframes = straight_drive(30, 1.0);
  for (std::size_t i = 13; i < 30; ++i) {
    Keyframe other = *keyframes[i];
    other.map_id = 4;
    keyframes[i] = std::make_shared<const Keyframe>(other);
  }
  std::vector<bool> covered(30, false);
  for (const KeyframeRange& range : split_by_travel(keyframes, {.travel = 8.0})) {
    EXPECT_EQ(keyframes[range.first]->map_id, keyframes[range.last - 1]->map_id);
    for (std::size_t i = range.first; i < range.last; ++i) covered[i] = true;
  }
  for (const bool c : covered) EXPECT_TRUE(c);
}

}  // namespace
}  // namespace mmlins::keyframe

// SPDX-License-Identifier: MIT
#include "mmlins/mapping/place_finder.hpp"

#include <gtest/gtest.h>

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;

/// Between what odometry looks for within a map, and what it looks for between maps.
constexpr double kAside = 14.0;  // [m]

SE3 at(double y) { return {math::Matrix3d::Identity(), {0.0, y, 0.0}}; }

/// A known place, and another one 14 m aside, in a map that the IMU carried the pose to, known to decimetres.
struct Aside {
  Aside() : graph({}, {}), library({}, {}, store), finder({}, graph, library) {
    graph.begin_map({0, {}, std::nullopt});
    add_keyframe(0, 0);
    graph.begin_map({1, at(kAside), covariance_of(0.5, 0.1)});
    add_keyframe(1, 1);
    SubmapRecord known;
    library.add(known, nullptr);
  }

  void add_keyframe(int id, int map) {
    keyframe::Keyframe kf;
    kf.id = id;
    kf.map_id = map;
    graph.add(kf, 1e-6 * Matrix6d::Identity());
  }

  /// Where the finder looks for what the young map has seen.
  [[nodiscard]] std::vector<PlaceCandidate> predicted() {
    SubmapRecord young;
    young.id = young.first_keyframe = young.last_keyframe = young.map_id = 1;
    return finder.predicted(young, {});
  }

  MapGraph graph;
  keyframe::MemoryKeyframeStore store;
  SubmapLibrary library;
  PlaceFinder finder;
};

TEST(PlaceFinder, LooksFartherForAMapThatIsNotJoinedYet) {
  Aside aside;
  const auto apart = aside.predicted();
  ASSERT_EQ(apart.size(), 1U);
  EXPECT_EQ(apart[0].index, 0U);
  EXPECT_NEAR((apart[0].starts.front().t - at(kAside).t).norm(), 0.0, 1e-9);
  aside.graph.join(1, 0);
  EXPECT_TRUE(aside.predicted().empty());
}

TEST(PlaceFinder, PredictsNothingOfAMapThatNothingLeadsTo) {
  Aside aside;
  aside.graph.begin_map({2, at(1.0), std::nullopt});
  aside.add_keyframe(2, 2);
  SubmapRecord lost;
  lost.id = lost.first_keyframe = lost.last_keyframe = lost.map_id = 2;
  EXPECT_TRUE(aside.finder.predicted(lost, {}).empty());
}

}  // namespace
}  // namespace mmlins::mapping

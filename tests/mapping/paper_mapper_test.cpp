// SPDX-License-Identifier: MIT
#include "mmlins/mapping/paper_mapper.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/mapping/simulated_maps.hpp"

namespace mmlins::mapping {
namespace {

using mapping_test::SimulatedMap;

/// Two maps of the campus; the second, over a part of the first, is said to lie 22 m away, turned by 40
/// degrees.
const std::vector<SimulatedMap>& campus() {
  static const std::vector<SimulatedMap> maps = [] {
    const place_test::Site site(sim::SceneKind::kCampus);
    std::vector<SimulatedMap> made;
    made.push_back(mapping_test::make_map(site.drive({.from = 0.0, .duration = 15.0}), 0, 0));
    made.push_back(mapping_test::make_map(site.drive({.from = 5.0, .duration = 8.0, .seed = 2}), 1,
                                          static_cast<int>(made[0].keyframes.size())));
    const math::SE3 wrong{math::so3_exp({0.0, 0.0, 0.7}), {20.0, -10.0, 1.0}};
    made[1].T_world_map = wrong * made[1].T_world_map;
    return made;
  }();
  return maps;
}

struct Mapped {
  Mapped(const MappingConfig& config, const std::vector<SimulatedMap>& maps)
      : mapper(make_mapper(config, store)) {
    mapping_test::feed(*mapper, store, maps);
  }
  keyframe::MemoryKeyframeStore store;
  std::unique_ptr<BackEndMapper> mapper;
};

/// Without loops, which would be similarity constraints under another name.
MappingConfig after_paper(FusionKind fusion = FusionKind::kPaper) {
  MappingConfig config;
  config.fusion = fusion;
  config.paper.exclude_recent = 10000;
  config.paper.loop_every = 10000;
  return config;
}

// ICP from point to point between sparse rings is good to some decimetres.
constexpr double kIcpError = 0.4;  // [m]

int num_that_count(const BackEndMapper& mapper) {
  return static_cast<int>(std::count_if(mapper.closures().begin(), mapper.closures().end(),
                                        [](const Closure& c) { return c.state == ClosureState::kCounts; }));
}

/// How far the graph is from what a closure says [rad, m].
double disagreement(const BackEndMapper& mapper, const Closure& closure) {
  const math::SE3 T_target_source = mapper.map_graph().T_world_keyframe(closure.target).inverse() *
                                    mapper.map_graph().T_world_keyframe(closure.source);
  return math::se3_log(closure.T_target_source.inverse() * T_target_source).norm();
}

TEST(PaperMapper, MakesTwoMapsOneByEnhancedConstraints) {
  const Mapped run(after_paper(), campus());
  ASSERT_EQ(run.mapper->merges().size(), 1U);
  const Merge& merge = run.mapper->merges().front();
  EXPECT_EQ(merge.world, 1);
  EXPECT_EQ(merge.into, 0);
  EXPECT_FALSE(merge.prior_known);
  EXPECT_EQ(run.mapper->map_graph().world_of(1), 0);
  EXPECT_EQ(merge.closures.size() + merge.enhancing.size(), 6U);
  EXPECT_EQ(num_that_count(*run.mapper), 6);
  EXPECT_LT(mapping_test::largest_error(*run.mapper, campus()[0]), kIcpError);
  EXPECT_LT(mapping_test::largest_error(*run.mapper, campus()[1]), kIcpError);
  // Six that differ cannot all be met exactly.
  EXPECT_GT(disagreement(*run.mapper, run.mapper->closures().front()), 1e-6);
}

TEST(PaperMapper, PutsTheMapWhereASingleConstraintSays) {
  const Mapped run(after_paper(FusionKind::kSingle), campus());
  ASSERT_EQ(run.mapper->merges().size(), 1U);
  EXPECT_TRUE(run.mapper->merges().front().enhancing.empty());
  ASSERT_EQ(num_that_count(*run.mapper), 1);
  EXPECT_LT(disagreement(*run.mapper, run.mapper->closures().front()), 1e-9);
  EXPECT_LT(mapping_test::largest_error(*run.mapper, campus()[1]), kIcpError);
}

TEST(PaperMapper, LeavesTheInitialTransformAsItIsWithoutOptimisation) {
  MappingConfig config = after_paper();
  config.paper.optimize = false;
  config.paper.exclude_recent = 50;
  config.paper.loop_every = 5;
  const Mapped run(config, campus());
  ASSERT_EQ(run.mapper->merges().size(), 1U);
  EXPECT_EQ(num_that_count(*run.mapper), 6);  // there, but not used
  EXPECT_LT(disagreement(*run.mapper, run.mapper->closures().front()), 1e-9);
  EXPECT_LT(mapping_test::largest_error(*run.mapper, campus()[1]), kIcpError);
}

// Its Eq. (3).
TEST(PaperMapper, WaitsForMoreHitsInARowThanTheThreshold) {
  MappingConfig config = after_paper();
  config.paper.consecutive_hits = 8;
  const Mapped run(config, campus());
  ASSERT_EQ(run.mapper->merges().size(), 1U);
  // The first keyframe that can be the ninth hit.
  EXPECT_GE(run.mapper->merges().front().num_keyframes, static_cast<int>(campus()[0].keyframes.size()) + 9);
  config.paper.consecutive_hits = 99;  // more than the map has keyframes
  EXPECT_TRUE(Mapped(config, campus()).mapper->merges().empty());
}

TEST(PaperMapper, RefusesAnInitialTransformThatDoesNotFit) {
  MappingConfig config = after_paper();
  config.paper.initial.max_fitness = 1e-6;
  const Mapped run(config, campus());
  EXPECT_TRUE(run.mapper->merges().empty());
  EXPECT_FALSE(run.mapper->closures().empty());
  EXPECT_EQ(num_that_count(*run.mapper), 0);
  EXPECT_EQ(run.mapper->map_graph().world_of(1), 1);
}

TEST(PaperMapper, BelievesAllLinksAlikeAndNothingElse) {
  std::vector<SimulatedMap> maps = campus();
  maps[1].gap_covariance = math::Matrix6d::Identity();
  const Mapped run(after_paper(), maps);
  const graph::PoseGraph& graph = run.mapper->map_graph().graph();
  EXPECT_TRUE(graph.gravity.empty());
  for (const graph::Edge& edge : graph.edges) {
    EXPECT_NE(edge.kind, graph::EdgeKind::kGap);
    const bool is_link = edge.kind == graph::EdgeKind::kOdometry;
    EXPECT_NEAR(edge.information(0, 0) * (is_link ? 1e-6 : 2e-4), 1.0, 1e-9);
    EXPECT_NEAR(edge.information(5, 5) * (is_link ? 1e-4 : 2e-4), 1.0, 1e-9);
  }
  // The prior of the map that moved is gone: one anchor alone is fixed.
  ASSERT_EQ(graph.anchors.size(), 2U);
  EXPECT_TRUE(graph.anchors[0].fixed);
  EXPECT_FALSE(graph.anchors[1].fixed);
}

TEST(PaperMapper, WakesTwoMapsOneAfterTheOther) {
  const place_test::Site site(sim::SceneKind::kCampus);
  std::vector<SimulatedMap> maps;
  maps.push_back(mapping_test::make_map(site.drive({.from = 0.0, .duration = 10.0}), 0, 0));
  maps.push_back(mapping_test::make_map(site.drive({.from = 15.0, .duration = 10.0, .seed = 2}), 1,
                                        static_cast<int>(maps[0].keyframes.size())));
  maps.push_back(mapping_test::make_map(site.drive({.from = 4.0, .duration = 17.0, .seed = 3}), 2,
                                        maps[1].keyframes.back()->id + 1));
  const math::SE3 wrong{math::so3_exp({0.0, 0.0, -0.5}), {0.0, 30.0, 0.0}};
  maps[1].T_world_map = wrong * maps[1].T_world_map;
  maps[2].T_world_map = wrong * wrong * maps[2].T_world_map;
  const Mapped run(after_paper(), maps);
  ASSERT_EQ(run.mapper->merges().size(), 2U);
  EXPECT_EQ(run.mapper->merges()[0].world, 2);
  EXPECT_EQ(run.mapper->merges()[0].into, 0);
  // Then the active map is that of the first; the other is put into its frame.
  EXPECT_EQ(run.mapper->merges()[1].world, 1);
  EXPECT_EQ(run.mapper->merges()[1].into, 0);
  for (const SimulatedMap& map : maps) EXPECT_LT(mapping_test::largest_error(*run.mapper, map), kIcpError);
}

TEST(PaperMapper, ClosesLoopsOfTheActiveMap) {
  const place_test::Site site(sim::SceneKind::kCampus);
  // Along the course, and the same way again: one map, as if one had been carried back in between.
  keyframe::Keyframes drive = site.drive({.duration = 8.0});
  const keyframe::Keyframes again = site.drive({.duration = 8.0, .seed = 2});
  drive.insert(drive.end(), again.begin(), again.end());
  const SimulatedMap map = mapping_test::make_map(drive, 0, 0, mapping_test::steady_drift(0.002, 1e-4));
  MappingConfig config = after_paper();
  config.paper.exclude_recent = 20;
  config.paper.loop_every = 3;
  const Mapped run(config, {map});
  EXPECT_GT(num_that_count(*run.mapper), 0);
  EXPECT_LT(mapping_test::largest_error(*run.mapper, map), kIcpError);
  config.paper.exclude_recent = 1000;
  EXPECT_EQ(num_that_count(*Mapped(config, {map}).mapper), 0);
}

}  // namespace
}  // namespace mmlins::mapping

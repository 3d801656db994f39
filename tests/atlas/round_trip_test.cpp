// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/atlas_keyframe_store.hpp"
#include "tests/atlas/example.hpp"

namespace mmlins::atlas {
namespace {

template <typename Value>
bool same_bits(const Value& a, const Value& b) {
  return std::memcmp(a.data(), b.data(), sizeof(Value)) == 0;
}
bool same_bits(const SE3& a, const SE3& b) { return same_bits(a.R, b.R) && same_bits(a.t, b.t); }

template <typename Item>
bool same_list(const std::vector<Item>& a, const std::vector<Item>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Item)) == 0);
}

void expect_same(const keyframe::Keyframe& a, const keyframe::Keyframe& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.map_id, b.map_id);
  EXPECT_EQ(a.time, b.time);
  EXPECT_TRUE(same_bits(a.T_map_imu, b.T_map_imu));
  EXPECT_TRUE(same_bits(a.down_imu, b.down_imu));
  EXPECT_TRUE(same_list(a.points_imu, b.points_imu));
  EXPECT_TRUE(same_list(a.intensities, b.intensities));
}

Atlas created(const TemporaryFolder& folder, const AtlasOptions& options = {}) {
  auto atlas = Atlas::create(folder / "atlas", options);
  EXPECT_TRUE(atlas.ok()) << atlas.error().message;
  return std::move(atlas).value();
}

Atlas opened(const TemporaryFolder& folder, Access access = Access::kRead) {
  auto atlas = Atlas::open(folder / "atlas", access);
  EXPECT_TRUE(atlas.ok()) << atlas.error().message;
  return std::move(atlas).value();
}

TEST(Atlas, GivesBackKeyframesBitForBit) {
  const TemporaryFolder folder;
  keyframe::Keyframe odd = example_keyframe(30, 1);
  const auto largest = static_cast<float>(32767 * keyframe::kPointQuantum);
  odd.points_imu = {{0.0F, -0.0F, largest}, {-largest, -0.0F, 0.0F}};
  odd.intensities = {0, 65535};
  keyframe::Keyframe empty = example_keyframe(31, 1, 0);
  {
    Atlas atlas = created(folder);
    for (int id = 0; id < 30; ++id) ASSERT_TRUE(atlas.add_keyframe(example_keyframe(id, id / 15)).ok());
    ASSERT_TRUE(atlas.add_keyframe(odd).ok());
    ASSERT_TRUE(atlas.add_keyframe(empty).ok());
    expect_same(*atlas.load_keyframe(31), empty);  // not committed yet
    ASSERT_TRUE(atlas.commit().ok());
  }
  const Atlas atlas = opened(folder);
  for (int id = 0; id < 30; ++id) expect_same(*atlas.load_keyframe(id), example_keyframe(id, id / 15));
  expect_same(*atlas.load_keyframe(30), odd);
  expect_same(*atlas.load_keyframe(31), empty);
  EXPECT_FALSE(atlas.load_keyframe(32).ok());
  const auto rows = atlas.keyframes();
  ASSERT_EQ(rows->size(), 32U);
  EXPECT_EQ(atlas.keyframes_of(1)->size(), 17U);
  const KeyframeRow& row = (*rows)[7];
  EXPECT_EQ(row.id, 7);
  EXPECT_EQ(row.num_points, 50);
  EXPECT_TRUE(same_bits(row.T_map_imu, example_keyframe(7, 0).T_map_imu));
  EXPECT_TRUE(same_bits(row.T_map_imu_optimised, row.T_map_imu));
  EXPECT_TRUE(same_bits(row.down_imu, example_keyframe(7, 0).down_imu));
}

TEST(Atlas, RefusesPointsThatItCouldNotGiveBack) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  for (const float bad : {0.001F, 131.5F, -200.0F, std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity()}) {
    keyframe::Keyframe kf = example_keyframe(1, 0);
    kf.points_imu[3].y() = bad;
    const Status status = atlas.add_keyframe(kf);
    ASSERT_FALSE(status.ok()) << bad;
    EXPECT_NE(status.error().message.find("keyframe 1"), std::string::npos);
  }
  keyframe::Keyframe kf = example_keyframe(1, 0);
  kf.intensities.pop_back();
  EXPECT_FALSE(atlas.add_keyframe(kf).ok());
  EXPECT_TRUE(atlas.keyframes()->empty());
  EXPECT_TRUE(atlas.add_keyframe(example_keyframe(1, 0)).ok());
  EXPECT_FALSE(atlas.add_keyframe(example_keyframe(1, 0)).ok());
}

TEST(Atlas, GivesBackMapsEdgesGravityAndPlaces) {
  const TemporaryFolder folder;
  {
    Atlas atlas = created(folder);
    ASSERT_TRUE(atlas.add_map(example_map(0)).ok());
    ASSERT_TRUE(atlas.add_edge(example_edge(0, 1)).ok());
    const auto loop = atlas.add_edge(example_edge(9, 2, graph::EdgeKind::kLoop));
    ASSERT_TRUE(atlas.set_edge_weight({*loop, 0.0}).ok());
    ASSERT_TRUE(atlas.add_gravity({4, example_pose(4).R.col(2), 0.1 / 3.0}).ok());
    ASSERT_TRUE(atlas.add_place(example_place(0, 5)).ok());
    PlaceRow nothing_seen;
    nothing_seen.submap_id = 6;
    ASSERT_TRUE(atlas.add_place(nothing_seen).ok());
    MapRow map = example_map(0);
    map.why_ended = "blocked";
    ASSERT_TRUE(atlas.update_map(map).ok());
  }  // which commits
  const Atlas atlas = opened(folder);
  const auto maps = atlas.maps();
  ASSERT_EQ(maps->size(), 1U);
  EXPECT_EQ((*maps)[0].why_ended, "blocked");
  EXPECT_EQ((*maps)[0].beginning, "at rest");
  EXPECT_EQ((*maps)[0].begin, example_map(0).begin);
  EXPECT_EQ((*maps)[0].last, example_map(0).last);
  EXPECT_TRUE(same_bits((*maps)[0].T_world_map, example_map(0).T_world_map));
  const auto edges = atlas.edges();
  ASSERT_EQ(edges->size(), 2U);
  const EdgeRow& loop = (*edges)[1];
  const EdgeRow truth = example_edge(9, 2, graph::EdgeKind::kLoop);
  EXPECT_EQ(loop.edge.from, 9);
  EXPECT_EQ(loop.edge.to, 2);
  EXPECT_EQ(loop.edge.kind, graph::EdgeKind::kLoop);
  EXPECT_TRUE(loop.edge.robust);
  EXPECT_EQ(loop.edge.provenance, 7);
  EXPECT_TRUE(same_bits(loop.edge.T_from_to, truth.edge.T_from_to));
  EXPECT_TRUE(same_bits(loop.edge.information, truth.edge.information));
  EXPECT_EQ(loop.weight, 0.0);
  EXPECT_EQ((*edges)[0].weight, 1.0);
  EXPECT_EQ(loop.evidence, truth.evidence);
  const auto gravity = atlas.gravity();
  ASSERT_EQ(gravity->size(), 1U);
  EXPECT_EQ((*gravity)[0].keyframe_id, 4);
  EXPECT_EQ((*gravity)[0].up_imu, Vector3d(example_pose(4).R.col(2)));
  EXPECT_EQ((*gravity)[0].sigma, 0.1 / 3.0);
  const auto places = atlas.places();
  ASSERT_EQ(places->size(), 2U);
  const PlaceRow place = example_place(0, 5);
  EXPECT_TRUE(same_bits((*places)[0].T_map_submap, place.T_map_submap));
  EXPECT_EQ((*places)[0].keyframe_ids, place.keyframe_ids);
  EXPECT_EQ((*places)[0].footprint.ground, -1.3F);
  EXPECT_TRUE(same_list((*places)[0].footprint.structure, place.footprint.structure));
  EXPECT_TRUE((*places)[1].keyframe_ids.empty());
}

TEST(Atlas, CommitsAMergeWithItsEdgesPosesAndWorlds) {
  const TemporaryFolder folder;
  {
    Atlas atlas = created(folder);
    for (int id : {0, 1}) {
      ASSERT_TRUE(atlas.add_map(example_map(id)).ok());
      ASSERT_TRUE(atlas.add_keyframe(example_keyframe(id, id)).ok());
    }
    MergeRow merge;
    merge.time = time_from_ns(5);
    merge.map = 1;
    merge.kind = "recognised";
    merge.evidence = "{}";
    merge.T_before = example_pose(1);
    merge.T_after = example_pose(2);
    GraphChange change;
    change.new_edges = {example_edge(1, 0, graph::EdgeKind::kMerge),
                        example_edge(0, 1, graph::EdgeKind::kGap)};
    change.T_map_imu_optimised = {{1, example_pose(3)}};
    change.T_world_map = {{1, example_pose(4)}};
    change.worlds = {{1, 0}};
    change.new_merges = {merge};
    const auto committed = atlas.apply(change);
    ASSERT_TRUE(committed.ok()) << committed.error().message;
    ASSERT_EQ(committed->edge_ids.size(), 2U);
    GraphChange undo;
    undo.weights = {{committed->edge_ids[0], 0.0}};
    undo.new_merges = {merge};
    undo.undone_merges = {{committed->merge_ids.at(0), R"({"why":1})"}};
    ASSERT_TRUE(atlas.apply(undo).ok());
  }
  const Atlas atlas = opened(folder);
  const auto merges = atlas.merges();
  ASSERT_EQ(merges->size(), 2U);
  EXPECT_TRUE((*merges)[0].undone);
  EXPECT_EQ((*merges)[0].evidence, R"({"why":1})");
  EXPECT_FALSE((*merges)[1].undone);
  EXPECT_EQ((*merges)[1].kind, "recognised");
  EXPECT_EQ((*merges)[1].time, time_from_ns(5));
  EXPECT_TRUE(same_bits((*merges)[1].T_before, example_pose(1)));
  EXPECT_TRUE(same_bits((*merges)[1].T_after, example_pose(2)));
  const auto keyframes = atlas.keyframes();
  EXPECT_TRUE(same_bits((*keyframes)[1].T_map_imu_optimised, example_pose(3)));
  EXPECT_TRUE(same_bits((*keyframes)[1].T_map_imu, example_keyframe(1, 1).T_map_imu));
  EXPECT_EQ((*atlas.maps())[1].world, 0);
  EXPECT_TRUE(same_bits((*atlas.maps())[1].T_world_map, example_pose(4)));
  EXPECT_EQ((*atlas.edges())[0].weight, 0.0);
  EXPECT_EQ((*atlas.edges())[1].weight, 1.0);
}

TEST(Atlas, LetsAMapThatWasLeftActiveFallAsleep) {
  const TemporaryFolder folder;
  {
    Atlas atlas = created(folder);
    ASSERT_TRUE(atlas.add_map(example_map(1)).ok());
    ASSERT_TRUE(atlas.add_keyframe(example_keyframe(90, 1)).ok());
  }
  EXPECT_EQ((*opened(folder).maps())[0].state, MapState::kActive);
  const Atlas atlas = opened(folder, Access::kWrite);
  const MapRow map = (*atlas.maps())[0];
  EXPECT_EQ(map.state, MapState::kSleeping);
  EXPECT_EQ(map.why_ended, "the program ended");
  EXPECT_EQ(map.last, example_keyframe(90, 1).time);
}

TEST(Atlas, HasOneWriterAndAnyNumberOfReaders) {
  const TemporaryFolder folder;
  Atlas writer = created(folder);
  ASSERT_TRUE(writer.add_keyframe(example_keyframe(1, 0)).ok());
  EXPECT_TRUE(opened(folder).keyframes()->empty());
  ASSERT_TRUE(writer.commit().ok());
  Atlas reader = opened(folder);
  EXPECT_EQ(reader.keyframes()->size(), 1U);
  EXPECT_FALSE(reader.add_map(example_map(0)).ok());
  const auto second = Atlas::open(folder / "atlas", Access::kWrite);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("another process"), std::string::npos);
  EXPECT_FALSE(Atlas::create(folder / "atlas").ok());
}

TEST(Atlas, CommitsByItselfAfterAsManyKeyframesAsItWasTold) {
  const TemporaryFolder folder;
  Atlas writer = created(folder, {.batch_keyframes = 3});
  for (int id = 0; id < 8; ++id) ASSERT_TRUE(writer.add_keyframe(example_keyframe(id, 0)).ok());
  EXPECT_EQ(opened(folder).keyframes()->size(), 6U);
}

TEST(AtlasKeyframeStore, GivesTheSameKeyframesWhateverTheBudget) {
  const std::size_t one = size_in_memory(example_keyframe(1, 0));
  for (const std::size_t budget : {std::size_t{0}, one / 2, 3 * one, 1000 * one}) {
    const TemporaryFolder folder;
    Atlas atlas = created(folder, {.chunk_bytes = 2000});  // several chunk files
    AtlasKeyframeStore store(atlas, budget, [](int) { return true; });
    for (int id = 0; id < 20; ++id) {
      ASSERT_TRUE(atlas.add_keyframe(example_keyframe(id, 0)).ok());
      ASSERT_TRUE(store.add(std::make_shared<const keyframe::Keyframe>(example_keyframe(id, 0))).ok());
    }
    math::Random random(5);
    for (int i = 0; i < 100; ++i) {
      const int id = static_cast<int>(random.bits() % 20);
      const auto loaded = store.load(id);
      ASSERT_TRUE(loaded.ok()) << loaded.error().message;
      expect_same(**loaded, example_keyframe(id, 0));
      EXPECT_LE(store.bytes_kept(), budget);
    }
    EXPECT_FALSE(store.load(20).ok());
  }
}

TEST(AtlasKeyframeStore, LetsNothingGoThatIsNotOnDisk) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  const std::size_t one = size_in_memory(example_keyframe(1, 0));
  int num_on_disk = 0;
  AtlasKeyframeStore store(atlas, 2 * one, [&](int id) { return id < num_on_disk; });
  for (int id = 0; id < 10; ++id) {
    ASSERT_TRUE(store.add(std::make_shared<const keyframe::Keyframe>(example_keyframe(id, 0))).ok());
  }
  EXPECT_FALSE(store.add(std::make_shared<const keyframe::Keyframe>(example_keyframe(3, 0))).ok());
  for (int id = 0; id < 10; ++id) expect_same(**store.load(id), example_keyframe(id, 0));
  for (; num_on_disk < 10; ++num_on_disk) ASSERT_TRUE(atlas.add_keyframe(example_keyframe(num_on_disk, 0)).ok());
  ASSERT_TRUE(atlas.add_keyframe(example_keyframe(10, 0)).ok());
  ++num_on_disk;
  ASSERT_TRUE(store.add(std::make_shared<const keyframe::Keyframe>(example_keyframe(10, 0))).ok());
  EXPECT_LE(store.bytes_kept(), 2 * one);
  for (int id = 0; id < 10; ++id) expect_same(**store.load(id), example_keyframe(id, 0));
}

TEST(AtlasKeyframeStore, StaysWithinItsBudgetButForWhatNeverComesToTheDisk) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  const std::size_t one = size_in_memory(example_keyframe(1, 0));
  AtlasKeyframeStore store(atlas, 2 * one, [](int id) { return id != 1; });
  for (int id = 0; id < 10; ++id) {
    ASSERT_TRUE(id == 1 || atlas.add_keyframe(example_keyframe(id, 0)).ok());
    ASSERT_TRUE(store.add(std::make_shared<const keyframe::Keyframe>(example_keyframe(id, 0))).ok());
    EXPECT_LE(store.bytes_kept(), 2 * one);
  }
  for (int id = 0; id < 10; ++id) expect_same(**store.load(id), example_keyframe(id, 0));
}

TEST(Atlas, IsReadByAnotherThreadOnceCommitted) {
  const TemporaryFolder folder;
  Atlas writer = created(folder);
  const auto reader = writer.reader();
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  ASSERT_TRUE(writer.add_keyframe(example_keyframe(0, 0)).ok());
  EXPECT_FALSE(reader->load_keyframe(0).ok());
  ASSERT_TRUE(writer.commit().ok());
  expect_same(*reader->load_keyframe(0), example_keyframe(0, 0));
}

TEST(Atlas, TakesTheIdsThatItIsGiven) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  for (int id = 0; id < 3; ++id) ASSERT_TRUE(atlas.add_keyframe(example_keyframe(id, 0)).ok());
  for (const int id : {2, 7}) {
    EdgeRow row = example_edge(0, 1);
    row.id = id;
    EXPECT_EQ(*atlas.add_edge(row), id);
    EXPECT_FALSE(atlas.add_edge(row).ok());
  }
  EXPECT_EQ(*atlas.add_edge(example_edge(1, 2)), 8);
  MergeRow merge;
  merge.id = 5;
  GraphChange change;
  change.new_merges = {merge};
  EXPECT_EQ(atlas.apply(change)->merge_ids, std::vector<int>{5});
}

}  // namespace
}  // namespace mmlins::atlas

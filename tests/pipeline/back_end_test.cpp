// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/back_end.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <future>
#include <thread>
#include <utility>

#include "mmlins/atlas/export.hpp"
#include "tests/atlas/example.hpp"
#include "tests/pipeline/scripted_mapper.hpp"

namespace mmlins::pipeline {
namespace {

using atlas::Atlas;
using atlas::TemporaryFolder;
using math::SE3;

constexpr int kNumKeyframes = 3 * kPerMap;
/// No disk takes that long for what is written here, but for one that has failed.
constexpr std::chrono::seconds kLong{20};

BackEnd::MakeMapper scripted(std::function<void()> before) {
  return [before = std::move(before)](const mapping::MappingConfig& config, keyframe::KeyframeStore&) {
    auto mapper = std::make_unique<ScriptedMapper>(config);
    mapper->before_ = before;
    return mapper;
  };
}

/// Waits in the mapper until it is opened.
class Gate {
 public:
  [[nodiscard]] std::function<void()> keeper() const {
    return [opened = opened_] { opened.wait(); };
  }
  void open() {
    if (!std::exchange(is_open_, true)) promise_.set_value();
  }

 private:
  bool is_open_ = false;
  std::promise<void> promise_;
  std::shared_future<void> opened_ = promise_.get_future().share();
};

/// Also where a test ends early: the back end waits for its mapper.
struct OpenAtEnd {
  explicit OpenAtEnd(Gate& of) : gate(of) {}
  ~OpenAtEnd() { gate.open(); }
  Gate& gate;
};

keyframe::KeyframePointer made_keyframe(int id) {
  keyframe::Keyframe kf = atlas::example_keyframe(id, id / kPerMap);
  kf.T_map_imu = shift(1.0 * (id % kPerMap), 0.0);
  kf.down_imu = -math::Vector3d::UnitZ();
  return std::make_shared<const keyframe::Keyframe>(std::move(kf));
}

odometry::MapRecord record_of(int map) {
  odometry::MapRecord record;
  record.id = map;
  record.begin = made_keyframe(kPerMap * map)->time;
  record.last_believed = made_keyframe(kPerMap * map + kPerMap - 1)->time;
  record.why_ended = odometry::Cause::kNoPoints;
  return record;
}

/// Hands in what an odometry would, keyframes from one number up to another; it goes on from call to call.
void feed(BackEnd& back_end, int from, int to) {
  for (int id = from; id < to; ++id) {
    const int map = id / kPerMap;
    if (id % kPerMap == 0) {
      mapping::MapBegin begin{map, shift(20.0 * map, 0.0), std::nullopt};
      if (map == 1) begin.gap_covariance = math::Matrix6d::Identity();
      back_end.add(BeginOfMap{begin, record_of(map)});
    }
    if (id % kPerMap == 5) back_end.add(Bridge{0.01 * math::Matrix6d::Identity()});
    back_end.add(NewKeyframe{made_keyframe(id), 1e-4 * math::Matrix6d::Identity()});
    if ((id + 1) % kPerMap == 0) back_end.add(EndOfMap{record_of(map)});
  }
}

/// Waits until so many keyframes are on disk.
bool has_keyframes(const Atlas& reader, std::size_t count) {
  const auto end = std::chrono::steady_clock::now() + kLong;
  while (std::chrono::steady_clock::now() < end) {
    if (reader.keyframes()->size() >= count) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

template <typename Value>
void put(std::string& text, const Value& value) {
  if constexpr (std::is_arithmetic_v<Value>) {
    text.append(reinterpret_cast<const char*>(&value), sizeof(value));
  } else {
    text.append(reinterpret_cast<const char*>(value.data()), sizeof(value));
  }
}
void put(std::string& text, const SE3& pose) {
  put(text, pose.R);
  put(text, pose.t);
}

template <typename Rows>
Rows value_of(Result<Rows> rows) {
  EXPECT_TRUE(rows.ok());
  return std::move(*rows);
}

/// All rows, bit for bit.
std::string content_of(const std::string& folder) {
  const auto atlas = Atlas::open(folder, atlas::Access::kRead);
  EXPECT_TRUE(atlas.ok());
  std::string text;
  for (const auto& row : value_of(atlas->maps())) {
    text += fmt::format("map {} {} {} {} {}\n", row.id, static_cast<int>(row.state), row.world, row.why_ended,
                        to_ns(row.last));
    put(text, row.T_world_map);
  }
  for (const auto& row : value_of(atlas->keyframes())) {
    text += fmt::format("keyframe {} {} {} {} {}\n", row.id, row.map_id, to_ns(row.time), row.place.chunk,
                        row.place.offset);
    put(text, row.T_map_imu);
    put(text, row.T_map_imu_optimised);
  }
  for (const auto& row : value_of(atlas->edges())) {
    text += fmt::format("edge {} {} {} {} {} {}\n", row.id, row.edge.from, row.edge.to,
                        static_cast<int>(row.edge.kind), row.edge.provenance, row.evidence);
    put(text, row.edge.T_from_to);
    put(text, row.edge.information);
    put(text, row.weight);
  }
  for (const auto& row : value_of(atlas->gravity())) text += fmt::format("gravity {}\n", row.keyframe_id);
  for (const auto& row : value_of(atlas->places())) {
    text += fmt::format("place {} {} {}\n", row.map_id, row.submap_id, row.keyframe_ids.size());
    put(text, row.T_map_submap);
  }
  for (const auto& row : value_of(atlas->merges())) {
    text += fmt::format("merge {} {} {} {} {}\n", row.id, row.map, row.into, row.undone, row.evidence);
    put(text, row.T_before);
    put(text, row.T_after);
  }
  return text;
}

Atlas created(const TemporaryFolder& folder) {
  auto atlas = Atlas::create(folder / "atlas");
  EXPECT_TRUE(atlas.ok());
  return std::move(*atlas);
}

TEST(BackEnd, PutsKeyframesOnTheDiskWhateverTheMapperIsDoing) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  const auto reader = atlas.reader();
  ASSERT_TRUE(reader.ok());
  Gate gate;
  BackEnd back_end({}, &atlas, scripted(gate.keeper()));
  feed(back_end, 0, kPerMap + 3);
  const OpenAtEnd at_end(gate);
  ASSERT_TRUE(has_keyframes(*reader, kPerMap + 3));
  EXPECT_EQ(reader->edges()->size(), kPerMap + 2U);
  EXPECT_EQ(reader->edges()->at(kPerMap - 1).edge.kind, graph::EdgeKind::kGap);
  EXPECT_EQ(reader->maps()->at(0).state, atlas::MapState::kSleeping);
  EXPECT_EQ(reader->maps()->at(1).state, atlas::MapState::kActive);
  const auto report = reader->check();
  EXPECT_TRUE(report->problems.empty()) << report->problems.front();
  EXPECT_EQ(report->num_keyframes, kPerMap + 3U);
  gate.open();
  back_end.finish();
  EXPECT_EQ(back_end.error(), "");
}

TEST(BackEnd, LeavesTheSameAtlasWhoeverWasFaster) {
  std::vector<std::string> contents;
  for (const bool mapper_is_late : {false, true}) {
    const TemporaryFolder folder;
    {
      Atlas atlas = created(folder);
      const auto reader = atlas.reader();
      Gate gate;
      std::atomic<int> num_known = 0;
      const auto count = [&, keeper = gate.keeper()] {
        if (mapper_is_late) keeper();
        ++num_known;
      };
      BackEnd back_end({}, &atlas, scripted(count));
      for (int id = 0; id < kNumKeyframes; ++id) {
        feed(back_end, id, id + 1);
        const int num_begun = id / kPerMap + 1;
        while (!mapper_is_late && num_known < id + 1 + num_begun) std::this_thread::yield();
      }
      if (mapper_is_late) {
        EXPECT_TRUE(has_keyframes(*reader, kNumKeyframes));
      }
      gate.open();
      back_end.finish();
      EXPECT_EQ(back_end.error(), "");
    }
    contents.push_back(content_of(folder / "atlas"));
  }
  EXPECT_GT(contents[0].size(), 10000U);
  EXPECT_TRUE(contents[0] == contents[1]);
}

TEST(BackEnd, WritesInTheEndWhatTheMapperHas) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  BackEnd back_end({}, &atlas, scripted({}));
  feed(back_end, 0, kNumKeyframes);
  back_end.finish();
  const graph::PoseGraph& graph = back_end.mapper().map_graph().graph();
  const auto keyframes = atlas.keyframes();
  ASSERT_EQ(keyframes->size(), graph.nodes.size());
  double most_moved = 0.0;
  for (std::size_t i = 0; i < keyframes->size(); ++i) {
    const atlas::KeyframeRow& row = (*keyframes)[i];
    EXPECT_EQ(row.T_map_imu_optimised.t, graph.nodes[i].T_map_node.t) << i;
    most_moved = std::max(most_moved, (row.T_map_imu.t - row.T_map_imu_optimised.t).norm());
  }
  EXPECT_GT(most_moved, 0.05);  // else nothing was tested
  const auto maps = atlas.maps();
  for (std::size_t map = 0; map < 3; ++map) {
    EXPECT_EQ((*maps)[map].T_world_map.t, graph.anchors[map].T_world_map.t);
    EXPECT_EQ((*maps)[map].world, back_end.mapper().map_graph().world_of(static_cast<int>(map)));
  }
  std::size_t num_standing = 0;
  const auto edges = atlas.edges();
  for (const atlas::EdgeRow& row : *edges) num_standing += row.weight > 0.0 ? 1 : 0;
  EXPECT_EQ(num_standing, graph.edges.size());
  EXPECT_EQ(edges->size(), graph.edges.size() + 1);  // that of the merge, which was undone
  EXPECT_EQ(atlas.merges()->at(0).id, 1);
  EXPECT_TRUE(atlas.merges()->at(0).undone);
  EXPECT_NE(atlas.merges()->at(0).evidence.find("it was not so"), std::string::npos);
  EXPECT_TRUE(atlas.check()->problems.empty());
}

TEST(BackEnd, MovesKeyframesTheMapperDoesNotKnowYetAlongWithTheirMap) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  const auto reader = atlas.reader();
  Gate gate;
  int num_known = 0;  // in the mapper's thread
  const auto wait_after_closure = [&num_known, keeper = gate.keeper()] {
    if (++num_known > 10) keeper();  // a beginning and nine keyframes came before
  };
  BackEnd back_end({}, &atlas, scripted(wait_after_closure));
  const OpenAtEnd at_end(gate);
  feed(back_end, 0, kPerMap + 4);
  ASSERT_TRUE(has_keyframes(*reader, kPerMap + 4));
  const auto end = std::chrono::steady_clock::now() + kLong;
  const auto is_moved = [&] { return reader->keyframes()->at(8).T_map_imu_optimised.t.y() > 0.01; };
  while (!is_moved() && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  ASSERT_TRUE(is_moved());
  // What lies a metre apart by the odometry still does, at the seam as well.
  const auto keyframes = reader->keyframes();
  for (int id = 9; id < kPerMap; ++id) {
    const auto at = [&](int i) { return (*keyframes)[static_cast<std::size_t>(i)].T_map_imu_optimised; };
    EXPECT_LT(((at(id - 1).inverse() * at(id)).t - math::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-9) << id;
  }
  const auto maps = reader->maps();
  const SE3 T_last_next = ((*maps)[0].T_world_map * (*keyframes)[kPerMap - 1].T_map_imu_optimised).inverse() *
                          (*maps)[1].T_world_map * (*keyframes)[kPerMap].T_map_imu_optimised;
  EXPECT_LT((T_last_next.t - math::Vector3d(20.0 - (kPerMap - 1), 0.0, 0.0)).norm(), 1e-9);
  gate.open();
  back_end.finish();
}

TEST(BackEnd, TellsTheFirstErrorAndGoesOn) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  BackEnd back_end({}, &atlas, scripted({}));
  back_end.add(BeginOfMap{{0, {}, std::nullopt}, record_of(0)});
  for (int id = 0; id < 8; ++id) {
    keyframe::Keyframe kf = *made_keyframe(id);
    if (id == 3 || id == 6)
      kf.points_imu.assign(1, Eigen::Vector3f::Constant(200.0F * static_cast<float>(id)));  // too far
    if (id == 3 || id == 6) kf.intensities.clear();
    back_end.add(NewKeyframe{std::make_shared<const keyframe::Keyframe>(kf), math::Matrix6d::Identity()});
  }
  back_end.finish();
  EXPECT_NE(back_end.error().find("keyframe 3"), std::string::npos) << back_end.error();
  EXPECT_EQ(atlas.keyframes()->size(), 6U);
  EXPECT_TRUE(atlas.check()->problems.empty());
}

TEST(BackEnd, KeepsWhatCouldNotBeWritten) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  mapping::MappingConfig config;
  config.memory_mb = 0;
  BackEnd back_end(config, &atlas, scripted({}));
  back_end.add(BeginOfMap{{0, {}, std::nullopt}, record_of(0)});
  for (int id = 0; id < 8; ++id) {
    keyframe::Keyframe kf = *made_keyframe(id);
    if (id == 3) kf.points_imu[0].x() = 2.0F * static_cast<float>(keyframe::kPointReach);  // too far
    back_end.add(NewKeyframe{std::make_shared<const keyframe::Keyframe>(kf), math::Matrix6d::Identity()});
  }
  back_end.finish();
  ASSERT_FALSE(atlas.load_keyframe(3).ok());
  // One more, for which all that is on the disk makes room.
  ASSERT_TRUE(back_end.store().add(made_keyframe(8)).ok());
  for (int id = 0; id < 8; ++id) EXPECT_TRUE(back_end.store().load(id).ok()) << id;
}

TEST(BackEnd, SaysThatMemoryIsNotBoundedWhereTheAtlasCannotBeReadBack) {
  const TemporaryFolder folder;
  Atlas atlas = created(folder);
  ASSERT_TRUE(std::filesystem::remove(folder / "atlas/index.sqlite"));
  mapping::MappingConfig config;
  config.memory_mb = 0;
  BackEnd back_end(config, &atlas, scripted({}));
  feed(back_end, 0, kPerMap);
  back_end.finish();
  EXPECT_NE(back_end.error().find("mapping.memory_mb"), std::string::npos) << back_end.error();
  EXPECT_NE(back_end.error().find("index.sqlite"), std::string::npos) << back_end.error();
  // The mapper lacks nothing.
  for (int id = 0; id < kPerMap; ++id) EXPECT_TRUE(back_end.store().load(id).ok()) << id;
}

TEST(BackEnd, TellsWhatTheMapperCouldNotDo) {
  BackEnd back_end({}, nullptr, [](const mapping::MappingConfig& config, keyframe::KeyframeStore&) {
    auto mapper = std::make_unique<ScriptedMapper>(config);
    mapper->error_ = "no solution";
    return mapper;
  });
  feed(back_end, 0, 3);
  back_end.finish();
  EXPECT_EQ(back_end.error(), "the pose graph cannot be optimised: no solution");
}

TEST(BackEnd, TellsThatTheGraphDoesNotHoldTogetherEvenIfNothingWasRecognised) {
  BackEnd back_end({}, nullptr, scripted({}));
  feed(back_end, 0, 3);
  back_end.add(NewKeyframe{made_keyframe(3), std::nan("") * math::Matrix6d::Identity()});
  back_end.finish();
  EXPECT_NE(back_end.error().find("the pose graph cannot be optimised: pose graph: edge 2 -> 3"),
            std::string::npos)
      << back_end.error();
}

TEST(BackEnd, LeavesAnAtlasThatOpensIfItDiesBeforeTheMapperKnowsAKeyframe) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    Atlas atlas = created(folder);
    Gate gate;
    BackEnd back_end({}, &atlas, scripted(gate.keeper()));
    feed(back_end, 0, 2 * kPerMap + 2);
    gate.keeper()();  // for ever
  }
  const auto end = std::chrono::steady_clock::now() + kLong;
  std::size_t num_there = 0;
  while (num_there < 2 * kPerMap + 2 && std::chrono::steady_clock::now() < end) {
    const auto reader = Atlas::open(folder / "atlas", atlas::Access::kRead);
    if (reader.ok() && reader->keyframes().ok()) num_there = reader->keyframes()->size();
  }
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_EQ(num_there, 2 * kPerMap + 2U);
  const auto atlas = Atlas::open(folder / "atlas", atlas::Access::kWrite);
  ASSERT_TRUE(atlas.ok()) << atlas.error().message;
  EXPECT_TRUE(atlas->check()->problems.empty());
  for (const atlas::MapRow& map : value_of(atlas->maps())) EXPECT_EQ(map.state, atlas::MapState::kSleeping);
  const std::vector<int> all{0, 1, 2};
  EXPECT_EQ(atlas::world_keyframes(*atlas, all)->size(), num_there);
  EXPECT_EQ(atlas::pose_graph(*atlas, all)->nodes.size(), num_there);
}

}  // namespace
}  // namespace mmlins::pipeline

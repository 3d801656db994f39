// SPDX-License-Identifier: MIT
// A writer is killed at moments that nobody chose; what it had committed must be there, and no more than
// whole changes.

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/atlas/unmerge.hpp"
#include "tests/atlas/chained_maps.hpp"

namespace mmlins::atlas {
namespace {

constexpr int kNumKills = 20;

/// What the child process tells: mostly how many steps it has committed.
class Progress {
 public:
  Progress() { EXPECT_EQ(pipe(ends_), 0); }
  void tell(int steps) const { (void)!write(ends_[1], &steps, sizeof(steps)); }
  /// The last that was told; waits until the child is gone.
  int last() {
    close(ends_[1]);
    int steps = 0;
    for (int next = 0; read(ends_[0], &next, sizeof(next)) == sizeof(next);) steps = next;
    close(ends_[0]);
    return steps;
  }

 private:
  int ends_[2] = {};
};

constexpr int kNever = -1;

/// Runs `work` in a process of its own and kills that after a while. @return what it told last
int run_and_kill(const std::function<void(const Progress&)>& work, int microseconds) {
  Progress progress;
  const pid_t child = fork();
  if (child == 0) {
    work(progress);
    _exit(0);
  }
  if (microseconds != kNever) {
    usleep(static_cast<useconds_t>(microseconds));
    kill(child, SIGKILL);
  }
  const int steps = progress.last();
  int status = 0;
  waitpid(child, &status, 0);
  return steps;
}

void require(bool condition) {
  if (!condition) _exit(1);
}

/// Adds keyframes without end, each with an edge to the one before, and commits after every third.
void write_keyframes(const std::string& folder, const Progress& progress) {
  auto atlas = Atlas::create(folder, {.batch_keyframes = 1000, .chunk_bytes = 20000});
  require(atlas.ok() && atlas->add_map(example_map(1)).ok());
  for (int id = 0;; ++id) {
    require(atlas->add_keyframe(example_keyframe(id, 1)).ok());
    require(id == 0 || atlas->add_edge(example_edge(id - 1, id)).ok());
    if (id % 3 != 2) continue;
    require(atlas->commit().ok());
    progress.tell(id + 1);
  }
}

TEST(Crash, LeavesAllKeyframesThatWereCommitted) {
  math::Random random(20260101);
  int most = 0;
  for (int i = 0; i < kNumKills; ++i) {
    const TemporaryFolder folder;
    const std::string place = folder / "atlas";
    const int committed = run_and_kill([&](const Progress& progress) { write_keyframes(place, progress); },
                                       static_cast<int>(random.uniform(1e3, 1e5)));
    most = std::max(most, committed);
    auto atlas = Atlas::open(place, Access::kWrite);
    if (!atlas.ok() && committed == 0) continue;  // killed before there was an atlas
    ASSERT_TRUE(atlas.ok()) << atlas.error().message;
    const auto keyframes = atlas->keyframes();
    ASSERT_TRUE(keyframes.ok());
    EXPECT_GE(static_cast<int>(keyframes->size()), committed);
    EXPECT_EQ(keyframes->size() % 3, 0U);
    EXPECT_EQ(atlas->edges()->size(), keyframes->empty() ? 0 : keyframes->size() - 1);
    for (const KeyframeRow& row : *keyframes) {
      const auto loaded = atlas->load_keyframe(row.id);
      ASSERT_TRUE(loaded.ok()) << loaded.error().message;
      EXPECT_EQ(loaded->points_imu, example_keyframe(row.id, 1).points_imu);
    }
    const auto report = atlas->check();
    EXPECT_TRUE(report->problems.empty()) << report->problems.front();
    // Life goes on.
    const int next = static_cast<int>(keyframes->size());
    EXPECT_TRUE(atlas->add_keyframe(example_keyframe(next, 1)).ok());
    EXPECT_TRUE(atlas->commit().ok());
    EXPECT_EQ(atlas->load_keyframe(next)->points_imu, example_keyframe(next, 1).points_imu);
  }
  EXPECT_GT(most, 10);  // else nothing was tested
}

/// Goes on after errors, as a run would. Files cannot grow beyond some size, as on a full disk.
void write_to_a_full_disk(const std::string& folder, const Progress& progress, rlim_t max_bytes) {
  auto atlas = Atlas::create(folder, {.batch_keyframes = 5});
  require(atlas.ok() && atlas->add_map(example_map(1)).ok());
  signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{max_bytes, max_bytes};
  require(setrlimit(RLIMIT_FSIZE, &limit) == 0);
  int num_errors = 0;
  for (int id = 0; id < 400; ++id) {
    const Status added = atlas->add_keyframe(example_keyframe(id, 1));
    if (added.ok()) continue;
    ++num_errors;
    require(added.error().message.find('\n') == std::string::npos);
  }
  (void)atlas->commit().ok();
  progress.tell(num_errors);
  _exit(0);  // not even closed
}

TEST(Crash, OfAFullDiskLeavesWhatWasCommitted) {
  // Limits that stop the points and the log of the index at various moments.
  for (const rlim_t max_bytes : {rlim_t{150'000}, rlim_t{100'000}, rlim_t{60'000}}) {
    const TemporaryFolder folder;
    const std::string place = folder / "atlas";
    const int num_errors = run_and_kill(
        [&](const Progress& progress) { write_to_a_full_disk(place, progress, max_bytes); }, kNever);
    EXPECT_GT(num_errors, 10) << max_bytes;
    const auto atlas = Atlas::open(place, Access::kWrite);
    ASSERT_TRUE(atlas.ok()) << atlas.error().message;
    const auto report = atlas->check();
    EXPECT_GE(report->num_keyframes, 5U) << max_bytes;
    EXPECT_TRUE(report->problems.empty()) << report->problems.front();
  }
}

constexpr int kMergeKeyframes = 100;

SE3 numbered_pose(int number) { return {math::Matrix3d::Identity(), Vector3d::Constant(number)}; }

/// Merges again and again; merge number n moves everything to n.
void write_merges(const std::string& folder, const Progress& progress) {
  auto atlas = Atlas::open(folder, Access::kWrite);
  require(atlas.ok());
  for (int n = 1;; ++n) {
    GraphChange change;
    change.new_edges = {example_edge(0, 1, graph::EdgeKind::kMerge),
                        example_edge(2, 3, graph::EdgeKind::kMerge)};
    for (int id = 0; id < kMergeKeyframes; ++id) change.T_map_imu_optimised.push_back({id, numbered_pose(n)});
    change.T_world_map = {{0, numbered_pose(n)}, {1, numbered_pose(n)}};
    change.worlds = {{1, n}};
    change.new_merges = {MergeRow{}};
    require(atlas->apply(change).ok());
    progress.tell(n);
  }
}

TEST(Crash, LeavesAMergeAsAWholeOrNotAtAll) {
  const TemporaryFolder folder;
  const std::string place = folder / "atlas";
  {
    auto atlas = Atlas::create(place);
    ASSERT_TRUE(atlas.ok());
    for (const int id : {0, 1}) ASSERT_TRUE(atlas->add_map(example_map(id)).ok());
    for (int id = 0; id < kMergeKeyframes; ++id) {
      ASSERT_TRUE(atlas->add_keyframe(example_keyframe(id, id % 2)).ok());
    }
  }
  math::Random random(20260102);
  int most = 0;
  for (int i = 0; i < kNumKills; ++i) {
    const int committed = run_and_kill([&](const Progress& progress) { write_merges(place, progress); },
                                       static_cast<int>(random.uniform(1e3, 5e4)));
    most = std::max(most, committed);
    const auto atlas = Atlas::open(place, Access::kRead);
    ASSERT_TRUE(atlas.ok()) << atlas.error().message;
    const auto maps = atlas->maps();
    ASSERT_EQ(maps->size(), 2U);
    const Vector3d where = (*maps)[0].T_world_map.t;
    if (committed > 0) {
      EXPECT_GE(where.x(), committed);
    }
    const bool was_merged = where == Vector3d::Constant(std::floor(where.x()));
    if (!was_merged) continue;  // killed before the very first merge
    EXPECT_EQ((*maps)[1].T_world_map.t, where);
    EXPECT_EQ((*maps)[1].world, static_cast<int>(where.x()));
    const auto keyframes = atlas->keyframes();
    for (const KeyframeRow& row : *keyframes) EXPECT_EQ(row.T_map_imu_optimised.t, where);
    EXPECT_EQ(atlas->edges()->size(), 2 * atlas->merges()->size());
    EXPECT_TRUE(atlas->check()->problems.empty());
  }
  EXPECT_GT(most, 2);
}

constexpr int kChainMaps = 3;

/// Joins map 1 to map 0 and takes that back, again and again.
void merge_and_unmerge(const std::string& folder, const Progress& progress) {
  auto atlas = Atlas::open(folder, Access::kWrite);
  require(atlas.ok());
  // The process before may have been killed in between.
  const auto merges = *atlas->merges();
  if (!merges.empty() && !merges.back().undone) require(unmerge(*atlas, merges.back().id).ok());
  const GraphChange change = chain_merge(*atlas, 1, 0, kElsewhere);
  for (int n = 1;; ++n) {
    const auto committed = atlas->apply(change);
    require(committed.ok());
    require(unmerge(*atlas, committed->merge_ids.at(0)).ok());
    progress.tell(n);
  }
}

TEST(Crash, LeavesWorldsJoinedOrApart) {
  const TemporaryFolder folder;
  const std::string place = folder / "atlas";
  std::vector<SE3> apart, joined;
  {
    auto atlas = Atlas::create(place);
    ASSERT_TRUE(atlas.ok());
    fill_with_chain(*atlas, kChainMaps, true);
    apart = poses_of(*atlas);
    const auto merged = atlas->apply(chain_merge(*atlas, 1, 0, kElsewhere));
    ASSERT_TRUE(merged.ok());
    joined = poses_of(*atlas);
    ASSERT_TRUE(unmerge(*atlas, merged->merge_ids.at(0)).ok());
  }
  ASSERT_GT(most_apart(apart, joined), 1.0);
  math::Random random(20260103);
  int num_joined = 0, num_apart = 0;
  for (int i = 0; i < 2 * kNumKills; ++i) {
    run_and_kill([&](const Progress& progress) { merge_and_unmerge(place, progress); },
                 static_cast<int>(random.uniform(5e3, 5e4)));
    const auto atlas = Atlas::open(place, Access::kRead);
    ASSERT_TRUE(atlas.ok()) << atlas.error().message;
    const auto merges = *atlas->merges();
    const bool stands = !merges.back().undone;
    ++(stands ? num_joined : num_apart);
    EXPECT_EQ(worlds_of(*atlas), (stands ? std::vector<int>{0, 0, 2} : std::vector<int>{0, 1, 2}));
    EXPECT_LT(most_apart(stands ? joined : apart, poses_of(*atlas)), 1e-9);  // rounding
    const auto edges = *atlas->edges();
    std::size_t num_ties = 0;
    for (const EdgeRow& row : edges) num_ties += row.edge.kind == graph::EdgeKind::kMerge && row.weight > 0.0 ? 1 : 0;
    EXPECT_EQ(num_ties, stands ? 1U : 0U);
    for (std::size_t k = 0; k + 1 < merges.size(); ++k) EXPECT_TRUE(merges[k].undone);
    EXPECT_TRUE(atlas->check()->problems.empty());
  }
  // Both were met, so that neither was taken for granted.
  EXPECT_GT(num_joined, 0);
  EXPECT_GT(num_apart, 0);
}

}  // namespace
}  // namespace mmlins::atlas

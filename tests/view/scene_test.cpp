// SPDX-License-Identifier: MIT
#include "mmlins/view/scene.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "mmlins/view/recorded_run.hpp"
#include "tests/view/example_run.hpp"

namespace mmlins::view {
namespace {

class Folder : public testing::Test {
 protected:
  /// The error of opening it: one line.
  std::string refused() {
    const auto run = open_run(folder_.path());
    if (run.ok()) return "was opened";
    EXPECT_EQ(run.error().message.find('\n'), std::string::npos);
    EXPECT_NE(run.error().message.find(folder_.path()), std::string::npos);
    return run.error().message;
  }
  [[nodiscard]] bool says(const std::string& what) {
    const std::string message = refused();
    return message.find(what) != std::string::npos ? true : (ADD_FAILURE() << message, false);
  }

  atlas::TemporaryFolder folder_;
};

TEST_F(Folder, OfARunIsOpenedWithAllThatIsShown) {
  ASSERT_TRUE(write_example_atlas(folder_.path()) && write_example_files(folder_.path()));
  const auto run = open_run(folder_.path());
  ASSERT_TRUE(run.ok()) << run.error().message;
  EXPECT_EQ(run->maps.keyframes.size(), 20U);
  EXPECT_EQ(run->maps.maps.size(), 2U);
  ASSERT_EQ(run->maps.edges.size(), 1U);  // those of the odometry are not shown
  EXPECT_EQ(run->maps.edges[0].edge.kind, graph::EdgeKind::kMerge);
  EXPECT_EQ(run->maps.merges.size(), 1U);
  ASSERT_EQ(run->scans.scans.size(), 3U);
  EXPECT_EQ(run->scans.names.states, (std::vector<std::string>{"INITIALIZING", "TRACKING", "LOST"}));
  EXPECT_EQ(run->scans.names.causes, (std::vector<std::string>{"", "no points"}));
  EXPECT_EQ(run->scans.scans[2].state, 2);
  EXPECT_EQ(run->scans.scans[2].cause, 1);
  EXPECT_EQ(run->scans.scans[2].T_world_imu.t.x(), 3.0);
  EXPECT_EQ(run->scans.scans[2].total_ms, 0.25F);
}

TEST_F(Folder, ThatIsNoResultIsRefusedInOneLine) {
  EXPECT_TRUE(says("is not the result of a run"));
  std::filesystem::remove_all(folder_.path());
  EXPECT_TRUE(says("no such folder"));
}

TEST_F(Folder, ThatIsHalfWrittenIsRefusedInOneLine) {
  ASSERT_TRUE(write_example_files(folder_.path()));
  EXPECT_TRUE(says("there are no maps"));
  ASSERT_TRUE(write_example_atlas(folder_.path()));
  for (const char* name : {"trajectory.tum", "health.csv", "summary.json"}) {
    ASSERT_TRUE(write_example_files(folder_.path()));
    std::filesystem::remove(folder_ / name);
    EXPECT_TRUE(says("has not come to its end"));
    EXPECT_TRUE(says(name));
  }
}

TEST_F(Folder, OfARunThatGoesOnIsRefusedThoughOlderFilesLieThere) {
  ASSERT_TRUE(write_example_atlas(folder_.path(), atlas::MapState::kActive) &&
              write_example_files(folder_.path()));
  EXPECT_TRUE(says("still active"));
}

TEST_F(Folder, WithFilesOfDifferentRunsIsRefused) {
  ASSERT_TRUE(write_example_atlas(folder_.path()) && write_example_files(folder_.path()));
  ASSERT_TRUE(write_text_file(folder_ / "trajectory.tum", "1600000000.1 1 2 3 0 0 0 1\n").ok());
  EXPECT_TRUE(says("different runs"));
  ASSERT_TRUE(write_text_file(folder_ / "health.csv", "time,state\n1,2\n").ok());
  EXPECT_TRUE(says("header"));
}

TEST_F(Folder, WithADamagedHealthFileNamesTheLine) {
  ASSERT_TRUE(write_example_atlas(folder_.path()) && write_example_files(folder_.path()));
  ASSERT_TRUE(
      write_text_file(folder_ / "health.csv", "time,state,cause,map,total_ms\n1.5,TRACKING,,0,1\n1.6,TRA")
          .ok());
  EXPECT_TRUE(says("line 3"));
}

}  // namespace
}  // namespace mmlins::view

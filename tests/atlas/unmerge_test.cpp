// SPDX-License-Identifier: MIT
#include "mmlins/atlas/unmerge.hpp"

#include <gtest/gtest.h>

#include "mmlins/atlas/database.hpp"
#include "tests/atlas/chained_maps.hpp"

namespace mmlins::atlas {
namespace {

using Worlds = std::vector<int>;

class Unmerge : public testing::Test {
 protected:
  int merge(int map, int into, const SE3& T_into_map) {
    const auto committed = atlas_.apply(chain_merge(atlas_, map, into, T_into_map));
    EXPECT_TRUE(committed.ok());
    return committed->merge_ids.at(0);
  }
  void change_index(const std::string& sql) {
    const auto database = Database::open(folder_ / "atlas/index.sqlite", OpenMode::kWrite);
    ASSERT_TRUE(database.ok() && (*database)->execute(sql).ok()) << sql;
  }

  TemporaryFolder folder_;
  Atlas atlas_ = Atlas::create(folder_ / "atlas").value();
};

TEST_F(Unmerge, PutsEverythingBackWhereItWas) {
  fill_with_chain(atlas_, 3, true);
  const auto before = poses_of(atlas_);
  const int id = merge(1, 0, kElsewhere);
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 0, 2}));
  EXPECT_GT(most_apart(before, poses_of(atlas_)), 1.0);
  const auto apart = unmerge(atlas_, id);
  ASSERT_TRUE(apart.ok()) << apart.error().message;
  EXPECT_EQ(apart->stayed, Worlds{0});
  EXPECT_EQ(apart->moved, Worlds{1});
  EXPECT_EQ(apart->num_edges, 1U);
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 1, 2}));
  EXPECT_LT(most_apart(before, poses_of(atlas_)), 1e-9);  // rounding
  EXPECT_TRUE(atlas_.merges()->front().undone);
  const auto edges = *atlas_.edges();
  for (const EdgeRow& row : edges) EXPECT_EQ(row.weight > 0.0, row.edge.kind != graph::EdgeKind::kMerge);
}

TEST_F(Unmerge, PutsAMapBackOfWhichNothingWasKnown) {
  fill_with_chain(atlas_, 2, false);
  const auto before = poses_of(atlas_);
  ASSERT_TRUE(unmerge(atlas_, merge(1, 0, kElsewhere)).ok());
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 1}));
  EXPECT_LT(most_apart(before, poses_of(atlas_)), 1e-9);
}

TEST_F(Unmerge, KeepsWhatOtherClosuresSay) {
  fill_with_chain(atlas_, 4, true);
  const int first = merge(1, 0, kElsewhere);
  const auto before = poses_of(atlas_);
  const int second = merge(3, 2, kElsewhere);
  ASSERT_TRUE(unmerge(atlas_, second).ok());
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 0, 2, 3}));
  // Optimised in one way and in another, to the same end: one part in a million of chi2.
  EXPECT_LT(most_apart(before, poses_of(atlas_)), 1e-4);
  EXPECT_FALSE(atlas_.merges()->at(0).undone);
  EXPECT_EQ(first, atlas_.merges()->at(0).id);
}

TEST_F(Unmerge, TakesBackTheLatestFirst) {
  fill_with_chain(atlas_, 3, true);
  const auto before = poses_of(atlas_);
  const int first = merge(1, 0, kElsewhere);
  const auto between = poses_of(atlas_);
  const int second = merge(2, 0, kGap);
  const auto refused = unmerge(atlas_, first);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find(fmt::format("merge {} (map 2 into 0) rests on merge {}", second, first)),
            std::string::npos) << refused.error().message;
  ASSERT_TRUE(unmerge(atlas_, second).ok());
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 0, 2}));
  EXPECT_LT(most_apart(between, poses_of(atlas_)), 1e-4);
  ASSERT_TRUE(unmerge(atlas_, first).ok());
  EXPECT_EQ(worlds_of(atlas_), (Worlds{0, 1, 2}));
  EXPECT_LT(most_apart(before, poses_of(atlas_)), 1e-9);
}

TEST_F(Unmerge, SaysWhatCannotBeTakenBack) {
  fill_with_chain(atlas_, 2, true);
  EXPECT_NE(unmerge(atlas_, 1).error().message.find("there is no merge 1; there are none"), std::string::npos);
  const int id = merge(1, 0, kElsewhere);
  EXPECT_NE(unmerge(atlas_, 7).error().message.find("there is no merge 7; there is 1"), std::string::npos);
  ASSERT_TRUE(unmerge(atlas_, id).ok());
  EXPECT_NE(unmerge(atlas_, id).error().message.find("merge 1 was taken back already"), std::string::npos);
}

TEST_F(Unmerge, SaysWhichMapIsDamagedAndChangesNothing) {
  fill_with_chain(atlas_, 3, true);
  const int id = merge(2, 0, kElsewhere);
  // The two of the merge, and one on which another hangs by a gap.
  for (const int damaged : {0, 1, 2}) {
    change_index(fmt::format("UPDATE map SET state = '' WHERE id = {}", damaged));
    const auto refused = unmerge(atlas_, id);
    ASSERT_FALSE(refused.ok()) << damaged;
    const std::string& message = refused.error().message;
    EXPECT_NE(message.find(fmt::format("map {} is damaged", damaged)), std::string::npos) << message;
    EXPECT_NE(message.find("mmlins maps " + atlas_.folder() + " check"), std::string::npos) << message;
    change_index("UPDATE map SET state = 'sleeping'");
  }
  EXPECT_FALSE(atlas_.merges()->front().undone);
  EXPECT_TRUE(unmerge(atlas_, id).ok());
}

TEST_F(Unmerge, SaysThatAMergeIsNotWhatTheMapsSay) {
  fill_with_chain(atlas_, 3, true);
  const int id = merge(2, 1, kElsewhere);
  change_index("UPDATE map SET world = 0 WHERE id = 1");
  EXPECT_NE(unmerge(atlas_, id).error().message.find("maps 2 and 1 of merge 1 lie apart"), std::string::npos);
}

}  // namespace
}  // namespace mmlins::atlas

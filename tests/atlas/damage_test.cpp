// SPDX-License-Identifier: MIT
// Whatever happens to the files: one clear line, and everything that is intact can be used.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/base/text_file.hpp"
#include "tests/atlas/example.hpp"

namespace mmlins::atlas {
namespace {

namespace fs = std::filesystem;

constexpr int kNumKeyframes = 40;

/// Two maps of 20 keyframes each, in several chunk files.
class Damage : public testing::Test {
 protected:
  Damage() : place_(folder_ / "atlas"), index_(place_ + "/index.sqlite") {
    auto atlas = Atlas::create(place_, {.chunk_bytes = 5000});
    EXPECT_TRUE(atlas.ok());
    for (const int id : {0, 1}) EXPECT_TRUE(atlas->add_map(example_map(id)).ok());
    for (int id = 0; id < kNumKeyframes; ++id) {
      EXPECT_TRUE(atlas->add_keyframe(example_keyframe(id, id / 20)).ok());
      EXPECT_TRUE(id == 0 || atlas->add_edge(example_edge(id - 1, id)).ok());
    }
    GraphChange change;
    for (int id = 0; id < kNumKeyframes; ++id) change.T_map_imu_optimised.push_back({id, optimised(id)});
    EXPECT_TRUE(atlas->apply(change).ok());
  }

  static SE3 optimised(int id) { return example_pose(static_cast<std::uint64_t>(id) + 500); }
  [[nodiscard]] std::string chunk(int number) const {
    return fmt::format("{}/points_{:04}.chunk", place_, number);
  }
  [[nodiscard]] Result<Atlas> open() const { return Atlas::open(place_, Access::kRead); }

  /// The one line of an atlas that cannot be opened.
  [[nodiscard]] std::string refusal() const {
    const auto atlas = open();
    if (atlas.ok()) return "opened";
    EXPECT_EQ(atlas.error().message.find('\n'), std::string::npos);
    return atlas.error().message;
  }

  /// Keyframes that can be loaded; whatever can be loaded must be right.
  static int num_loadable(const Atlas& atlas) {
    int count = 0;
    for (int id = 0; id < kNumKeyframes; ++id) {
      const auto loaded = atlas.load_keyframe(id);
      if (!loaded.ok()) continue;
      EXPECT_EQ(loaded->points_imu, example_keyframe(id, id / 20).points_imu);
      EXPECT_EQ(loaded->map_id, id / 20);
      ++count;
    }
    return count;
  }

  const TemporaryFolder folder_;
  const std::string place_;
  const std::string index_;
};

std::string slurp(const std::string& path) { return read_text_file(path).value(); }

void overwrite(const std::string& path, std::size_t offset, const std::string& bytes) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(offset));
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void flip(const std::string& path, std::size_t offset) {
  const char byte = static_cast<char>(slurp(path)[offset] ^ 0x40);
  overwrite(path, offset, std::string(1, byte));
}

#define EXPECT_CONTAINS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST_F(Damage, NothingIsWrongBefore) {
  const auto atlas = open();
  EXPECT_EQ(num_loadable(*atlas), kNumKeyframes);
  const auto report = atlas->check();
  EXPECT_TRUE(report->problems.empty());
  EXPECT_EQ(report->num_maps, 2U);
  EXPECT_EQ(report->num_keyframes, 40U);
  EXPECT_EQ(report->num_edges, 39U);
  EXPECT_EQ(report->num_points, 2000U);
}

TEST_F(Damage, OfATruncatedChunkLosesItsEndOnly) {
  fs::resize_file(chunk(2), fs::file_size(chunk(2)) - 1);
  const auto atlas = open();
  EXPECT_EQ(num_loadable(*atlas), kNumKeyframes - 1);
  const auto report = atlas->check();
  ASSERT_EQ(report->problems.size(), 1U);
  EXPECT_CONTAINS(report->problems[0], chunk(2));
  EXPECT_CONTAINS(report->problems[0], "the points of 1 keyframe");
}

TEST_F(Damage, OfAnyByteOfAChunkLosesOneKeyframeAtMost) {
  const std::string original = slurp(chunk(1));
  for (std::size_t offset = 0; offset < original.size(); offset += 7) {
    flip(chunk(1), offset);
    const auto atlas = open();
    ASSERT_TRUE(atlas.ok());
    // The version stands at byte 8: a file of a newer format is left alone.
    const bool is_version = offset >= 8 && offset < 12;
    EXPECT_TRUE(is_version || num_loadable(*atlas) >= kNumKeyframes - 1) << offset;
    const bool is_unused = offset >= 12 && offset < 16;
    EXPECT_TRUE(is_unused || offset % 49 != 0 || !atlas->check()->problems.empty()) << offset;
    overwrite(chunk(1), offset, original.substr(offset, 1));
  }
  EXPECT_EQ(num_loadable(*open()), kNumKeyframes);
}

TEST_F(Damage, OfAMissingChunkLosesThatChunkOnly) {
  fs::remove(chunk(0));
  const int left = num_loadable(*open());
  EXPECT_LT(left, kNumKeyframes);
  EXPECT_GT(left, kNumKeyframes / 2);
  const auto lost = open()->load_keyframe(0);
  ASSERT_FALSE(lost.ok());
  EXPECT_CONTAINS(lost.error().message, chunk(0) + ": is missing");
  EXPECT_CONTAINS(open()->check()->problems.at(0), chunk(0) + ": is missing");
}

TEST_F(Damage, OfANewerChunkIsNamed) {
  overwrite(chunk(0), 8, std::string(1, 2));
  const auto lost = open()->load_keyframe(0);
  ASSERT_FALSE(lost.ok());
  EXPECT_CONTAINS(lost.error().message, "has format 2");
}

TEST_F(Damage, OfATruncatedIndexLeavesTheKeyframes) {
  const auto size = fs::file_size(index_);
  for (const auto left :
       {size - 4096, size / 2, std::uintmax_t{4096}, std::uintmax_t{50}, std::uintmax_t{0}}) {
    fs::resize_file(index_, left);
    EXPECT_CONTAINS(refusal(), index_ + ": is damaged") << left;
    const auto atlas = Atlas::salvage(place_);
    ASSERT_TRUE(atlas.ok()) << atlas.error().message;
    EXPECT_EQ(num_loadable(*atlas), kNumKeyframes) << left;
    EXPECT_EQ(atlas->maps()->size(), 2U);
    EXPECT_EQ(atlas->keyframes_of(1)->size(), 20U);
  }
}

TEST_F(Damage, OfOnePageOfTheIndexLeavesTheRowsOfTheOthers) {
  const std::size_t num_pages = fs::file_size(index_) / 4096;
  ASSERT_GT(num_pages, 10U);
  const std::string original = slurp(index_);
  int num_optimised = 0;
  for (std::size_t page = 1; page < num_pages; ++page) {
    overwrite(index_, page * 4096, std::string(4096, '\x5a'));
    if (!open().ok()) {
      const auto atlas = Atlas::salvage(place_);
      ASSERT_TRUE(atlas.ok()) << atlas.error().message;
      EXPECT_EQ(num_loadable(*atlas), kNumKeyframes) << page;
      const auto keyframes = atlas->keyframes();
      for (const KeyframeRow& row : *keyframes) {
        const bool is_optimised = row.T_map_imu_optimised.R == optimised(row.id).R;
        EXPECT_TRUE(is_optimised || row.T_map_imu_optimised.R == row.T_map_imu.R);
        num_optimised += is_optimised ? 1 : 0;
      }
    }
    overwrite(index_, page * 4096, original.substr(page * 4096, 4096));
  }
  EXPECT_GT(num_optimised, kNumKeyframes);
  EXPECT_TRUE(open().ok());
}

TEST_F(Damage, OfAPoseInTheIndexIsNoticedAndLeavesOutThatRow) {
  // The bytes of one pose, found by their value.
  const Vector3d t = optimised(7).t;
  const std::string needle(reinterpret_cast<const char*>(t.data()), 24);
  const std::size_t at = slurp(index_).find(needle);
  ASSERT_NE(at, std::string::npos);
  flip(index_, at + 3);
  const auto atlas = open();
  ASSERT_TRUE(atlas.ok()) << atlas.error().message;
  EXPECT_EQ(atlas->keyframes()->size(), 39U);
  EXPECT_CONTAINS(atlas->check()->problems.at(0), "keyframes: 1 rows are damaged");
}

TEST_F(Damage, OfAMissingIndexLeavesTheKeyframes) {
  fs::remove(index_);
  EXPECT_CONTAINS(refusal(), index_ + ": is missing");
  const auto atlas = Atlas::salvage(place_);
  EXPECT_EQ(num_loadable(*atlas), kNumKeyframes);
  const auto maps = atlas->maps();
  ASSERT_EQ(maps->size(), 2U);
  EXPECT_EQ((*maps)[1].begin, example_keyframe(20, 1).time);
  EXPECT_EQ((*maps)[1].last, example_keyframe(39, 1).time);
}

TEST_F(Damage, OfANewerIndexIsNone) {
  overwrite(index_, 60, std::string("\0\0\0\x02", 4));
  EXPECT_CONTAINS(refusal(), "has format 2, this program reads up to 1");
  EXPECT_EQ(open().error().code, ErrorCode::kUnsupported);
}

TEST_F(Damage, IsNotSpreadToForeignFiles) {
  overwrite(index_, 68, "XYZ!");
  EXPECT_CONTAINS(refusal(), "belongs to another program");
  const auto over_foreign = Atlas::create(place_);
  ASSERT_FALSE(over_foreign.ok());
  EXPECT_CONTAINS(over_foreign.error().message, "choose another folder");

  const std::string other = folder_ / "other";
  fs::create_directory(other);
  ASSERT_TRUE(write_text_file(other + "/index.sqlite", "this is a diary").ok());
  const auto diary = Atlas::open(other, Access::kRead);
  ASSERT_FALSE(diary.ok());
  EXPECT_CONTAINS(diary.error().message, "is not an atlas of mmlins");
  EXPECT_FALSE(Atlas::create(other).ok());
  EXPECT_EQ(slurp(other + "/index.sqlite"), "this is a diary");

  const std::string photos = folder_ / "photos";
  fs::create_directory(photos);
  ASSERT_TRUE(write_text_file(photos + "/cat.jpg", "meow").ok());
  const auto over_photos = Atlas::create(photos);
  ASSERT_FALSE(over_photos.ok());
  EXPECT_CONTAINS(over_photos.error().message, "holds cat.jpg");
  EXPECT_TRUE(fs::exists(photos + "/cat.jpg"));
  const auto none = Atlas::open(photos, Access::kRead);
  EXPECT_CONTAINS(none.error().message, "there is no atlas in it");
}

TEST_F(Damage, OfWhateverKindIsNoHindranceToANewAtlas) {
  overwrite(index_, 5000, std::string(3000, 'x'));
  const auto atlas = Atlas::create(place_);
  ASSERT_TRUE(atlas.ok()) << atlas.error().message;
  EXPECT_TRUE(atlas->keyframes()->empty());
  EXPECT_FALSE(fs::exists(chunk(0)));
}

TEST_F(Damage, IsNotWhatDeletingAMapDoesToTheOthers) {
  {
    auto atlas = Atlas::open(place_, Access::kWrite);
    GraphChange merged;
    merged.worlds = {{1, 0}};
    merged.new_merges = {MergeRow{}};
    ASSERT_TRUE(atlas->apply(merged).ok());
    ASSERT_TRUE(atlas->add_place(example_place(0, 3)).ok());
    EXPECT_FALSE(atlas->delete_map(5).ok());
    const auto removed = atlas->delete_map(0);
    ASSERT_TRUE(removed.ok()) << removed.error().message;
    EXPECT_EQ(removed->num_keyframes, 20U);
    EXPECT_EQ(removed->num_edges, 20U);  // one of them leads to the other map
    EXPECT_EQ(removed->num_places, 1U);
    EXPECT_EQ(removed->num_merges, 1U);
    EXPECT_GT(removed->freed_bytes, 5000);
    EXPECT_TRUE(atlas->add_keyframe(example_keyframe(40, 1)).ok());
  }
  EXPECT_FALSE(fs::exists(chunk(0)));
  const auto atlas = open();
  EXPECT_EQ(num_loadable(*atlas), 20);
  EXPECT_EQ(atlas->load_keyframe(40)->points_imu, example_keyframe(40, 1).points_imu);
  EXPECT_EQ(atlas->maps()->at(0).world, 1);
  EXPECT_EQ(atlas->edges()->size(), 19U);
  EXPECT_TRUE(atlas->check()->problems.empty());
}

}  // namespace
}  // namespace mmlins::atlas

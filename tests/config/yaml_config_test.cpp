// SPDX-License-Identifier: MIT
#include "mmlins/config/yaml_config.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

namespace mmlins::config {
namespace {

enum class Kind { kPlane, kKnn };

struct LidarConfig {
  double voxel_size = 0.5;
  int num_neighbours = 5;
  Fields fields() {
    return {field("voxel_size", voxel_size, "m", {0.05, 5.0}, "edge of the voxels"),
            field("num_neighbours", num_neighbours, "", {1.0, 50.0}, "points per plane")};
  }
};

struct TestConfig {
  LidarConfig lidar;
  Kind map = Kind::kPlane;
  bool save = true;
  std::string topic;
  std::array<double, 3> offset{0.0, 0.0, 0.0};
  double any = 0.0;
  Fields fields() {
    return {group("lidar", lidar, "how scans are thinned"),
            field("map", map, {"plane", "knn"}, "kind of local map"),
            field("save", save, "whether the map is saved"),
            field("topic", topic, "topic of the clouds"),
            field("offset", offset, "m", {-10.0, 10.0}, "where it sits"),
            field("any", any, "", {}, "any number")};
  }
};

std::string error_of(const std::string& yaml) {
  TestConfig config;
  const std::string before = to_yaml(config.fields(), false);
  const Status status = apply_yaml(config.fields(), yaml, "my.yaml");
  EXPECT_EQ(to_yaml(config.fields(), false), before) << "a refused text must change nothing";
  if (status.ok()) return "accepted";
  EXPECT_EQ(status.error().message.find('\n'), std::string::npos) << "one line";
  return status.error().message;
}

std::string override_error(const std::string& assignment) {
  TestConfig config;
  const Status status = apply_override(config.fields(), assignment);
  return status.ok() ? "accepted" : status.error().message;
}

TEST(YamlConfig, GivenKeysAreSetAndAbsentOnesKeepTheirValue) {
  TestConfig config;
  const Status status = apply_yaml(
      config.fields(),
      "lidar:\n  voxel_size: 0.25\nmap: knn\nsave: false\ntopic: /points\noffset: [1, -2.5, 1e-3]\n",
      "my.yaml");
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(config.lidar.voxel_size, 0.25);
  EXPECT_EQ(config.lidar.num_neighbours, 5);
  EXPECT_EQ(config.map, Kind::kKnn);
  EXPECT_FALSE(config.save);
  EXPECT_EQ(config.topic, "/points");
  EXPECT_EQ(config.offset, (std::array<double, 3>{1.0, -2.5, 1e-3}));
}

TEST(YamlConfig, AnEmptyTextIsAllDefaults) {
  EXPECT_EQ(error_of(""), "accepted");
  EXPECT_EQ(error_of("# nothing but a comment\n"), "accepted");
  EXPECT_EQ(error_of("lidar:\n"), "accepted");
}

TEST(YamlConfig, UnknownKeysAreRefusedWithLineAndNearestName) {
  EXPECT_EQ(error_of("save: true\nlidar:\n  voxel_sise: 0.2\n"),
            "my.yaml:3: unknown key lidar.voxel_sise; did you mean lidar.voxel_size?");
  EXPECT_EQ(error_of("lidr:\n  voxel_size: 0.2\n"), "my.yaml:1: unknown key lidr; did you mean lidar?");
  EXPECT_EQ(error_of("voxel_size: 0.2\n"),
            "my.yaml:1: unknown key voxel_size; did you mean lidar.voxel_size?");
  EXPECT_EQ(error_of("completely_else: 1\n"),
            "my.yaml:1: unknown key completely_else; \"mmlins config\" lists all keys");
}

TEST(YamlConfig, ValuesOutOfRangeAreRefusedWithTheRangeAndUnit) {
  EXPECT_EQ(error_of("lidar:\n  voxel_size: 7\n"),
            "my.yaml:2: lidar.voxel_size is 7, out of range; accepted: a number, 0.05 to 5 m");
  EXPECT_EQ(error_of("lidar: {num_neighbours: 99999999999999999999}"),
            "my.yaml:1: lidar.num_neighbours is 99999999999999999999, out of range; "
            "accepted: a whole number, 1 to 50");
  EXPECT_EQ(error_of("offset: [0, 11, 0]"),
            "my.yaml:1: offset [1] is 11, out of range; accepted: a list of 3 numbers, -10 to 10 m");
}

TEST(YamlConfig, WrongTypesAreRefused) {
  EXPECT_EQ(error_of("lidar: {num_neighbours: 1.5}"),
            "my.yaml:1: lidar.num_neighbours is 1.5; accepted: a whole number, 1 to 50");
  EXPECT_EQ(error_of("lidar: {voxel_size: big}"),
            "my.yaml:1: lidar.voxel_size is big; accepted: a number, 0.05 to 5 m");
  EXPECT_EQ(error_of("lidar: {voxel_size: \"1\"}"),
            "my.yaml:1: lidar.voxel_size is the text \"1\"; accepted: a number, 0.05 to 5 m");
  EXPECT_EQ(error_of("lidar:\n  voxel_size:\n"),
            "my.yaml:2: lidar.voxel_size has no value; accepted: a number, 0.05 to 5 m");
  EXPECT_EQ(error_of("save: 1"), "my.yaml:1: save is 1; accepted: true or false");
  EXPECT_EQ(error_of("offset: [1, 2]"),
            "my.yaml:1: offset is a list of 2; accepted: a list of 3 numbers, -10 to 10 m");
  EXPECT_EQ(error_of("topic: [a]"), "my.yaml:1: topic is a list of 1; accepted: text");
  EXPECT_EQ(error_of("lidar: 3"), "my.yaml:1: lidar must be a group of \"key: value\" lines");
}

TEST(YamlConfig, WordsOfAnEnumAreListedAndTheNearestNamed) {
  EXPECT_EQ(error_of("map: plan"), "my.yaml:1: map is plan (did you mean plane?); accepted: plane | knn");
  EXPECT_EQ(error_of("map: octree"), "my.yaml:1: map is octree; accepted: plane | knn");
}

TEST(YamlConfig, NumbersThatAreNotFiniteAreRefused) {
  for (const char* text : {".inf", "-.INF", ".nan", "inf", "nan", "1e999"}) {
    EXPECT_NE(error_of(std::string("any: ") + text).find("my.yaml:1: any is "), std::string::npos) << text;
  }
}

TEST(YamlConfig, DuplicateKeysAreRefused) {
  EXPECT_EQ(error_of("save: true\n\nsave: false\n"),
            "my.yaml:3: save is given twice, first in line 1; remove one");
}

TEST(YamlConfig, TextThatIsNoMapOfKeysIsRefused) {
  EXPECT_EQ(error_of("hello"), "my.yaml:1: the file must be a group of \"key: value\" lines");
  EXPECT_EQ(error_of("- 1\n- 2\n"), "my.yaml:1: the file must be a group of \"key: value\" lines");
  EXPECT_EQ(error_of("[a]: 1"), "my.yaml:1: a key must be a plain word");
  EXPECT_EQ(error_of("save: true\n---\nsave: false\n").substr(0, 10), "my.yaml:3:");
  EXPECT_EQ(error_of(std::string("#ROSBAG\0", 8)).substr(0, 10), "my.yaml:1:");
}

TEST(YamlConfig, SyntaxErrorsNameTheLine) {
  EXPECT_EQ(error_of("save: true\noffset: [1, 2\n").substr(0, 10), "my.yaml:3:");
  EXPECT_EQ(error_of("save: true\n  topic: x\n").substr(0, 10), "my.yaml:2:");
}

TEST(YamlConfig, OneFaultAtTheEndLeavesEverythingUntouched) {
  error_of("lidar: {voxel_size: 1}\nmap: knn\nsave: 5\n");  // error_of compares before and after
}

TEST(YamlConfig, OverridesSetOneField) {
  TestConfig config;
  ASSERT_TRUE(apply_override(config.fields(), "lidar.voxel_size=0.75").ok());
  ASSERT_TRUE(apply_override(config.fields(), "offset=[1, 2, 3]").ok());
  ASSERT_TRUE(apply_override(config.fields(), "topic=/a=b").ok());
  EXPECT_EQ(config.lidar.voxel_size, 0.75);
  EXPECT_EQ(config.offset[2], 3.0);
  EXPECT_EQ(config.topic, "/a=b");
}

TEST(YamlConfig, BadOverridesSayWhy) {
  EXPECT_EQ(override_error("lidar.voxel_sise=1"),
            "'lidar.voxel_sise=1': unknown key lidar.voxel_sise; did you mean lidar.voxel_size?");
  EXPECT_EQ(override_error("lidar.voxel_size=9"),
            "'lidar.voxel_size=9': lidar.voxel_size is 9, out of range; accepted: a number, 0.05 to 5 m");
  EXPECT_NE(override_error("lidar.voxel_size").find("key=value"), std::string::npos);
  EXPECT_NE(override_error("=1").find("key=value"), std::string::npos);
}

TEST(YamlConfig, WrittenNumbersReadBackToTheSameBits) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    const std::uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    TestConfig written;
    written.any = value;
    TestConfig read;
    ASSERT_TRUE(apply_yaml(read.fields(), to_yaml(written.fields(), i % 2 == 0), "text").ok()) << value;
    std::uint64_t read_bits = 0;
    std::memcpy(&read_bits, &read.any, sizeof value);
    ASSERT_EQ(read_bits, bits) << value;
  }
}

TEST(YamlConfig, WrittenTextReadsBackWhateverItsCharacters) {
  for (const char* text :
       {"",      " ",  "a: b", "# no",      "true",  "~",   "1.5", "\"q\"", "back\\slash", "line\nbreak",
        "\ttab", "[x", "{x",   "/ok/topic", "m/s^2", "- x", "é",   "a # b", "'",           "&a",
        "*a",    "!t", "%"}) {
    TestConfig written;
    written.topic = text;
    TestConfig read;
    read.topic = "something else";
    const Status status = apply_yaml(read.fields(), to_yaml(written.fields(), true), "text");
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(read.topic, text);
  }
}

TEST(YamlConfig, CommentsTellMeaningUnitRangeAndWords) {
  TestConfig config;
  const std::string text = to_yaml(config.fields(), true);
  EXPECT_EQ(text.substr(0, text.find("  # points")),
            "# how scans are thinned\nlidar:\n  # edge of the voxels [0.05 to 5 m]\n  voxel_size: 0.5\n");
  EXPECT_NE(text.find("# kind of local map [plane | knn]\nmap: plane\n"), std::string::npos);
}

TEST(YamlConfig, LongCommentsAreWrapped) {
  double value = 0.0;
  std::string meaning;
  for (int i = 0; i < 60; ++i) meaning += "word ";
  const std::string text = to_yaml({field("x", value, "m", {}, meaning)}, true);
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(line.size(), 100U);
  EXPECT_GE(count, 4);
}

struct Item {
  double size = 1.0;
  Kind kind = Kind::kPlane;
  std::string label;
  LidarConfig lidar;
  Fields fields() {
    return {field("size", size, "m", {0.0, 10.0}, "of the item"),
            field("kind", kind, {"plane", "knn"}, "of the item"), field("label", label, "of the item"),
            group("lidar", lidar, "its own")};
  }
};

struct ListConfig {
  std::vector<Item> items{Item{7.0, Kind::kPlane, "", {}}};
  bool save = true;
  Fields fields() { return {groups("items", items, "a few"), field("save", save, "whether")}; }
};

std::string list_error_of(const std::string& yaml) {
  ListConfig config;
  const Status status = apply_yaml(config.fields(), yaml, "my.yaml");
  EXPECT_EQ(config.items.size(), 1U) << "a refused text must change nothing";
  return status.ok() ? "accepted" : status.error().message;
}

TEST(YamlConfig, AListOfGroupsReplacesTheOldOneAndFillsUpWithDefaults) {
  ListConfig config;
  const Status status = apply_yaml(
      config.fields(), "items:\n  - {size: 2.5, kind: knn}\n  - lidar: {voxel_size: 0.25}\n", "my.yaml");
  ASSERT_TRUE(status.ok()) << status.error().message;
  ASSERT_EQ(config.items.size(), 2U);
  EXPECT_EQ(config.items[0].size, 2.5);
  EXPECT_EQ(config.items[0].kind, Kind::kKnn);
  EXPECT_EQ(config.items[1].size, 1.0);
  EXPECT_EQ(config.items[1].lidar.voxel_size, 0.25);
  ASSERT_TRUE(apply_override(config.fields(), "items=[{size: 3}]").ok());
  ASSERT_EQ(config.items.size(), 1U);
  EXPECT_EQ(config.items[0].size, 3.0);
  ASSERT_TRUE(apply_override(config.fields(), "items=[]").ok());
  EXPECT_TRUE(config.items.empty());
}

TEST(YamlConfig, FaultsInAListNameTheElement) {
  EXPECT_EQ(list_error_of("items:\n  - {size: 2}\n  - {siez: 3}\n"),
            "my.yaml:3: unknown key items[1].siez; did you mean items[1].size?");
  EXPECT_EQ(list_error_of("items:\n  - {size: 20}\n"),
            "my.yaml:2: items[0].size is 20, out of range; accepted: a number, 0 to 10 m");
  EXPECT_EQ(list_error_of("items: {size: 2}\n"),
            "my.yaml:1: items must be a list of groups, - {key: value, ...}");
  EXPECT_EQ(list_error_of("items: [3]\n"), "my.yaml:1: items[0] must be a group of \"key: value\" lines");
  EXPECT_EQ(list_error_of("items: [{size: 2}, {size: 3}]\nsave: 1\n"),
            "my.yaml:2: save is 1; accepted: true or false");
}

TEST(YamlConfig, WrittenListsReadBack) {
  for (const std::size_t size : {0U, 1U, 3U}) {
    ListConfig written;
    written.items.assign(size, Item{0.1, Kind::kKnn, "a, b: {c}", {}});
    ListConfig read;
    const std::string text = to_yaml(written.fields(), size != 1);
    ASSERT_TRUE(apply_yaml(read.fields(), text, "text").ok()) << text;
    ASSERT_EQ(read.items.size(), size);
    EXPECT_EQ(to_yaml(read.fields(), false), to_yaml(written.fields(), false));
    for (const Item& item : read.items) EXPECT_EQ(item.label, "a, b: {c}");
  }
}

TEST(YamlConfig, UnreadableFilesAreNamed) {
  TestConfig config;
  EXPECT_EQ(apply_yaml_file(config.fields(), "/nowhere/x.yaml").error().message,
            "/nowhere/x.yaml: no such file; check the path");
  const std::string folder = std::filesystem::temp_directory_path().string();
  EXPECT_EQ(apply_yaml_file(config.fields(), folder).error().message,
            folder + ": is a folder; give a file");
}

TEST(YamlConfig, FilesAreReadLikeText) {
  const std::string path = testing::TempDir() + "mmlins_yaml_config_test.yaml";
  std::ofstream(path) << "topic: /x\n";
  TestConfig config;
  EXPECT_TRUE(apply_yaml_file(config.fields(), path).ok());
  EXPECT_EQ(config.topic, "/x");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace mmlins::config

// SPDX-License-Identifier: MIT
#include "mmlins/io/pcd_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace mmlins::io {
namespace {

class PcdFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string write(const std::string& content) const {
    std::ofstream(path("cloud.pcd"), std::ios::binary) << content;
    return path("cloud.pcd");
  }
  std::size_t num_files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }

 private:
  std::filesystem::path folder_;
};

const std::string kAsciiHeader =
    "VERSION 0.7\nFIELDS rgb y x z intensity\nSIZE 4 8 4 4 2\nTYPE U F F F U\n"
    "COUNT 2 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA ascii\n";

TEST_F(PcdFile, WhatWasWrittenIsReadAgain) {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> intensities;
  for (int i = 0; i < 10'000; ++i) {
    points.emplace_back(0.1F * static_cast<float>(i), -1.0F, 1e-3F * static_cast<float>(i));
    intensities.push_back(static_cast<float>(i % 256));
  }
  ASSERT_TRUE(write_pcd(path("a.pcd"), points, intensities).ok());
  const auto cloud = read_pcd(path("a.pcd"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->points, points);
  EXPECT_EQ(cloud->intensities, intensities);
  EXPECT_EQ(num_files(), 1U);
}

TEST_F(PcdFile, AnEmptyCloudIsAFileToo) {
  ASSERT_TRUE(write_pcd(path("a.pcd"), {}, {}).ok());
  EXPECT_TRUE(read_pcd(path("a.pcd"))->points.empty());
}

TEST_F(PcdFile, TextWithOtherFieldsIsRead) {
  const auto cloud = read_pcd(write(kAsciiHeader + "9 9 2 1 3 40\n9 9 nan 4 6 50\n"));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_EQ(cloud->points[0], Eigen::Vector3f(1, 2, 3));
  EXPECT_TRUE(std::isnan(cloud->points[1].y()));
  EXPECT_EQ(cloud->intensities, (std::vector<float>{40, 50}));
}

TEST_F(PcdFile, DamagedFilesAreRefusedByName) {
  const auto refused = [this](const std::string& content) {
    const auto cloud = read_pcd(write(content));
    ASSERT_FALSE(cloud.ok()) << content;
    EXPECT_NE(cloud.error().message.find("cloud.pcd"), std::string::npos);
  };
  refused("");
  refused("hello\n");
  refused(kAsciiHeader);
  refused(kAsciiHeader + "9 9 2 1 3 40\n9 9 5 4\n");
  refused(kAsciiHeader + "9 9 2 1 3 40\n9 9 5 4 x 50\n");
  refused("FIELDS x y\nSIZE 4 4\nTYPE F F\nCOUNT 1 1\nPOINTS 0\nDATA ascii\n");
  refused("FIELDS x y z\nSIZE 4 4 5\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 0\nDATA binary\n");
  refused("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 99999999999\nDATA binary\nabc");
  refused("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 1\nDATA binary_compressed\n");
  EXPECT_EQ(read_pcd(path("missing.pcd")).error().code, ErrorCode::kNotFound);
}

TEST_F(PcdFile, AFolderThatIsNotThereLeavesNothingBehind) {
  EXPECT_FALSE(write_pcd(path("nowhere/a.pcd"), {}, {}).ok());
  std::filesystem::create_directory(path("taken"));
  EXPECT_FALSE(write_pcd(path("taken"), {}, {}).ok());
  EXPECT_EQ(num_files(), 1U);
}

}  // namespace
}  // namespace mmlins::io

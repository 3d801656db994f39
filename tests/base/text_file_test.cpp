// SPDX-License-Identifier: MIT
#include "mmlins/base/text_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>

namespace mmlins {
namespace {

namespace fs = std::filesystem;

class TextFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }

  /// One per test, since tests run at the same time.
  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("mmlins_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(TextFile, WrittenTextReadsBackByteForByte) {
  const std::string path = (folder_ / "a.txt").string();
  const std::string text("one\r\ntwo\0three\n", 15);
  ASSERT_TRUE(write_text_file(path, text).ok());
  EXPECT_EQ(*read_text_file(path), text);
  ASSERT_TRUE(write_text_file(path, "").ok());
  EXPECT_EQ(*read_text_file(path), "");
}

TEST_F(TextFile, NothingElseIsLeftBesideTheFile) {
  ASSERT_TRUE(write_text_file((folder_ / "a.txt").string(), "x").ok());
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(TextFile, AFailedWriteLeavesNothingBehind) {
  fs::create_directories(folder_ / "taken" / "inside");
  const Status status = write_text_file((folder_ / "taken").string(), "x");  // a folder of that name
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message.find((folder_ / "taken").string() + ": cannot be written: "), 0U);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
  EXPECT_FALSE(write_text_file((folder_ / "no" / "where").string(), "x").ok());
}

TEST_F(TextFile, WhatCannotBeReadIsNamed) {
  const std::string missing = (folder_ / "missing").string();
  EXPECT_EQ(read_text_file(missing).error().message, missing + ": no such file; check the path");
  EXPECT_EQ(read_text_file(folder_.string()).error().message,
            folder_.string() + ": is a folder; give a file");
}

}  // namespace
}  // namespace mmlins

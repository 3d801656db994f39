// SPDX-License-Identifier: MIT
#include "mmlins/eval/trajectory_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

namespace mmlins::eval {
namespace {

std::string error_of(const std::string& text) {
  const Result<TumFile> file = parse_tum(text, "a.tum");
  return file.ok() ? "accepted" : file.error().message;
}

TEST(TrajectoryFile, StampsKeepEveryNanosecond) {
  EXPECT_EQ(parse_seconds_as_ns("1700000000.123456789"), 1700000000123456789);
  EXPECT_EQ(parse_seconds_as_ns("0.000000001"), 1);
  EXPECT_EQ(parse_seconds_as_ns("-1.5"), -1500000000);
  EXPECT_EQ(parse_seconds_as_ns("12"), 12000000000);
  EXPECT_EQ(parse_seconds_as_ns(".5"), 500000000);
  EXPECT_EQ(parse_seconds_as_ns("+7."), 7000000000);
  EXPECT_EQ(parse_seconds_as_ns("000000000000000000000001"), 1000000000);
  EXPECT_EQ(parse_seconds_as_ns("1.700000000123456789e+09"), 1700000000123456789);
  EXPECT_EQ(parse_seconds_as_ns("17E-10"), 2);
  EXPECT_EQ(parse_seconds_as_ns("1e-40"), 0);
}

TEST(TrajectoryFile, DigitsBeyondTheNanosecondAreRounded) {
  EXPECT_EQ(parse_seconds_as_ns("0.0000000014"), 1);
  EXPECT_EQ(parse_seconds_as_ns("0.0000000015"), 2);
  EXPECT_EQ(parse_seconds_as_ns("0.0000000005"), 1);
  EXPECT_EQ(parse_seconds_as_ns("0.9999999999"), 1000000000);
}

TEST(TrajectoryFile, WhatIsNoTimeIsRefused) {
  for (const char* text : {"", "-", ".", "1.2.3", "abc", "1e", "1e+", "1e+-5", "nan", "inf", "1 ", "0x10",
                           "1e30", "99999999999", "9223372036.8547758079"}) {
    EXPECT_FALSE(parse_seconds_as_ns(text).has_value()) << text;
  }
}

TEST(TrajectoryFile, SecondsAreWrittenAsTheyAreRead) {
  for (const std::int64_t ns : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{1700000000123456789},
                                std::int64_t{-1500000000}, std::numeric_limits<std::int64_t>::max() - 1}) {
    EXPECT_EQ(parse_seconds_as_ns(seconds_text(time_from_ns(ns))), ns);
  }
}

TEST(TrajectoryFile, CommentsAndBlankLinesAreSkippedAndQuaternionsNormalised) {
  const auto file =
      parse_tum("# time x y z qx qy qz qw\r\n\n  \t\n1.5 1 2 3 0 0 0 1.001\r\n2.5\t4 5 6 0 0 1 0", "a.tum");
  ASSERT_TRUE(file.ok()) << file.error().message;
  ASSERT_EQ(file->poses.size(), 2U);
  EXPECT_EQ(to_ns(file->poses[0].time), 1500000000);
  EXPECT_TRUE(file->poses[0].pose.R.isIdentity(1e-15));  // rounding only
  EXPECT_EQ(file->poses[1].pose.t, math::Vector3d(4, 5, 6));
}

TEST(TrajectoryFile, MalformedRowsAreRefusedWithTheirLine) {
  EXPECT_EQ(error_of("# c\n1 0 0 0 0 0 0\n"), "a.tum:2: 7 columns; a pose is \"time x y z qx qy qz qw\"");
  EXPECT_EQ(error_of("1 0 0 0 0 0 0 1\n2 0 zero 0 0 0 0 1\n"), "a.tum:2: \"zero\" is not a finite number");
  EXPECT_EQ(error_of("1 0 nan 0 0 0 0 1\n"), "a.tum:1: \"nan\" is not a finite number");
  EXPECT_EQ(error_of("now 0 0 0 0 0 0 1\n"), "a.tum:1: \"now\" is not a time in seconds");
  EXPECT_EQ(error_of("1 0 0 0 0 0 0 0\n"),
            "a.tum:1: quaternion of length 0; the last four columns are qx qy qz qw");
  EXPECT_EQ(error_of(""), "a.tum: holds no pose; give a file of \"time x y z qx qy qz qw\" lines");
}

TEST(TrajectoryFile, RowsOutOfOrderAreSortedAndCounted) {
  const auto file =
      parse_tum("1 1 0 0 0 0 0 1\n3 3 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n3 9 0 0 0 0 0 1\n", "a.tum");
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(file->num_out_of_order, 1);
  EXPECT_EQ(file->num_duplicates, 1);
  ASSERT_EQ(file->poses.size(), 3U);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(file->poses[static_cast<std::size_t>(i)].pose.t.x(), i + 1.0);
}

TEST(TrajectoryFile, WrittenTrajectoriesReadBack) {
  math::Trajectory written;
  for (int i = 0; i < 20; ++i) {
    const double x = 0.37 * i;
    written.push_back({time_from_ns(1700000000000000001 + 100000007LL * i),
                       {math::so3_exp({x, -0.5 * x, 0.2}), {1000.0 + x, -x, 0.001 * x}}});
  }
  const std::string path = testing::TempDir() + "mmlins_trajectory_file_test.tum";
  ASSERT_TRUE(write_tum(path, written).ok());
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  const Result<TumFile> read = read_tum(path);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->poses.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ(read->poses[i].time, written[i].time);
    EXPECT_TRUE(read->poses[i].pose.t.isApprox(written[i].pose.t, 1e-12));  // 9 decimals
    EXPECT_TRUE(read->poses[i].pose.R.isApprox(written[i].pose.R, 1e-11));  // 12 decimals
  }
  std::filesystem::remove(path);
}

TEST(TrajectoryFile, AFolderThatDoesNotExistIsAnErrorOfOneLine) {
  const Status status = write_tum("/nowhere/at/all.tum", {});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().message.find("/nowhere/at/all.tum: cannot be written"), 0U);
}

}  // namespace
}  // namespace mmlins::eval

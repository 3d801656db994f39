// SPDX-License-Identifier: MIT
// Bags as our own writer makes them, read back through the whole of the reading code. Bags of other
// writers: tests/cli/bags_test.py.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

#include "mmlins/io/open_dataset.hpp"
#include "mmlins/io/rosbag1_writer.hpp"
#include "mmlins/io/topic_timing.hpp"

namespace mmlins::io {
namespace {

using sensor::ImuSample;
using sensor::LidarScan;

constexpr std::int64_t kStart = 1'700'000'000'000'000'123;  // [ns]

LidarScan make_scan(int index, int num_points = 50) {
  LidarScan scan;
  scan.start_time = time_from_ns(kStart + index * 100'000'000LL);
  for (int i = 0; i < num_points; ++i) {
    scan.points.emplace_back(1.0F + static_cast<float>(i), 0.5F * static_cast<float>(index), -2.0F);
    scan.offsets.push_back(static_cast<float>(0.0990 * i / (num_points - 1)));
    scan.intensities.push_back(static_cast<float>(i % 7));
    scan.rings.push_back(static_cast<std::uint16_t>(i % 16));
  }
  scan.end_time = scan.start_time +
                  (num_points > 0 ? from_seconds(static_cast<double>(scan.offsets.back())) : Duration(0));
  return scan;
}

ImuSample make_sample(int index) {
  ImuSample sample;
  sample.time = time_from_ns(kStart + index * 5'000'000LL);
  sample.gyro = {0.1, 0.01 * index, -0.3};
  sample.accel = {0.5, 9.8, 1e-3 * index};
  return sample;
}

class Recording : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_))
      names.push_back(entry.path().filename());
    return names;
  }

  /// One second: 10 scans and 200 samples, each recorded when it is complete.
  void write_second(RosbagWriter& writer) const {
    for (int i = 0; i < 200; ++i) {
      const ImuSample sample = make_sample(i);
      ASSERT_TRUE(writer.write_imu("/imu", "imu", sample, sample.time).ok());
      if (i % 20 != 19) continue;
      const LidarScan scan = make_scan(i / 20);
      ASSERT_TRUE(writer.write_scan("/points", "lidar", scan, scan.end_time).ok());
    }
  }
  std::string write_default(const std::string& name) const {
    auto writer = RosbagWriter::create(path(name));
    EXPECT_TRUE(writer.ok());
    write_second(*writer);
    EXPECT_TRUE(writer->close().ok());
    return path(name);
  }

 private:
  std::filesystem::path folder_;
};

struct Contents {
  std::vector<LidarScan> scans;
  std::vector<ImuSample> samples;
  std::vector<char> order;  ///< l or i, per item
};

Contents read_all(sensor::Dataset& dataset) {
  Contents contents;
  while (true) {
    auto item = dataset.next();
    EXPECT_TRUE(item.ok()) << item.error().message;
    if (!item.ok() || std::holds_alternative<sensor::EndOfData>(*item)) return contents;
    if (auto* scan = std::get_if<LidarScan>(&*item)) {
      contents.scans.push_back(std::move(*scan));
      contents.order.push_back('l');
    } else {
      contents.samples.push_back(std::get<ImuSample>(*item));
      contents.order.push_back('i');
    }
  }
}

std::string content_of(const std::string& path) {
  std::ostringstream content;
  content << std::ifstream(path, std::ios::binary).rdbuf();
  return content.str();
}

TEST_F(Recording, WhatWasWrittenIsReadAgainInTheSameOrder) {
  auto opened = open_dataset(write_default("a.bag"), {});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  const Contents contents = read_all(*opened->dataset);
  ASSERT_EQ(contents.scans.size(), 10U);
  ASSERT_EQ(contents.samples.size(), 200U);
  for (int i = 0; i < 200; ++i) {
    const ImuSample& sample = contents.samples[static_cast<std::size_t>(i)];
    EXPECT_EQ(sample.time, make_sample(i).time);
    EXPECT_EQ(sample.gyro, make_sample(i).gyro);
    EXPECT_EQ(sample.accel, make_sample(i).accel);
  }
  for (int i = 0; i < 10; ++i) {
    const LidarScan& scan = contents.scans[static_cast<std::size_t>(i)];
    const LidarScan truth = make_scan(i);
    EXPECT_EQ(scan.points, truth.points);
    EXPECT_EQ(scan.intensities, truth.intensities);
    EXPECT_EQ(scan.rings, truth.rings);
    EXPECT_EQ(scan.start_time, truth.start_time);
    // Through whole nanoseconds and back to float32, which resolves 7 ns at 0.1 s.
    EXPECT_LE(std::abs((scan.end_time - truth.end_time).count()), 1);
    for (std::size_t k = 0; k < scan.size(); ++k) EXPECT_NEAR(scan.offsets[k], truth.offsets[k], 8e-9F);
  }
  EXPECT_EQ(contents.order[19], 'i');
  EXPECT_EQ(contents.order[20], 'l');
  EXPECT_EQ(opened->dataset->progress(), 1.0);
}

TEST_F(Recording, TheSameCallsWriteTheSameBytes) {
  EXPECT_EQ(content_of(write_default("a.bag")), content_of(write_default("b.bag")));
}

TEST_F(Recording, WhatIsFoundOutIsReported) {
  const auto info = inspect_recording(write_default("a.bag"), {});
  ASSERT_TRUE(info.ok()) << info.error().message;
  EXPECT_TRUE(info->problems.empty());
  EXPECT_EQ(info->num_messages, 210U);
  ASSERT_EQ(info->topics.size(), 2U);
  EXPECT_EQ(info->topics[0].name, "/imu");
  EXPECT_TRUE(info->topics[0].timing.by_stamp);
  ASSERT_TRUE(info->lidar.has_value());
  EXPECT_EQ(info->lidar->time.field, "time");
  EXPECT_EQ(info->lidar->time.unit, sensor::TimeUnit::kSeconds);
  EXPECT_NEAR(info->lidar->rate_hz, 10.0, 1e-9);
  EXPECT_EQ(info->lidar->num_rings, 16);
  EXPECT_EQ(info->lidar->points_per_scan, 50U);
  ASSERT_TRUE(info->imu.has_value());
  EXPECT_NEAR(info->imu->rate_hz, 200.0, 1e-9);
  EXPECT_EQ(info->imu->accel_unit, sensor::AccelUnit::kMetresPerSecondSquared);
}

TEST_F(Recording, TheOffsetOfTheRigMovesTheScansAlone) {
  sensor::Rig rig;
  rig.lidar_time_offset = 0.025;
  auto opened = open_dataset(write_default("a.bag"), rig);
  ASSERT_TRUE(opened.ok());
  const Contents contents = read_all(*opened->dataset);
  EXPECT_EQ(contents.scans[0].start_time, time_from_ns(kStart + 25'000'000));
  EXPECT_EQ(contents.samples[0].time, time_from_ns(kStart));
}

TEST_F(Recording, SamplesThatAreNotFiniteAndEmptyScansAreTold) {
  auto writer = RosbagWriter::create(path("a.bag"));
  write_second(*writer);
  ImuSample bad = make_sample(300);
  bad.accel.x() = std::numeric_limits<double>::quiet_NaN();
  ASSERT_TRUE(writer->write_imu("/imu", "imu", bad, bad.time).ok());
  const LidarScan empty = make_scan(20, 0);
  ASSERT_TRUE(writer->write_scan("/points", "lidar", empty, empty.start_time).ok());
  ASSERT_TRUE(writer->close().ok());
  auto opened = open_dataset(path("a.bag"), {});
  ASSERT_TRUE(opened.ok());
  const Contents contents = read_all(*opened->dataset);
  EXPECT_EQ(contents.samples.size(), 200U);
  ASSERT_EQ(contents.scans.size(), 11U);
  EXPECT_TRUE(contents.scans[10].points.empty());
  EXPECT_EQ(contents.scans[10].start_time, empty.start_time);
  EXPECT_EQ(contents.scans[10].end_time, empty.start_time);
}

TEST_F(Recording, StampsThatJumpArePassedOnInTheOrderOfRecording) {
  auto writer = RosbagWriter::create(path("a.bag"));
  write_second(*writer);
  LidarScan late = make_scan(3);
  ASSERT_TRUE(writer->write_scan("/points", "lidar", late, time_from_ns(kStart + 2'000'000'000)).ok());
  ASSERT_TRUE(writer->close().ok());
  auto opened = open_dataset(path("a.bag"), {});
  const Contents contents = read_all(*opened->dataset);
  EXPECT_EQ(contents.scans.back().start_time, late.start_time);
  EXPECT_EQ(inspect_recording(path("a.bag"), {})->topics[1].timing.num_not_forward, 1);
}

TEST_F(Recording, ABagThatIsNotClosedLeavesNothing) {
  {
    auto writer = RosbagWriter::create(path("a.bag"));
    write_second(*writer);
  }
  EXPECT_TRUE(files().empty());
}

TEST_F(Recording, ABagThatCannotBeWrittenIsAnError) {
  EXPECT_FALSE(RosbagWriter::create(path("nowhere/a.bag")).ok());
  std::filesystem::create_directory(path("taken.bag"));
  EXPECT_FALSE(RosbagWriter::create(path("taken.bag")).ok());
  auto writer = RosbagWriter::create(path("a.bag"));
  EXPECT_FALSE(
      writer->write_imu("/imu", "imu", make_sample(0), Time{}).ok());  // time zero means unset in a bag
  EXPECT_FALSE(writer->write_imu("/imu", "imu", ImuSample{time_from_ns(-1)}, time_from_ns(1)).ok());
}

TEST_F(Recording, EveryTruncationIsAnErrorThatNamesTheFile) {
  const std::string whole = content_of(write_default("whole.bag"));
  for (std::size_t i = 0; i < 60; ++i) {
    const std::size_t size = whole.size() * i / 60;
    std::ofstream(path("cut.bag"), std::ios::binary) << whole.substr(0, size);
    const auto opened = open_dataset(path("cut.bag"), {});
    ASSERT_FALSE(opened.ok()) << size;
    EXPECT_NE(opened.error().message.find("cut.bag"), std::string::npos);
    EXPECT_EQ(opened.error().message.find('\n'), std::string::npos);
  }
}

TEST(TopicTiming, GapsAreCountedAndTheLongestIsFound) {
  std::vector<Time> times;
  for (const int ms : {0, 10, 20, 60, 70, 80, 80, 30, 40, 90, 100, 110, 120})
    times.push_back(Time{} + Duration(ms * 1'000'000));
  const TopicTiming timing = measure_timing(times, true);
  EXPECT_EQ(timing.rate_hz(), 100.0);
  EXPECT_EQ(timing.num_gaps, 2);  // 20 to 60, and after the jump back 40 to 90; three periods are none
  EXPECT_EQ(timing.longest_gap, Duration(50'000'000));
  EXPECT_EQ(timing.longest_gap_start, Time{} + Duration(40'000'000));
  EXPECT_EQ(timing.num_not_forward, 2);
}

TEST(TopicTiming, FewMessagesHaveNoRate) {
  EXPECT_EQ(measure_timing({}, true).rate_hz(), 0.0);
  EXPECT_EQ(measure_timing({Time{}}, true).rate_hz(), 0.0);
  EXPECT_EQ(measure_timing({Time{}, Time{}}, true).rate_hz(), 0.0);
}

}  // namespace
}  // namespace mmlins::io

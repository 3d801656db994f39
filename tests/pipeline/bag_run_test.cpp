// SPDX-License-Identifier: MIT
// The whole way from a bag on disk to poses, with what sensors really send.

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <string>

#include "mmlins/io/open_dataset.hpp"
#include "mmlins/io/rosbag1_writer.hpp"
#include "tests/pipeline/edited_recording.hpp"

namespace mmlins::pipeline {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Every seventh point is not a number or infinite, and two clouds are nothing else.
Items with_bad_points() {
  Items items = recording().items;
  int scans = 0;
  for (sensor::Item& item : items) {
    auto* scan = std::get_if<sensor::LidarScan>(&item);
    if (!scan) continue;
    ++scans;
    const std::size_t step = scans == 40 || scans == 41 ? 1 : 7;
    for (std::size_t i = 0; i < scan->size(); i += step) {
      scan->points[i] =
          i % 2 == 0 ? Eigen::Vector3f(kNaN, kNaN, kNaN) : Eigen::Vector3f(1.0F, kInfinity, 2.0F);
    }
  }
  return items;
}

void write_bag(const std::string& path, const Items& items) {
  auto bag = io::RosbagWriter::create(path);
  ASSERT_TRUE(bag.ok()) << bag.error().message;
  const sensor::Rig& rig = recording().rig;
  for (const sensor::Item& item : items) {
    const Status status =
        is_scan(item)
            ? bag->write_scan(rig.lidar_topic, "lidar", std::get<sensor::LidarScan>(item), time_of(item))
            : bag->write_imu(rig.imu_topic, "imu", std::get<sensor::ImuSample>(item), time_of(item));
    ASSERT_TRUE(status.ok()) << status.error().message;
  }
  ASSERT_TRUE(bag->close().ok());
}

TEST(BagRun, PointsThatAreNotFiniteAreLeftOutAndDoNoHarm) {
  const std::string path = testing::TempDir() + "mmlins_bad_points.bag";
  write_bag(path, with_bad_points());
  auto opened = io::open_dataset(path, recording().rig);
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  const RunResult result = run(*opened->dataset, recording().rig, SlamConfig{}, {});
  std::filesystem::remove(path);
  ASSERT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  for (const ScanRecord& record : result.scans) {
    ASSERT_TRUE(record.T_odom_imu.t.allFinite());
    EXPECT_EQ(record.state == odometry::TrackingState::kBridging, record.num_points == 0);
  }
  EXPECT_EQ(result.scans[39].cause, odometry::Cause::kNoPoints);
  EXPECT_EQ(result.scans[40].cause, odometry::Cause::kNoPoints);
  for (const Eigen::Vector3f& point : result.map.points_map()) ASSERT_TRUE(point.allFinite());
  // As in slam_system_test.cpp: far more than it errs by, far less than when it is lost.
  EXPECT_LT(error_at(result, result.scans.back()), 0.15);
}

}  // namespace
}  // namespace mmlins::pipeline

// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/slam_system.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "mmlins/base/parallel.hpp"
#include "tests/atlas/example.hpp"
#include "tests/pipeline/edited_recording.hpp"

namespace mmlins::pipeline {
namespace {

using odometry::Cause;
using odometry::TrackingState;

// A robot of a thousand points per scan in a hall of 40 m does better than that by far; one that has lost its
// way, or that has taken a jump of the clock for motion, does worse by far.
constexpr double kNotLost = 0.15;  // [m]

void expect_in_order(const RunResult& result) {
  for (std::size_t i = 1; i < result.scans.size(); ++i) {
    EXPECT_GT(result.scans[i].time, result.scans[i - 1].time) << i;
  }
  for (const ScanRecord& record : result.scans) {
    EXPECT_TRUE(record.T_odom_imu.R.allFinite() && record.T_odom_imu.t.allFinite());
  }
}

sensor::LidarScan without_points(const sensor::LidarScan& scan) {
  sensor::LidarScan empty;
  empty.start_time = scan.start_time;
  empty.end_time = scan.end_time;
  return empty;
}

bool same_bits(const RunResult& a, const RunResult& b) {
  const auto same = [](const ScanRecord& x, const ScanRecord& y) {
    return x.time == y.time && x.T_odom_imu.R == y.T_odom_imu.R && x.T_odom_imu.t == y.T_odom_imu.t &&
           x.state == y.state && x.num_matches == y.num_matches && x.residual_rms == y.residual_rms &&
           x.position_std == y.position_std && x.rotation_std == y.rotation_std;
  };
  return std::equal(a.scans.begin(), a.scans.end(), b.scans.begin(), b.scans.end(), same) &&
         a.map.points_map() == b.map.points_map() && a.map.intensities() == b.map.intensities();
}

TEST(SlamSystem, EveryScanHasAPoseAndThePosesAreRight) {
  const RunResult result = run_items(recording().items);
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  EXPECT_EQ(result.num_scans_without_imu + result.num_scans_not_later + result.num_late_imu_samples, 0);
  EXPECT_EQ(result.num_clock_jumps, 0);
  EXPECT_FALSE(result.interrupted);
  EXPECT_TRUE(result.read_error.empty());
  EXPECT_GT(result.map.points_map().size(), 1000U);
  EXPECT_EQ(result.map.points_map().size(), result.map.intensities().size());
  expect_in_order(result);
  for (const ScanRecord& record : result.scans) {
    EXPECT_NE(record.state, TrackingState::kBridging);
    EXPECT_LT(error_at(result, record), kNotLost);
  }
  EXPECT_EQ(result.scans.front().state, TrackingState::kInitializing);
  EXPECT_EQ(result.scans.back().state, TrackingState::kTracking);
  std::size_t scan = 0;
  for (const sensor::Item& item : recording().items) {
    if (!is_scan(item)) continue;
    EXPECT_EQ(result.scans[scan++].time, time_of(item));
  }
}

TEST(SlamSystem, GivesTheSameBitsAgainAndWhateverTheNumberOfThreads) {
  parallel::set_num_threads(1);
  const RunResult one = run_items(recording().items);
  parallel::set_num_threads(2);
  const RunResult two = run_items(recording().items);
  const RunResult again = run_items(recording().items);
  parallel::set_num_threads(0);
  EXPECT_TRUE(same_bits(one, two));
  EXPECT_TRUE(same_bits(two, again));
}

TEST(SlamSystem, EmptyScansAreBridgedAndTrackingGoesOnAfterThem) {
  Items items = recording().items;
  int emptied = 0;
  for (sensor::Item& item : items) {
    auto* scan = std::get_if<sensor::LidarScan>(&item);
    if (!scan || scan->end_time < after(4.0) || scan->end_time > after(4.5)) continue;
    *scan = without_points(*scan);
    ++emptied;
  }
  ASSERT_GT(emptied, 3);
  const RunResult result = run_items(std::move(items));
  ASSERT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  int bridged = 0;
  for (const ScanRecord& record : result.scans) {
    if (record.state != TrackingState::kBridging) continue;
    ++bridged;
    EXPECT_EQ(record.cause, Cause::kNoPoints);
    EXPECT_EQ(record.num_points, 0);
  }
  EXPECT_EQ(bridged, emptied);
  EXPECT_EQ(result.scans.back().state, TrackingState::kTracking);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
}

TEST(SlamSystem, ALidarThatSeesNothingIsNotCalledTracking) {
  Items items = recording().items;
  for (sensor::Item& item : items) {
    if (auto* scan = std::get_if<sensor::LidarScan>(&item)) {
      *scan = without_points(*scan);
    }
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  for (const ScanRecord& record : result.scans) {
    EXPECT_TRUE(record.state == TrackingState::kBridging || record.state == TrackingState::kLost);
    EXPECT_EQ(record.cause, Cause::kNoPoints);
  }
  EXPECT_EQ(result.scans.back().state, TrackingState::kLost);
  EXPECT_EQ(result.maps.size(), 1U);
  expect_in_order(result);
}

TEST(SlamSystem, ScansOutOfOrderAndDuplicatesAreCountedAndLeftOut) {
  Items items;
  int scans = 0;
  std::optional<sensor::Item> held;
  for (const sensor::Item& item : recording().items) {
    if (is_scan(item)) ++scans;
    if (is_scan(item) && scans == 30) {  // comes after its successor
      held = item;
      continue;
    }
    items.push_back(item);
    if (is_scan(item) && scans == 31) items.push_back(*held);
    if (is_scan(item) && scans == 50) items.push_back(item);  // comes twice
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(result.num_scans_not_later, 2);
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans - 1);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
  expect_in_order(result);
}

TEST(SlamSystem, DuplicateImuSamplesAreCountedAndChangeNothing) {
  Items items;
  int duplicates = 0;
  for (const sensor::Item& item : recording().items) {
    items.push_back(item);
    if (is_scan(item) || items.size() % 7 != 0) continue;
    items.push_back(item);
    ++duplicates;
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(result.num_late_imu_samples, duplicates);
  EXPECT_TRUE(same_bits(result, run_items(recording().items)));
}

TEST(SlamSystem, AnImuGapIsNamedAndSurvived) {
  Items items;
  for (const sensor::Item& item : recording().items) {
    if (is_scan(item) || time_of(item) < after(5.0) || time_of(item) > after(5.5)) items.push_back(item);
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  const auto gaps = std::count_if(result.scans.begin(), result.scans.end(),
                                  [](const ScanRecord& record) { return record.cause != Cause::kNone; });
  // The gap of 0.5 s reaches over that many scans, and into one more at least.
  EXPECT_GE(gaps, 5);
  EXPECT_LE(gaps, 7);
  EXPECT_EQ(result.scans.back().state, TrackingState::kTracking);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
  expect_in_order(result);
}

TEST(SlamSystem, ScansFromBeforeTheImuAreCountedAndTheRestIsUsed) {
  Items items;
  int before = 0;
  for (const sensor::Item& item : recording().items) {
    if (!is_scan(item) && time_of(item) < after(1.0)) continue;
    if (is_scan(item)) before += std::get<sensor::LidarScan>(item).start_time < after(1.0);
    items.push_back(item);
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(result.num_scans_without_imu, before);
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans - before);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
}

TEST(SlamSystem, WithoutImuThereAreNoPosesButACount) {
  Items items;
  for (const sensor::Item& item : recording().items) {
    if (is_scan(item)) items.push_back(item);
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_TRUE(result.scans.empty());
  EXPECT_EQ(result.num_scans_without_imu, recording().num_scans);
}

TEST(SlamSystem, AnImuThatDiesLeavesTheScansToCarryThePose) {
  Items items;
  for (const sensor::Item& item : recording().items) {
    if (is_scan(item) || time_of(item) < after(5.0)) items.push_back(item);
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  EXPECT_NE(result.scans.back().cause, Cause::kNone);
  // The scans alone hold the robot in its map.
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
  expect_in_order(result);
}

TEST(SlamSystem, AClockThatJumpsBackLeavesTheTrajectoryWhole) {
  const RunResult result = run_items(with_clock_jump(after(5.0), from_seconds(-100.0)));
  EXPECT_EQ(result.num_clock_jumps, 1);
  // The scan that begins before the jump and ends after it may go.
  EXPECT_GE(static_cast<int>(result.scans.size()), recording().num_scans - 1);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
  expect_in_order(result);
}

TEST(SlamSystem, AClockThatJumpsForwardLosesNoScan) {
  const Duration jump = from_seconds(100.0);
  const RunResult result = run_items(with_clock_jump(after(5.0), jump));
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
  EXPECT_LT(error_at(result, result.scans.back(), jump), kNotLost);
  EXPECT_EQ(result.scans.back().state, TrackingState::kTracking);
  expect_in_order(result);
}

TEST(SlamSystem, OneScanFromTheFutureCostsThatScanAlone) {
  Items items = recording().items;
  int num_scans = 0;
  for (sensor::Item& item : items) {
    auto* scan = std::get_if<sensor::LidarScan>(&item);
    if (!scan || ++num_scans != 40) continue;
    scan->start_time += from_seconds(3600.0);
    scan->end_time += from_seconds(3600.0);
  }
  const RunResult result = run_items(std::move(items));
  EXPECT_EQ(result.num_scans_ahead, 1);
  EXPECT_EQ(result.num_scans_not_later, 0);
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans - 1);
  EXPECT_EQ(result.scans.back().state, TrackingState::kTracking);
  EXPECT_LT(error_at(result, result.scans.back()), kNotLost);
  expect_in_order(result);
}

TEST(SlamSystem, ADamagedRecordingKeepsWhatCameBefore) {
  Items items = recording().items;
  items.resize(items.size() / 2);
  const auto scans = std::count_if(items.begin(), items.end(), is_scan);
  const RunResult result = run_items(std::move(items), "recording.bag is cut off");
  EXPECT_EQ(result.read_error, "recording.bag is cut off");
  EXPECT_EQ(static_cast<std::ptrdiff_t>(result.scans.size()), scans);
}

TEST(SlamSystem, SaysThatTheMapLacksWhatCannotBeReadBack) {
  const atlas::TemporaryFolder folder;
  auto atlas = atlas::Atlas::create(folder / "atlas");
  ASSERT_TRUE(atlas.ok());
  const std::string chunk = folder / "atlas/points_0000.chunk";
  const Observer take_away = [&](const ScanRecord&, double) {
    std::filesystem::remove(chunk);
    return true;
  };
  SlamConfig config;
  config.mapping.memory_mb = 0;
  MemoryDataset dataset(recording().items);
  const RunResult result = run(dataset, recording().rig, config, take_away, &*atlas);
  EXPECT_NE(result.mapping.error.find(chunk + ": is missing"), std::string::npos) << result.mapping.error;
  EXPECT_EQ(static_cast<int>(result.scans.size()), recording().num_scans);
}

TEST(SlamSystem, StopsWhenToldToAndKeepsWhatThereIs) {
  int seen = 0;
  const RunResult result =
      run_items(recording().items, "", [&](const ScanRecord&, double) { return ++seen < 40; });
  EXPECT_TRUE(result.interrupted);
  // What the start gives out at once is kept as well.
  EXPECT_GE(result.scans.size(), 40U);
  EXPECT_LT(static_cast<int>(result.scans.size()), recording().num_scans);
}

TEST(SlamSystem, ARecordingShorterThanTheStartStillGivesPoses) {
  Items items;
  for (const sensor::Item& item : recording().items) {
    if (time_of(item) < after(0.6)) items.push_back(item);
  }
  const auto scans = std::count_if(items.begin(), items.end(), is_scan);
  ASSERT_GT(scans, 2);
  EXPECT_EQ(static_cast<std::ptrdiff_t>(run_items(std::move(items)).scans.size()), scans);
}

TEST(SlamSystem, NothingInGivesNothingOut) {
  const RunResult result = run_items({});
  EXPECT_TRUE(result.scans.empty());
  EXPECT_TRUE(result.read_error.empty());
  EXPECT_FALSE(result.interrupted);
}

}  // namespace
}  // namespace mmlins::pipeline

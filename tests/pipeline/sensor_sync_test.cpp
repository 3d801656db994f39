// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/sensor_sync.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mmlins::pipeline {
namespace {

Time at(double seconds) { return time_from_ns(1700000000000000000) + from_seconds(seconds); }

sensor::ImuSample sample_at(double seconds) { return {at(seconds), {0, 0, 0}, {0, 0, 9.81}}; }

/// A sweep of 0.1 s that ends at `seconds`.
sensor::LidarScan scan_at(double seconds) {
  sensor::LidarScan scan;
  scan.start_time = at(seconds - 0.1);
  scan.end_time = at(seconds);
  return scan;
}

/// Samples every 10 ms, both ends included.
void add_imu(SensorSync& sync, double from, double to) {
  for (int i = 0; from + 0.01 * i <= to + 1e-6; ++i) sync.add(sample_at(from + 0.01 * i));
}

double seconds_of(const SyncedScan& synced) { return to_seconds(synced.scan->end_time - at(0.0)); }

/// All that is ready.
std::vector<SyncedScan> drain(SensorSync& sync) {
  std::vector<SyncedScan> all;
  while (auto synced = sync.next()) all.push_back(std::move(*synced));
  return all;
}

TEST(SensorSync, AScanWaitsUntilTheImuHasReachedItsEnd) {
  SensorSync sync;
  add_imu(sync, 0.0, 0.15);
  sync.add(scan_at(0.2));
  EXPECT_FALSE(sync.next());
  add_imu(sync, 0.16, 0.19);
  EXPECT_FALSE(sync.next());
  sync.add(sample_at(0.2));
  const auto synced = sync.next();
  ASSERT_TRUE(synced);
  EXPECT_EQ(synced->imu.size(), 21U);
  EXPECT_EQ(synced->imu.back().time, synced->scan->end_time);
  EXPECT_FALSE(sync.next());
}

TEST(SensorSync, EverySampleIsGivenOutOnce) {
  SensorSync sync;
  std::size_t count = 0;
  for (int i = 1; i <= 10; ++i) {
    sync.add(scan_at(0.1 * i));
    add_imu(sync, 0.1 * i - 0.09, 0.1 * i);
    for (const SyncedScan& synced : drain(sync)) count += synced.imu.size();
  }
  EXPECT_EQ(count, 100U);
  EXPECT_EQ(sync.num_late_imu_samples(), 0);
}

TEST(SensorSync, ADeadImuDoesNotStopTheScans) {
  SensorSync sync;
  add_imu(sync, 0.0, 0.5);
  int given = 0;
  for (int i = 1; i <= 50; ++i) {
    sync.add(scan_at(0.1 * i));
    given += static_cast<int>(drain(sync).size());
  }
  // Five had their samples; of the others at most a second's worth still waits.
  EXPECT_GE(given, 50 - 11);
  sync.finish();
  EXPECT_EQ(given + static_cast<int>(drain(sync).size()), 50);
}

TEST(SensorSync, WithoutAnyImuTheScansComeInTheEnd) {
  SensorSync sync;
  for (int i = 1; i <= 5; ++i) sync.add(scan_at(0.1 * i));
  EXPECT_TRUE(drain(sync).empty());
  sync.finish();
  EXPECT_EQ(drain(sync).size(), 5U);
}

TEST(SensorSync, DuplicateAndLateSamplesAreCountedAndLeftOut) {
  SensorSync sync;
  add_imu(sync, 0.0, 0.1);
  sync.add(sample_at(0.1));   // twice
  sync.add(sample_at(0.05));  // late, but no jump
  sync.add(scan_at(0.1));
  const auto synced = sync.next();
  ASSERT_TRUE(synced);
  EXPECT_EQ(synced->imu.size(), 11U);
  EXPECT_EQ(sync.num_late_imu_samples(), 2);
  EXPECT_EQ(sync.num_clock_jumps(), 0);
}

TEST(SensorSync, AClockThatJumpsBackIsShiftedSoThatTimeGoesOn) {
  SensorSync sync;
  add_imu(sync, 0.0, 1.0);
  sync.add(scan_at(1.0));
  EXPECT_EQ(drain(sync).size(), 1U);
  // The clock is set back by 100 s; samples and scans keep their rates.
  add_imu(sync, 1.01 - 100.0, 1.2 - 100.0);
  sync.add(scan_at(1.1 - 100.0));
  sync.add(scan_at(1.2 - 100.0));
  const auto after = drain(sync);
  ASSERT_EQ(after.size(), 2U);
  EXPECT_EQ(sync.num_clock_jumps(), 1);
  EXPECT_EQ(sync.num_late_imu_samples(), 0);
  // The first sample after the jump follows one period after the last before it.
  EXPECT_NEAR(seconds_of(after[0]), 1.1, 1e-9);
  EXPECT_NEAR(seconds_of(after[1]), 1.2, 1e-9);
  EXPECT_EQ(after[0].imu.size(), 20U);
  EXPECT_EQ(after[0].imu.front().time, at(1.01));
}

TEST(SensorSync, AScanFromBeforeTheJumpThatComesAfterItKeepsItsTime) {
  SensorSync sync;
  add_imu(sync, 0.0, 1.0);
  add_imu(sync, 1.01 - 100.0, 1.1 - 100.0);
  sync.add(scan_at(1.0));
  sync.add(scan_at(1.1 - 100.0));
  const auto scans = drain(sync);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_NEAR(seconds_of(scans[0]), 1.0, 1e-9);
  EXPECT_NEAR(seconds_of(scans[1]), 1.1, 1e-9);
}

TEST(SensorSync, JumpsBackAddUp) {
  SensorSync sync;
  add_imu(sync, 0.0, 1.0);
  add_imu(sync, 1.01 - 100.0, 2.0 - 100.0);
  add_imu(sync, 2.01 - 300.0, 3.0 - 300.0);
  sync.add(scan_at(3.0 - 300.0));
  const auto scans = drain(sync);
  ASSERT_EQ(scans.size(), 1U);
  EXPECT_NEAR(seconds_of(scans[0]), 3.0, 1e-9);
  EXPECT_EQ(sync.num_clock_jumps(), 2);
}

TEST(SensorSync, OneStampFarAheadShiftsTheRestByNoMoreThanItself) {
  SensorSync sync;
  add_imu(sync, 0.0, 1.0);
  sync.add(sample_at(50.0));
  add_imu(sync, 1.02, 2.0);
  sync.add(scan_at(2.0));
  const auto scans = drain(sync);
  ASSERT_EQ(scans.size(), 1U);
  // 1.02 s follows one period after 50 s.
  EXPECT_NEAR(seconds_of(scans[0]), 50.01 + 0.98, 1e-9);
}

TEST(SensorSync, AfterAJumpForwardNoScanIsLost) {
  SensorSync sync;
  int given = 0;
  for (int i = 1; i <= 20; ++i) {
    const double t = 0.1 * i + (i > 10 ? 100.0 : 0.0);
    sync.add(scan_at(t));
    add_imu(sync, t - 0.09, t);
    given += static_cast<int>(drain(sync).size());
  }
  EXPECT_EQ(given, 20);
}

TEST(SensorSync, AScanFromTheFutureIsCountedAndLeftOut) {
  SensorSync sync;
  std::vector<SyncedScan> all;
  for (int i = 1; i <= 10; ++i) {
    sync.add(scan_at(i == 4 || i == 5 ? 3600.0 + 0.1 * i : 0.1 * i));
    add_imu(sync, 0.1 * i - 0.09, 0.1 * i);
    for (SyncedScan& synced : drain(sync)) all.push_back(std::move(synced));
  }
  ASSERT_EQ(all.size(), 8U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_NEAR(seconds_of(all[i]), 0.1 * static_cast<double>(i < 3 ? i + 1 : i + 3), 1e-9);
    EXPECT_LE(all[i].scan->end_time, all[i].imu.back().time);
  }
  EXPECT_EQ(sync.num_scans_ahead(), 2);
  EXPECT_EQ(sync.num_clock_jumps(), 0);
}

TEST(SensorSync, ScansThatStayAheadOfTheImuAreGivenOut) {
  SensorSync sync;
  std::size_t given = 0;
  for (int i = 1; i <= 50; ++i) {
    sync.add(scan_at(100.0 + 0.1 * i));
    add_imu(sync, 0.1 * i - 0.09, 0.1 * i);
    given += drain(sync).size();
  }
  sync.finish();
  EXPECT_EQ(given + drain(sync).size(), 50U);
  EXPECT_EQ(sync.num_scans_ahead(), 0);
}

}  // namespace
}  // namespace mmlins::pipeline

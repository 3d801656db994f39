// SPDX-License-Identifier: MIT
// Starts with nothing known, in motion: found, or refused, but never guessed. The truth is the simulator's.

#include <gtest/gtest.h>

#include <algorithm>

#include "mmlins/odometry/startup.hpp"
#include "tests/odometry/simulated_drive.hpp"

namespace mmlins::odometry {
namespace {

/// Between houses far apart at 40 km/h: the first passes find half of the speed.
const std::vector<std::string> kFastCar = {
    "world.scene=urban",   "world.seed=513",       "world.yaw_deg=-83.7", "sensor.model=os1_64",
    "sensor.columns=360",  "trajectory.speed=11",  "imu.model=bmi088",    "trajectory.start_lap=0.7"};

struct Window {
  std::vector<ScanPointer> scans;
  sensor::ImuBuffer imu;
  sensor::Rig rig;
  Time end;
  double speed = 0.0;  ///< true, at the end [m/s]
};

Window first_seconds(double seconds) {
  auto config = sim::load_scenario("dev_start_in_motion", kFastCar);
  EXPECT_TRUE(config.ok()) << config.error().message;
  sim::Simulation simulation(*config);
  Window window;
  window.rig = simulation.rig();
  while (window.scans.empty() || to_seconds(window.scans.back()->end_time - simulation.start_time()) < seconds) {
    auto item = simulation.next();
    if (auto* scan = std::get_if<sensor::LidarScan>(&*item)) {
      window.scans.push_back(std::make_shared<const sensor::LidarScan>(std::move(*scan)));
    } else {
      EXPECT_EQ(window.imu.add(std::get<sensor::ImuSample>(*item)), sensor::ImuAdmission::kAccepted);
    }
  }
  window.end = window.scans.back()->end_time;
  window.speed = simulation.velocity_world(window.end).norm();
  return window;
}

bool holds_scan(const sensor::Item& item) { return std::holds_alternative<sensor::LidarScan>(item); }

TEST(ColdStart, ASpeedThatHasNotSettledIsRefused) {
  const Window window = first_seconds(2.3);
  OdometryConfig config;
  config.start.max_passes = 3;
  const auto hasty = find_start(config, window.rig, window.scans, window.imu);
  ASSERT_TRUE(hasty);
  // This is what would have been begun with.
  ASSERT_GT(std::abs(hasty->tracker->estimate().state.v_odom.norm() - window.speed), 1.0);
  EXPECT_FALSE(hasty->acceptance.accepted());
  EXPECT_NE(hasty->acceptance.reason.find("settled"), std::string::npos) << hasty->acceptance.reason;
}

TEST(ColdStart, AFastCarIsFoundAndItsTiltIsAsDoubtfulAsItSays) {
  const Window window = first_seconds(2.3);
  const auto start = find_start(OdometryConfig{}, window.rig, window.scans, window.imu);
  ASSERT_TRUE(start);
  ASSERT_TRUE(start->acceptance.accepted()) << start->acceptance.reason;
  EXPECT_FALSE(start->at_rest);
  const imu::Estimate& found = start->tracker->estimate();
  EXPECT_EQ(found.state.time, window.end);
  EXPECT_NEAR(found.state.v_odom.norm(), window.speed, 0.1);
  // Straight on, tilt and the accelerometer's bias look alike.
  const double inseparable = window.rig.accel_turn_on_bias / imu::kGravity;
  EXPECT_NEAR(imu::tilt_deviation(found), inseparable, 0.1 * inseparable);
}

TEST(ColdStart, ScansOfNothingBeforeItHaveAPoseAndNoClaim) {
  const double dark = 3.0;
  const Drive drive = SimulatedDrive("dev_start_in_motion", {"sensor.columns=180", "duration=9"},
                                     {{degrade::EventKind::kBlackout, 0.0, dark}})
                          .run();
  ASSERT_EQ(static_cast<int>(drive.scans.size()), drive.num_scans_given);
  ASSERT_EQ(drive.maps.size(), 1U);
  for (const DrivenScan& scan : drive.scans) {
    EXPECT_TRUE(scan.T_odom_imu.R.allFinite() && scan.T_odom_imu.t.allFinite()) << scan.seconds;
    EXPECT_EQ(is_placed(scan.state), scan.seconds > dark + 0.01) << scan.seconds;
    if (scan.seconds < dark - 0.01) {
      // As seen from the window that was started with, or from outside of it.
      EXPECT_TRUE(scan.cause == Cause::kNoPoints || scan.cause == Cause::kNoStart) << scan.seconds;
    }
  }
  // At 7 m/s, carried back by the IMU from a velocity that was found to a few centimetres per second.
  const math::SE3 way = drive.scans.front().T_odom_imu.inverse() * drive.scans.back().T_odom_imu;
  const math::SE3 true_way = drive.scans.front().T_world_imu.inverse() * drive.scans.back().T_world_imu;
  EXPECT_LT((way.t - true_way.t).norm(), 1.0);
  EXPECT_GT(true_way.t.norm(), 30.0);
}

TEST(ColdStart, ARecordingThatSeesNothingHasAPoseForEachScanWhereverItEnds) {
  constexpr int kLongest = 50;
  auto config = sim::load_scenario("dev_start_in_motion", {"sensor.columns=8", "duration=6"});
  ASSERT_TRUE(config.ok()) << config.error().message;
  sim::Simulation simulation(*config);
  std::vector<sensor::Item> items;
  while (std::count_if(items.begin(), items.end(), holds_scan) < kLongest) items.push_back(*simulation.next());
  for (int num_scans = 1; num_scans <= kLongest; ++num_scans) {
    LidarInertialOdometry odometry(OdometryConfig{}, simulation.rig());
    std::vector<ScanResult> results;
    int num_given = 0;
    for (const sensor::Item& item : items) {
      if (num_given == num_scans) break;
      if (const auto* scan = std::get_if<sensor::LidarScan>(&item)) {
        auto empty = std::make_shared<sensor::LidarScan>();
        empty->start_time = scan->start_time;
        empty->end_time = scan->end_time;
        for (ScanResult& result : odometry.add_scan(empty).results) results.push_back(std::move(result));
        ++num_given;
      } else {
        ASSERT_EQ(odometry.add_imu(std::get<sensor::ImuSample>(item)), sensor::ImuAdmission::kAccepted);
      }
    }
    for (ScanResult& result : odometry.finish()) results.push_back(std::move(result));
    ASSERT_EQ(static_cast<int>(results.size()), num_scans);
    ASSERT_EQ(odometry.maps().size(), 1U);
    EXPECT_EQ(odometry.maps()[0].why_ended, Cause::kNoStart);
    for (const ScanResult& result : results) {
      EXPECT_EQ(result.state, TrackingState::kLost);
      EXPECT_TRUE(result.estimate.state.p_odom.allFinite());
    }
  }
}

TEST(ColdStart, ARecordingTooShortToStartIsGivenPosesAndCalledLost) {
  const Drive drive =
      SimulatedDrive("dev_start_in_motion", {"sensor.columns=180", "duration=1"}, {}).run_to_the_end();
  ASSERT_EQ(static_cast<int>(drive.scans.size()), drive.num_scans_given);
  ASSERT_EQ(drive.maps.size(), 1U);
  EXPECT_EQ(drive.maps[0].why_ended, Cause::kNoStart);
  for (const DrivenScan& scan : drive.scans) {
    EXPECT_EQ(scan.state, TrackingState::kLost);
    EXPECT_EQ(scan.cause, Cause::kNoStart);
  }
}

}  // namespace
}  // namespace mmlins::odometry

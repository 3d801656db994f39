// SPDX-License-Identifier: MIT
#pragma once
// The whole odometry on a small simulation in memory, with the truth beside every scan.

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mmlins/odometry/lidar_inertial_odometry.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins::odometry {

/// What is left of a scan once the odometry has said what it makes of it.
struct DrivenScan {
  double seconds = 0.0;  ///< its end, after the start of the recording
  TrackingState state = TrackingState::kInitializing;
  Cause cause = Cause::kNone;
  int map_id = 0;
  math::SE3 T_odom_imu;
  math::SE3 T_world_imu;       ///< the truth
  double speed_error = 0.0;    ///< of the velocity in the frame of the IMU [m/s]
  double covered_share = 0.0;  ///< of its points: those that an event put there
};

struct Drive {
  std::vector<DrivenScan> scans;
  std::vector<MapRecord> maps;
  std::vector<degrade::EventSpec> events;
  Time start;
  int num_scans_given = 0;
};

/// Makes of a reading of the IMU what reaches the odometry, if anything; time is from the start of the
/// recording [s].
using ImuEdit =
    std::function<std::optional<sensor::ImuSample>(double seconds, const sensor::ImuSample& sample)>;

inline std::optional<sensor::ImuSample> unchanged(double /*seconds*/, const sensor::ImuSample& sample) {
  return sample;
}

class SimulatedDrive {
 public:
  /// @param events  in place of the scenario's own
  SimulatedDrive(const std::string& scenario, std::vector<std::string> overrides,
                 std::vector<degrade::EventSpec> events)
      : simulation_(config_of(scenario, std::move(overrides), std::move(events))),
        odometry_(OdometryConfig{}, simulation_.rig()) {}

  /// With the scans that wait for a start that never comes.
  Drive run_to_the_end() {
    Drive drive = run();
    drive_ = {{}, {}, drive.events, drive.start, drive.num_scans_given};
    for (const ScanResult& result : odometry_.finish()) record(result);
    drive.scans.insert(drive.scans.end(), drive_.scans.begin(), drive_.scans.end());
    drive.maps = odometry_.maps();
    return drive;
  }

  Drive run(const ImuEdit& edit = unchanged) {
    drive_.events = simulation_.config().events;
    drive_.start = simulation_.start_time();
    for (auto item = simulation_.next(); item.ok() && !std::holds_alternative<sensor::EndOfData>(*item);
         item = simulation_.next()) {
      if (auto* scan = std::get_if<sensor::LidarScan>(&*item)) {
        waiting_.push_back({std::make_shared<const sensor::LidarScan>(std::move(*scan)), covered_share()});
      } else {
        const auto& sample = std::get<sensor::ImuSample>(*item);
        newest_imu_ = sample.time;
        const auto edited = edit(seconds(sample.time), sample);
        if (edited) {
          EXPECT_EQ(odometry_.add_imu(*edited), sensor::ImuAdmission::kAccepted);
        }
      }
      give_scans();
    }
    drive_.maps = odometry_.maps();
    return std::move(drive_);
  }

 private:
  struct Waiting {
    ScanPointer scan;
    double covered_share;
  };

  static sim::SimulationConfig config_of(const std::string& scenario, std::vector<std::string> overrides,
                                         std::vector<degrade::EventSpec> events) {
    overrides.push_back("events=[]");
    auto config = sim::load_scenario(scenario, overrides);
    EXPECT_TRUE(config.ok()) << config.error().message;
    config->events = std::move(events);
    EXPECT_TRUE(sim::validate(*config, scenario).ok());
    return *config;
  }

  [[nodiscard]] double seconds(Time time) const { return to_seconds(time - simulation_.start_time()); }

  [[nodiscard]] double covered_share() const {
    const auto& surfaces = simulation_.scan_truth().surfaces;
    if (surfaces.empty()) return 0.0;
    return static_cast<double>(std::count(surfaces.begin(), surfaces.end(), -1)) /
           static_cast<double>(surfaces.size());
  }

  /// Scans that the IMU has passed.
  void give_scans() {
    while (!waiting_.empty() && waiting_.front().scan->end_time <= newest_imu_) {
      ++drive_.num_scans_given;
      covered_.push_back(waiting_.front().covered_share);
      for (const ScanResult& result : odometry_.add_scan(waiting_.front().scan).results) record(result);
      waiting_.erase(waiting_.begin());
    }
  }

  void record(const ScanResult& result) {
    DrivenScan scan;
    const imu::NavState& state = result.estimate.state;
    scan.seconds = seconds(result.time);
    scan.state = result.state;
    scan.cause = result.cause;
    scan.map_id = result.map_id;
    scan.T_odom_imu = state.T_odom_imu();
    scan.T_world_imu = simulation_.T_world_imu(result.time);
    const math::Vector3d v_world = simulation_.velocity_world(result.time);
    scan.speed_error =
        (state.R_odom_imu.transpose() * state.v_odom - scan.T_world_imu.R.transpose() * v_world).norm();
    scan.covered_share = covered_[drive_.scans.size()];
    drive_.scans.push_back(scan);
  }

  sim::Simulation simulation_;
  LidarInertialOdometry odometry_;
  std::vector<Waiting> waiting_;
  std::vector<double> covered_;
  Time newest_imu_;
  Drive drive_;
};

}  // namespace mmlins::odometry

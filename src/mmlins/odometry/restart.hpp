// SPDX-License-Identifier: MIT
#pragma once
// A new map on trial: started in motion with what the IMU carried through the gap, and believed only after it has
// proved itself for a while. docs/math/degeneracy.md, section 4.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/initialization/acceptance.hpp"
#include "mmlins/odometry/map_record.hpp"
#include "mmlins/odometry/startup.hpp"

namespace mmlins::odometry {

/// Place and heading of one pose with the roll and pitch of another: continues a trajectory without tilting its frame.
[[nodiscard]] math::SE3 with_heading_of(const math::SE3& T_odom_heading, const math::SE3& T_odom_level);

class Restart {
 public:
  enum class Prior {
    kCarried,  ///< velocity, gravity and biases as the IMU carried them through the gap
    kNone,     ///< as at the start of a recording: the IMU was silent, or what it carried cannot be right
  };
  /// @param carried     where the IMU is taken to be; its pose begins the new map
  /// @param T_odom_map  of the map before, whose coordinates the new one continues
  Restart(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& carried, const math::SE3& T_odom_map,
          Prior prior);

  enum class Progress {
    kOnTrial,
    kProven,  ///< and still following the scans, until it is taken or fails
    kFailed,
  };
  /// @param is_collapsed  whether the scan is as small as under a cover
  [[nodiscard]] Progress add(const std::shared_ptr<const sensor::LidarScan>& scan, const sensor::ImuBuffer& imu,
                             bool is_collapsed);

  /// Why the trial failed, or has not been passed yet; when it has, with which figures.
  [[nodiscard]] const std::string& verdict() const { return verdict_; }
  [[nodiscard]] const imu::Estimate& begin() const { return begin_; }
  /// Whether what was found rests on what was carried, and says so with its covariance.
  [[nodiscard]] bool has_used_prior() const {
    return prior_ == Prior::kCarried && config_.initialization.mode != initialization::InitializationMode::kPaper;
  }
  [[nodiscard]] MapBeginning beginning() const { return beginning_; }
  [[nodiscard]] const ScanTracker& tracker() const { return *tracker_; }
  [[nodiscard]] std::unique_ptr<ScanTracker> take() { return std::move(tracker_); }
  [[nodiscard]] Time needs_imu_since() const { return begin_.state.time; }

 private:
  using Scan = std::shared_ptr<const sensor::LidarScan>;
  [[nodiscard]] Progress follow(const Scan& scan, const sensor::ImuBuffer& imu);
  [[nodiscard]] Progress add_with_prior(const Scan& scan, const sensor::ImuBuffer& imu, bool is_collapsed);
  [[nodiscard]] Progress add_without_prior(const Scan& scan, const sensor::ImuBuffer& imu, bool is_collapsed);
  [[nodiscard]] initialization::Window window(const sensor::ImuBuffer& imu) const;
  /// Velocity, gravity and biases from the window; on success the tracker goes on with them.
  [[nodiscard]] bool initialize(const sensor::ImuBuffer& imu);
  [[nodiscard]] bool initialize_as_in_the_paper(const sensor::ImuBuffer& imu);
  /// Goes over the scans again, straightened with the motion that has been found. False if they no longer match.
  [[nodiscard]] bool go_over_again(const initialization::MapSolution& solution, const sensor::ImuBuffer& imu);
  void take(const ScanResult& result);
  /// Whether the new map explains the latest scans well enough to be a map of anything.
  [[nodiscard]] bool explains_enough(bool is_collapsed);
  /// Whether the scans themselves saw the robot move by a good deal.
  [[nodiscard]] bool has_seen_motion() const;

  OdometryConfig config_;
  sensor::Rig rig_;
  imu::ImuNoise noise_;
  imu::Estimate begin_;
  math::SE3 T_odom_map_;
  Prior prior_;
  std::unique_ptr<ScanTracker> tracker_;
  std::vector<Scan> scans_;
  initialization::PoseMeasurements poses_;
  std::vector<double> explained_;  ///< share of each scan that the map before it explains
  std::string verdict_;
  MapBeginning beginning_ = MapBeginning::kAfterGap;
  bool proven_ = false;
  std::optional<Time> next_attempt_;  ///< to start with nothing known beforehand
};

}  // namespace mmlins::odometry

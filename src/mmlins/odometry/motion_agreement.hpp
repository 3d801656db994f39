// SPDX-License-Identifier: MIT
#pragma once
// Compares the motion of the last second as the filter has it, which follows the LiDAR, with what the IMU alone
// makes of it. A bag that moves along, or a lift, fools the LiDAR; its motion is then metres from the IMU's.
// docs/math/degeneracy.md, section 3.

#include <deque>
#include <optional>

#include "mmlins/imu/propagation.hpp"
#include "mmlins/odometry/trust.hpp"
#include "mmlins/sensor/imu_buffer.hpp"

namespace mmlins::odometry {

struct Disagreement {
  double position = 0.0;          ///< [m]
  double rotation = 0.0;          ///< [rad]
  bool beyond_doubt = false;      ///< more than the limits and the IMU's own doubt explain
  imu::Estimate imu_alone;        ///< present estimate from the beginning of the window on; only beyond the limits
};

class MotionAgreement {
 public:
  /// @param max_gap  an IMU that was silent for longer is no witness
  MotionAgreement(const TrustConfig& config, const imu::ImuNoise& noise, Duration max_gap)
      : config_(config), noise_(noise), max_gap_(max_gap) {}

  /// Nothing until estimates reach back over a whole window, and while the IMU has a gap in it.
  [[nodiscard]] std::optional<Disagreement> compare(const imu::Estimate& now, const sensor::ImuBuffer& imu) const;
  void add(const imu::Estimate& trusted);
  /// The thread is broken: the window begins anew, once the velocity has had the time of one window to settle.
  void clear();
  /// The IMU must be kept from here on; nothing if it need not.
  [[nodiscard]] std::optional<Time> needs_imu_since() const;

 private:
  TrustConfig config_;
  imu::ImuNoise noise_;
  Duration max_gap_;
  std::optional<Time> settled_at_;  // before that, estimates are no witnesses
  std::deque<imu::Estimate> past_;  // the first is at least a window old, once there is such a one
};

}  // namespace mmlins::odometry

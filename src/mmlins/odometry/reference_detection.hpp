// SPDX-License-Identifier: MIT
#pragma once
// Over-degeneracy as others detect it, for comparison: the rule of the MM-LINS paper, that of its published code,
// and the degeneracy factor. The first two judge the covariance of a filter like FAST-LIO2's, which is therefore
// kept beside our own. docs/math/degeneracy.md, section 5.

#include <optional>

#include "mmlins/degeneracy/reference_detectors.hpp"
#include "mmlins/imu/propagation.hpp"
#include "mmlins/odometry/odometry_config.hpp"

namespace mmlins::odometry {

class ReferenceDetection {
 public:
  explicit ReferenceDetection(DetectorKind kind) : kind_(kind) {}

  /// One scan further. True where the rule would put the map to sleep.
  /// @param before      state before the scan
  /// @param samples     IMU from there to the end of the scan
  /// @param unweighted  sum of J^T J over the matches; zero without an update
  [[nodiscard]] bool step(const imu::NavState& before, const sensor::ImuSamples& samples, const math::Matrix6d& unweighted);
  /// A new map begins.
  void restart();

 private:
  DetectorKind kind_;
  std::optional<imu::ErrorMatrix> P_;
  int count_ = 0;  // of scans, as the rules count them
};

}  // namespace mmlins::odometry

// SPDX-License-Identifier: MIT
#pragma once
// Back into the map after the IMU alone has carried the pose for a while: where to begin matching when the
// prediction may be off by more than a match can bridge, and whether only one place fits.
// docs/math/degeneracy.md, section 3.

#include <optional>
#include <vector>

#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/lidar/deskew.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"

namespace mmlins::odometry {

/// Displacements of the predicted position [m, odom], the prediction itself (none) first: a grid over two
/// standard deviations of its horizontal position, doubled as no model of an IMU is exact. None if that is wider than a
/// search can cover: what it did not try might fit as well.
[[nodiscard]] std::vector<Eigen::Vector3d> places_to_try(const Eigen::Matrix3d& P_position);

/// Who returns from afar may take so many times the iterations: half of the way would be believed as firmly as the whole.
inline constexpr int kPatienceFromAfar = 4;

/// Where one attempt ended.
struct Attempt {
  imu::NavState state;
  double explained = 0.0;  ///< share of the points that match there
};

struct Return {
  imu::NavState start;                 ///< from where to match
  std::vector<math::Vector3d> rivals;  ///< positions elsewhere that explain nearly as much [m, odom]
  bool covered = true;                 ///< false: the doubt was too wide to be searched, and nothing was
};

/// The place to return to: where the attempt from the prediction itself ended (the first), unless another
/// explains clearly more. Nothing if nothing matched anywhere.
[[nodiscard]] std::optional<Return> choose(const std::vector<Attempt>& attempts);

/// Matches some of the keypoints from all of these places.
[[nodiscard]] std::optional<Return> search_return(const lidar::Cloud& keypoints, const imu::Estimate& prior,
                                                  const PlacedMap& map, const MatchingConfig& config,
                                                  const BeamNoise& noise);

/// Whether one of `rivals` lies elsewhere in a direction that the scan determines: along a corridor every place fits.
[[nodiscard]] bool fits_elsewhere(const math::Vector3d& place, const std::vector<math::Vector3d>& rivals,
                                  const degeneracy::Observability& observability);

}  // namespace mmlins::odometry

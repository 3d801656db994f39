// SPDX-License-Identifier: MIT
#pragma once
// A local map made of keyframes where they lie once places were recognised, laid under the robot without
// moving it: what moves is the map. docs/math/mapping.md, "Back to the odometry".

#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mmlins/odometry/odometry_config.hpp"
#include "mmlins/sensor/rig.hpp"
#include "mmlins/spatial/local_map.hpp"

namespace mmlins::odometry {

/// The empty local map that the configuration names.
[[nodiscard]] std::unique_ptr<spatial::LocalMap> make_local_map(const LocalMapConfig& config,
                                                                double range_noise);

/// Points and from where they were seen, in the frame of the active map.
struct PlacedPoints {
  std::shared_ptr<const std::vector<Eigen::Vector3f>> points_imu;
  math::SE3 T_map_imu;
};

/// A local map and where its cells lie in the frame of the active map. The two differ once a map was laid
/// under the robot.
struct LocalMapInPlace {
  std::unique_ptr<spatial::LocalMap> map;
  math::SE3 T_map_cells;

  void insert(std::span<const Eigen::Vector3f> points_imu, const math::SE3& T_map_imu);
  /// Forgets what lies farther than `radius` [m] from there.
  void evict_beyond(const math::SE3& T_map_imu, double radius) {
    map->evict_beyond(T_map_cells.inverse() * T_map_imu.t, radius);
  }
};

struct RebuiltMap {
  LocalMapInPlace local;
  /// Keyframes that were seen since, oldest first: still to be added.
  std::deque<PlacedPoints> to_come;
};

/// Makes a map of known surroundings, lays it where the latest of the recent keyframes see it, and adds
/// those.
/// @param known   keyframes of other times, where the back end has them
/// @param recent  those that the robot comes from, as the odometry had them, oldest first
/// @return nothing if the recent keyframes do not show the known surroundings, or elsewhere than they are
/// said to be
[[nodiscard]] std::optional<RebuiltMap> rebuild_map(std::span<const PlacedPoints> known,
                                                    std::span<const PlacedPoints> recent,
                                                    const OdometryConfig& config, const sensor::Rig& rig);

/// What a scan shows, thinned, once it is placed.
struct PlacedView {
  const std::vector<Eigen::Vector3f>& points_imu;
  math::SE3 T_map_imu;
  imu::ErrorMatrix P;  ///< of the filter
};

/// Lays the map where the view shows it.
/// @return false if it does not, or farther off than config.rebuilt allows; then nothing has changed
[[nodiscard]] bool align(LocalMapInPlace& local, const std::vector<Eigen::Vector3f>& points_imu,
                         const math::SE3& T_map_imu, const OdometryConfig& config, const sensor::Rig& rig);

/// A rebuilt map on trial.
class MapOffer {
 public:
  explicit MapOffer(RebuiltMap rebuilt) : rebuilt_(std::move(rebuilt)) {}

  /// What grows the map in use grows this one as well.
  void insert(std::span<const Eigen::Vector3f> points_imu, const math::SE3& T_map_imu) {
    rebuilt_.local.insert(points_imu, T_map_imu);
  }

  enum class Answer { kNotYet, kTaken, kRefused };
  /// To be asked with each scan that was believed: once all is in, the map is laid where the scan shows it
  /// and takes the place of `current` if it explains the scan as well.
  [[nodiscard]] Answer consider(LocalMapInPlace& current, const PlacedView& view,
                                const OdometryConfig& config, const sensor::Rig& rig);

 private:
  RebuiltMap rebuilt_;
  int num_refusals_ = 0;
};

}  // namespace mmlins::odometry

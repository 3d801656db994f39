// SPDX-License-Identifier: MIT
#pragma once
// What the odometry needs of a map: put points in, ask for the surface near a point, forget what is far.

#include <Eigen/Core>
#include <cstdint>
#include <span>

namespace mmlins::spatial {

/// Id of a plane that was fitted for one query alone.
inline constexpr std::uint32_t kUnsharedPlane = 0xFFFFFFFF;

/// The plane that the map offers for one point.
struct PlaneMatch {
  bool found = false;
  std::uint32_t plane_id = kUnsharedPlane;  ///< same number: same plane, unless it is kUnsharedPlane
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, in the frame of the map
  double distance = 0.0;           ///< signed distance of the point from the plane [m]
  double surface_variance = 0.0;   ///< how far a single point of this surface strays from the plane [m^2]
  double plane_variance = 0.0;     ///< uncertainty of the plane itself at the point [m^2]
  Eigen::Vector3d widest = Eigen::Vector3d::UnitX();  ///< unit, along which the points of the plane spread most
  double tilt_variance_widest = 0.0;  ///< uncertainty of the normal towards `widest` [rad^2]
  double tilt_variance_middle = 0.0;  ///< and towards the direction at right angles to both [rad^2]
};

class LocalMap {
 public:
  virtual ~LocalMap() = default;
  /// Adds points given in the frame of the map, seen from `viewpoint`.
  virtual void insert(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& viewpoint) = 0;
  /// The plane that suits the point best, no farther than `gate` [m]. Safe to call from many threads.
  [[nodiscard]] virtual PlaneMatch match(const Eigen::Vector3d& point, double gate) const = 0;
  /// Forgets what lies farther than `radius` [m] from `centre`: not at once on every call, but soon.
  virtual void evict_beyond(const Eigen::Vector3d& centre, double radius) = 0;
  /// Number of cells held; a measure of memory.
  [[nodiscard]] virtual std::size_t num_cells() const = 0;
};

}  // namespace mmlins::spatial

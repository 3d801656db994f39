// SPDX-License-Identifier: MIT
#pragma once
// Collects the shapes of a scene. Loose objects are put only where they leave the carrier's path free.

#include <cstdint>
#include <vector>

#include "mmlins/sim/course.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/shape.hpp"

namespace mmlins::sim {

/// A box standing on (or hanging at) z_min.
struct BoxSpec {
  Eigen::Vector2d center;  ///< [m]
  Eigen::Vector2d size;    ///< along its own x and y [m]
  double z_min = 0.0;      ///< [m]
  double z_max = 1.0;      ///< [m]
  double yaw = 0.0;        ///< [rad]
};

class SceneBuilder {
 public:
  /// @param clearance  free space on both sides of the path [m]
  SceneBuilder(std::uint64_t seed, Polygon keep_free, double clearance);

  [[nodiscard]] Random& random() { return random_; }
  /// Whether a disc leaves the path free.
  [[nodiscard]] bool is_free(const Eigen::Vector2d& center, double radius) const;
  /// Distance of a place from the path [m].
  [[nodiscard]] double distance_to_path(const Eigen::Vector2d& place) const;

  /// Always placed.
  void add(const BoxSpec& box);
  /// Placed if the path stays free.
  void add_loose(const BoxSpec& box);
  void add_pole(const Eigen::Vector2d& foot, double radius, double height);
  /// A trunk with a crown, if the path stays free.
  void add_tree(const Eigen::Vector2d& foot);
  /// A straight wall from a to b, as a box.
  void add_wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double thickness,
                const Eigen::Vector2d& z_range);

  [[nodiscard]] std::vector<Shape> take() { return std::move(shapes_); }

 private:
  double reflectivity() { return random_.uniform(0.12, 0.85); }

  Random random_;
  Polygon keep_free_;
  double clearance_;
  std::vector<Shape> shapes_;
};

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// People and cars that go to and fro on straight lanes.

#include <cstdint>
#include <optional>
#include <vector>

#include "mmlins/sim/shape.hpp"

namespace mmlins::sim {

enum class MoverKind { kPerson, kCar };

/// Length along its way, width and height [m]: what all the shapes of a mover fit into.
[[nodiscard]] Eigen::Vector3d size_of(MoverKind kind);

/// A straight lane over the ground, divided into cells.
struct Lane {
  Eigen::Vector2d from = Eigen::Vector2d::Zero();    ///< the middle of the first cell [m]
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();  ///< unit vector
  double cell = 0.1;                                 ///< from middle to middle [m]
  std::vector<double> heights;                       ///< of the ground at each cell [m]
};

/// The clock of all movers: between two ticks each goes on evenly.
inline constexpr double kMoverTick = 0.1;  // [s]

/// An instant between two ticks.
struct MoverInstant {
  std::size_t tick = 0;
  double share = 0.0;  ///< of the time to the next tick
};
[[nodiscard]] MoverInstant mover_instant(double seconds);

/// A body of shapes that keeps its direction.
class Mover {
 public:
  /// @param cells  where it is at each tick; -1: nowhere
  Mover(MoverKind kind, Lane lane, std::vector<std::int16_t> cells);

  [[nodiscard]] MoverKind kind() const { return kind_; }
  [[nodiscard]] const Lane& lane() const { return lane_; }
  /// Where it stands on the ground; nothing while it is nowhere.
  [[nodiscard]] std::optional<Eigen::Vector3d> place(const MoverInstant& now) const;
  /// The shapes about the place.
  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }
  /// How far a point is from the body, as seen from above [m].
  [[nodiscard]] double distance_from_body(const Eigen::Vector2d& p, const Eigen::Vector3d& place) const;
  /// Whether a ray passes near enough to be worth a closer look.
  [[nodiscard]] bool may_meet(const Ray& ray, const Eigen::Vector3d& place, double max_range) const {
    const Eigen::Vector3d to_middle = place + Eigen::Vector3d(0.0, 0.0, 0.5 * height_) - ray.origin;
    const double ahead = to_middle.dot(ray.direction);
    if (ahead < -radius_ || ahead > max_range + radius_) return false;
    return to_middle.squaredNorm() - ahead * ahead < radius_ * radius_;
  }

 private:
  MoverKind kind_;
  Lane lane_;
  std::vector<std::int16_t> cells_;
  std::vector<Shape> shapes_;
  double height_;  // [m]
  double radius_;  // of a ball around the body [m]
};

}  // namespace mmlins::sim

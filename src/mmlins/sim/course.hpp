// SPDX-License-Identifier: MIT
#pragma once
// A closed course through the plane: a uniform quintic B-spline whose control points lie on a polygon.
// It is four times continuously differentiable, follows the straights exactly, rounds the corners, and
// travels slower where the control points are denser.

#include <Eigen/Core>
#include <vector>

#include "mmlins/sim/jet.hpp"

namespace mmlins::sim {

using Polygon = std::vector<Eigen::Vector2d>;  ///< corners in order [m]; the last is joined to the first

/// A polygon on ground that may rise and fall.
struct Route {
  Polygon corners;
  std::vector<double> heights;  ///< of the ground at each corner [m]; empty: 0 everywhere
};

/// Where a path is, and the direction it goes, as functions of time.
struct PathPoint {
  Jet x, y;     ///< [m]
  Jet heading;  ///< direction of travel, counted from x towards y [rad]
  Jet z{};      ///< of the ground [m]
};

struct CourseSpeed {
  double cruise = 1.0;        ///< on the straights [m/s]
  double corner_ratio = 0.6;  ///< speed at a right angle, as a share of the cruise
  double smoothing = 1.0;     ///< time between control points: the higher, the wider the corners [s]
};

class Course {
 public:
  /// @param route  at least three corners
  Course(const Route& route, const CourseSpeed& speed);

  /// `travelled` is the time spent on the course since its first corner [s]; it may exceed one lap.
  [[nodiscard]] PathPoint at(const Jet& travelled) const;
  /// Time for one lap [s].
  [[nodiscard]] double lap_time() const { return spacing_ * static_cast<double>(control_.size()); }

 private:
  double spacing_ = 1.0;  ///< time between control points [s]
  Polygon control_;
  std::vector<double> control_heights_;  // empty: 0 everywhere [m]
};

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/sim/course.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/base/check.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

// Row i: coefficients of the i-th basis function of the uniform quintic B-spline, constant term first.
constexpr double kBasis[6][6] = {{1, -5, 10, -10, 5, -1},  {26, -50, 20, 20, -20, 5},
                                 {66, 0, -60, 0, 30, -10}, {26, 50, 20, -20, -20, 10},
                                 {1, 5, 10, 10, 5, -5},    {0, 0, 0, 0, 0, 1}};
constexpr double kBasisScale = 1.0 / 120.0;

constexpr double kWalkStep = 0.02;    // of the walk along the polygon [m]
constexpr double kBrakingTime = 2.5;  // a corner is felt this long before and after it [s]

struct Leg {
  Vector2d from, to;
  double turn_at_start, turn_at_end;  // [rad], unsigned
  double z_from = 0.0, z_to = 0.0;    // [m]
};

double turn_between(const Vector2d& a, const Vector2d& b) {
  return std::abs(std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b)));
}

std::vector<Leg> legs_of(const Route& route) {
  const Polygon& corners = route.corners;
  const std::size_t n = corners.size();
  const auto edge = [&](std::size_t i) -> Vector2d { return corners[(i + 1) % n] - corners[i % n]; };
  std::vector<Leg> legs;
  for (std::size_t i = 0; i < n; ++i) {
    legs.push_back({corners[i], corners[(i + 1) % n], turn_between(edge(i + n - 1), edge(i)),
                    turn_between(edge(i), edge(i + 1))});
    if (route.heights.empty()) continue;
    legs.back().z_from = route.heights[i];
    legs.back().z_to = route.heights[(i + 1) % n];
  }
  return legs;
}

// Share of the cruise speed at `distance` before or after a corner.
double slow_down(double turn, double distance, const CourseSpeed& speed) {
  const double reach = kBrakingTime * speed.cruise;
  const double s = std::clamp(distance / reach, 0.0, 1.0);
  const double depth = (1.0 - speed.corner_ratio) * std::min(1.0, turn / (0.5 * std::numbers::pi));
  return 1.0 - depth * (1.0 - s * s * (3.0 - 2.0 * s));
}

struct Walk {
  std::vector<Vector2d> points;
  std::vector<double> heights;  // [m]
  std::vector<double> times;    // [s], from 0 at the first corner to the lap time
};

Walk walk_along(const Route& route, const CourseSpeed& speed) {
  Walk walk;
  double time = 0.0;
  const std::vector<Leg> legs = legs_of(route);
  for (const Leg& leg : legs) {
    const double length = (leg.to - leg.from).norm();
    const int steps = std::max(1, static_cast<int>(std::ceil(length / kWalkStep)));
    for (int i = 0; i < steps; ++i) {
      const double along = length * i / steps;
      walk.points.push_back(leg.from + (leg.to - leg.from) * (along / length));
      walk.heights.push_back(leg.z_from + (leg.z_to - leg.z_from) * (along / length));
      walk.times.push_back(time);
      const double share = std::min(slow_down(leg.turn_at_start, along, speed),
                                    slow_down(leg.turn_at_end, length - along, speed));
      time += length / steps / (speed.cruise * share);
    }
  }
  walk.points.push_back(legs.front().from);
  walk.heights.push_back(legs.front().z_from);
  walk.times.push_back(time);
  return walk;
}

// Horner's rule for a polynomial with coefficients c[0..5] / 120, constant term first.
Jet polynomial(const double (&c)[6], const Jet& u) {
  Jet sum{c[5]};
  for (int k = 4; k >= 0; --k) sum = sum * u + c[k];
  return kBasisScale * sum;
}

}  // namespace

Course::Course(const Route& route, const CourseSpeed& speed) {
  MMLINS_CHECK(route.heights.empty() || route.heights.size() == route.corners.size());
  MMLINS_CHECK(route.corners.size() >= 3 && speed.cruise > 0.0 && speed.smoothing > 0.0 &&
               speed.corner_ratio > 0.0);
  const Walk walk = walk_along(route, speed);
  const double lap = walk.times.back();
  const int count = std::max(6, static_cast<int>(std::lround(lap / speed.smoothing)));
  spacing_ = lap / count;
  for (int i = 0; i < count; ++i) {
    const auto next = std::upper_bound(walk.times.begin(), walk.times.end(), i * spacing_);
    const auto k = static_cast<std::size_t>(next - walk.times.begin());
    const double s = (i * spacing_ - walk.times[k - 1]) / (walk.times[k] - walk.times[k - 1]);
    control_.push_back(walk.points[k - 1] + s * (walk.points[k] - walk.points[k - 1]));
    if (route.heights.empty()) continue;
    control_heights_.push_back(walk.heights[k - 1] + s * (walk.heights[k] - walk.heights[k - 1]));
  }
}

PathPoint Course::at(const Jet& travelled) const {
  const auto n = static_cast<long>(control_.size());
  const Jet phase = (1.0 / spacing_) * travelled;
  const double whole = std::floor(phase.value);
  const Jet u = phase + (-whole);
  const long first = (static_cast<long>(whole) % n + n) % n;

  PathPoint point;
  Jet dx, dy;  // derivatives with respect to u: they give a direction even while standing still
  for (long i = 0; i < 6; ++i) {
    const double(&c)[6] = kBasis[i];
    const double derivative[6] = {c[1], 2 * c[2], 3 * c[3], 4 * c[4], 5 * c[5], 0.0};
    const Jet weight = polynomial(c, u);
    const Jet slope = polynomial(derivative, u);
    // The basis spreads over six control points; -2 centres it on the one that `first` names.
    const auto k = static_cast<std::size_t>((first + i - 2 + n) % n);
    const Vector2d& p = control_[k];
    point.x = point.x + p.x() * weight;
    point.y = point.y + p.y() * weight;
    dx = dx + p.x() * slope;
    dy = dy + p.y() * slope;
    if (!control_heights_.empty()) point.z = point.z + control_heights_[k] * weight;
  }
  point.heading = atan2(dy, dx);
  return point;
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
// Three storeys, one above the other, joined by stairs: places that differ in height alone.
#include <cmath>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 0.5;  // [m]
constexpr int kStoreys = 3;
constexpr double kStorey = 3.2;    // from floor to floor [m]
constexpr double kSlab = 0.25;     // its thickness [m]
constexpr double kHalfY = 5.0;     // of the building, which begins at x = 0 [m]
constexpr double kStairsX = 22.0;  // where flights begin
constexpr double kStairsEnd = 28.4;
constexpr double kLength = 32.0;
constexpr double kStairsY = 3.85;     // middle of a flight
constexpr double kHalfStairs = 0.75;  // half its width
constexpr int kSteps = 20;

// Flights lie on alternating sides, so that none begins under the end of another.
double side_of(int flight) { return flight % 2 == 0 ? -1.0 : 1.0; }

// The floor at z; `open` is the side on which a flight comes up through it, or 0.
void add_slab(SceneBuilder& builder, double z, double open) {
  const auto plate = [&](double x0, double x1, double y0, double y1) {
    builder.add({{0.5 * (x0 + x1), 0.5 * (y0 + y1)}, {x1 - x0, y1 - y0}, z - kSlab, z});
  };
  plate(0.0, kStairsX, -kHalfY, kHalfY);
  plate(kStairsEnd, kLength, -kHalfY, kHalfY);
  if (open == 0.0) return plate(kStairsX, kStairsEnd, -kHalfY, kHalfY);
  const double near = kStairsY - kHalfStairs, far = kStairsY + kHalfStairs;
  plate(kStairsX, kStairsEnd, open < 0.0 ? -near : -kHalfY, open < 0.0 ? kHalfY : near);
  plate(kStairsX, kStairsEnd, open < 0.0 ? -kHalfY : far, open < 0.0 ? -far : kHalfY);
}

void add_flight(SceneBuilder& builder, int flight) {
  const double run = (kStairsEnd - kStairsX) / kSteps;
  const double rise = kStorey / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double top = flight * kStorey + (i + 1) * rise;
    builder.add({{kStairsX + (i + 0.5) * run, side_of(flight) * kStairsY},
                 {run, 2.0 * kHalfStairs},
                 top - 0.35,
                 top});
  }
}

void furnish(SceneBuilder& builder, double z, double clutter) {
  Random& random = builder.random();
  for (const double x : {random.uniform(6.5, 7.5), random.uniform(14.5, 15.5)}) {  // partitions
    for (const double sign : {-1.0, 1.0})
      builder.add_wall({x, sign * 1.15}, {x, sign * kHalfY}, 0.14, {z - 0.1, z + kStorey - kSlab});
  }
  for (int i = 0; i < static_cast<int>(std::lround(26 * clutter)); ++i) {
    const double x = random.uniform(0.6, 31.0);
    const double y = random.uniform(-4.6, 4.6);
    builder.add_loose({{x, y},
                       {random.uniform(0.4, 1.6), random.uniform(0.3, 0.8)},
                       z - 0.1,
                       z + random.uniform(0.45, 2.1),
                       random.chance(0.6) ? 0.0 : random.uniform(-1.5, 1.5)});
  }
}

// Round a storey from the stairs' landing and back to it.
void walk_storey(Route& route, double z, double enter_side, double leave_side) {
  const auto add = [&](double x, double y) {
    route.corners.emplace_back(x, y);
    route.heights.push_back(z);
  };
  add(30.4, enter_side * 2.0);
  add(29.5, 0.4);
  add(13.6, 0.4);
  add(12.8, 3.0);
  add(9.6, 3.0);
  add(8.8, 0.4);
  add(2.5, 0.4);
  add(2.5, -0.4);
  add(20.0, -0.4);
  if (leave_side != 0.0) add(kStairsX - 1.0, leave_side * kStairsY);
}

void climb(Route& route, int flight) {
  const double y = side_of(flight) * kStairsY;
  route.corners.emplace_back(kStairsX - 0.1, y);
  route.heights.push_back(flight * kStorey);
  route.corners.emplace_back(kStairsEnd + 0.1, y);
  route.heights.push_back((flight + 1) * kStorey);
  route.corners.emplace_back(30.4, y);
  route.heights.push_back((flight + 1) * kStorey);
}

void descend(Route& route, int flight) {
  const double y = side_of(flight) * kStairsY;
  route.corners.emplace_back(30.4, y);
  route.heights.push_back((flight + 1) * kStorey);
  route.corners.emplace_back(kStairsEnd + 0.1, y);
  route.heights.push_back((flight + 1) * kStorey);
  route.corners.emplace_back(kStairsX - 0.1, y);
  route.heights.push_back(flight * kStorey);
  route.corners.emplace_back(kStairsX - 1.0, 0.5 * y);
  route.heights.push_back(flight * kStorey);
}

}  // namespace

Route floors_route(const WorldConfig&) {
  Route route;
  for (int storey = 0; storey < kStoreys; ++storey) {
    const bool is_last = storey + 1 == kStoreys;
    walk_storey(route, storey * kStorey, storey == 0 ? 1.0 : side_of(storey - 1),
                is_last ? 0.0 : side_of(storey));
    if (!is_last) climb(route, storey);
  }
  for (int flight = kStoreys - 2; flight >= 0; --flight) {
    // From the storey's middle to the head of the flight, past the other flight's foot.
    route.corners.emplace_back(29.5, 0.0);
    route.heights.push_back((flight + 1) * kStorey);
    descend(route, flight);
  }
  route.corners.emplace_back(26.0, 0.0);
  route.heights.push_back(0.0);
  return route;
}

std::vector<Shape> floors_shapes(const WorldConfig& config, const Polygon& keep_free) {
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 81), keep_free, kPathClearance);
  const Vector2d z_range(-0.5, kStoreys * kStorey);
  for (const double sign : {-1.0, 1.0})
    builder.add_wall({0.0, sign * (kHalfY + 0.15)}, {kLength, sign * (kHalfY + 0.15)}, 0.3, z_range);
  for (const double x : {-0.15, kLength + 0.15})
    builder.add_wall({x, -kHalfY - 0.3}, {x, kHalfY + 0.3}, 0.3, z_range);
  for (int storey = 0; storey < kStoreys; ++storey) {
    if (storey > 0) add_slab(builder, storey * kStorey, side_of(storey - 1));
    if (storey + 1 < kStoreys) add_flight(builder, storey);
    furnish(builder, storey * kStorey, config.clutter);
  }
  add_slab(builder, kStoreys * kStorey, 0.0);
  return builder.take();
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
// Two halls that are the same to the millimetre, joined by a corridor: a trap for place recognition.
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 0.8;  // [m]
constexpr double kBelowGround = -0.5;   // [m]
constexpr double kHalfX = 13.0;         // of a hall [m]
constexpr double kHalfY = 9.0;
constexpr double kHeight = 4.8;
constexpr double kHalfDoor = 1.4;
constexpr double kDoorHeight = 2.6;
constexpr double kCorridor = 22.0;                         // its length [m]
constexpr double kApart = 2.0 * kHalfX + kCorridor + 0.6;  // from the one hall's middle to the other's [m]

// A wall across the x axis with a doorway in its middle.
void add_end_wall(SceneBuilder& builder, double x) {
  const Vector2d full(kBelowGround, kHeight + 0.3);
  builder.add_wall({x, -kHalfY}, {x, -kHalfDoor}, 0.3, full);
  builder.add_wall({x, kHalfDoor}, {x, kHalfY}, 0.3, full);
  builder.add_wall({x, -kHalfDoor}, {x, kHalfDoor}, 0.3, {kDoorHeight, full.y()});
}

void add_hall(SceneBuilder& builder, double clutter) {
  Random& random = builder.random();
  for (const double sign : {-1.0, 1.0}) {
    add_end_wall(builder, sign * (kHalfX + 0.15));
    builder.add_wall({-kHalfX, sign * (kHalfY + 0.15)}, {kHalfX, sign * (kHalfY + 0.15)}, 0.3,
                     {kBelowGround, kHeight + 0.3});
  }
  builder.add({{0, 0}, {2 * kHalfX + 0.6, 2 * kHalfY + 0.6}, kHeight, kHeight + 0.3});
  for (double x = -10.0; x < kHalfX; x += random.uniform(4.0, 6.0))
    builder.add({{x, 0.0}, {0.3, 2 * kHalfY}, kHeight - random.uniform(0.3, 0.6), kHeight + 0.1});
  for (int i = 0; i < static_cast<int>(std::lround(40 * clutter)); ++i) {
    const Vector2d place(random.uniform(-0.95, 0.95) * kHalfX, random.uniform(-0.95, 0.95) * kHalfY);
    const Vector2d size(random.uniform(0.4, 2.6), random.uniform(0.4, 1.4));
    const double top = random.chance(0.2) ? kHeight + 0.1 : random.uniform(0.5, 2.6);
    const double yaw = random.chance(0.5) ? 0.0 : random.uniform(-1.5, 1.5);
    builder.add_loose({place, size, kBelowGround, top, yaw});
  }
}

// Between the halls; in the frame of the first.
void add_corridor(SceneBuilder& builder) {
  const double from = kHalfX + 0.3, to = kApart - kHalfX - 0.3;
  for (const double sign : {-1.0, 1.0}) {
    builder.add_wall({from, sign * (kHalfDoor + 0.1)}, {to, sign * (kHalfDoor + 0.1)}, 0.2,
                     {kBelowGround, kDoorHeight + 0.2});
  }
  builder.add({{0.5 * (from + to), 0.0}, {to - from, 2 * kHalfDoor + 0.4}, kDoorHeight, kDoorHeight + 0.2});
  // The doors to the outside, which are closed.
  for (const double x : {-kHalfX - 0.2, kApart + kHalfX + 0.2})
    builder.add_wall({x, -kHalfDoor}, {x, kHalfDoor}, 0.1, {kBelowGround, kDoorHeight});
}

}  // namespace

Route decoy_route(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 70));
  const double x = random.uniform(7.5, 9.0), y = random.uniform(4.5, 6.0), lane = 0.45;
  const Vector2d other(kApart, 0.0);
  // Both rounds are the same seen from their hall: in by the door, round, and out by the door.
  return {{{x, -lane - 0.5},
           {x - 1.0, -y},
           {-x, -y},
           {-x, y},
           {x - 1.0, y},
           {x, lane + 0.5},
           {kHalfX, lane},
           other + Vector2d(-kHalfX, lane),
           other + Vector2d(-x, lane + 0.5),
           other + Vector2d(1.0 - x, y),
           other + Vector2d(x, y),
           other + Vector2d(x, -y),
           other + Vector2d(1.0 - x, -y),
           other + Vector2d(-x, -lane - 0.5),
           other + Vector2d(-kHalfX, -lane),
           {kHalfX, -lane}},
          {}};
}

std::vector<Shape> decoy_shapes(const WorldConfig& config, const Polygon& keep_free) {
  // What stands in the one hall stands in the other: it must be out of the way in both.
  Polygon both = keep_free;
  for (const Vector2d& place : keep_free) both.emplace_back(place.x() - kApart, place.y());
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 71), both, kPathClearance);
  add_hall(builder, config.clutter);
  std::vector<Shape> shapes = builder.take();
  const std::vector<Shape> hall = shapes;
  for (Shape shape : hall) {
    shape.center.x() += kApart;
    shapes.push_back(shape);
  }
  SceneBuilder between(sub_seed(static_cast<std::uint64_t>(config.seed), 72), keep_free, kPathClearance);
  add_corridor(between);
  for (const Shape& shape : between.take()) shapes.push_back(shape);
  return shapes;
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 2.2;  // [m]
constexpr double kBelowGround = -0.8;   // [m]
constexpr double kHalfX = 85.0;         // of the grounds [m]
constexpr double kHalfY = 65.0;
constexpr double kSpacing = 26.0;  // between the middles of buildings [m]

Vector2d anywhere(Random& random) {
  const double x = random.uniform(-1.0, 1.0) * kHalfX;
  return {x, random.uniform(-1.0, 1.0) * kHalfY};
}

// Windows, entrances, bays and stairs: boxes that stand out of the four fronts.
void add_fronts(SceneBuilder& builder, const BoxSpec& building) {
  Random& random = builder.random();
  const Vector2d along(std::cos(building.yaw), std::sin(building.yaw));
  const Vector2d across(-along.y(), along.x());
  for (int side = 0; side < 4; ++side) {
    const bool is_long = side < 2;
    const double length = is_long ? building.size.x() : building.size.y();
    const double reach = 0.5 * (is_long ? building.size.y() : building.size.x());
    const Vector2d out = (side % 2 == 0 ? 1.0 : -1.0) * (is_long ? across : along);
    const Vector2d run = is_long ? along : across;
    for (double s = -0.5 * length + random.uniform(0.5, 2.0); s < 0.5 * length - 1.0;
         s += random.uniform(2.0, 5.0)) {
      const double depth = random.uniform(0.1, 0.7);
      const double bottom = random.chance(0.5) ? kBelowGround : random.uniform(1.5, 5.0);
      builder.add_loose({building.center + s * run + (reach + 0.5 * depth - 0.02) * out,
                         {random.uniform(0.4, 2.0), depth},
                         bottom,
                         std::max(bottom, 0.0) + random.uniform(0.8, 4.0),
                         std::atan2(run.y(), run.x())});
    }
  }
}

void add_building(SceneBuilder& builder, const Vector2d& middle) {
  Random& random = builder.random();
  const double yaw = random.uniform(-0.25, 0.25);
  const BoxSpec main{middle,
                     {random.uniform(12.0, 21.0), random.uniform(9.0, 15.0)},
                     kBelowGround,
                     random.uniform(5.0, 15.0),
                     yaw};
  const Vector2d along(std::cos(yaw), std::sin(yaw));
  builder.add_loose(main);
  builder.add_loose({middle + 0.35 * main.size.x() * along,
                     {0.3 * main.size.x(), main.size.y() + random.uniform(2.0, 6.0)},
                     kBelowGround,
                     random.uniform(3.0, 9.0),
                     yaw});
  if (builder.is_free(middle, 0.5 * main.size.norm())) add_fronts(builder, main);
}

void add_vegetation(SceneBuilder& builder, double clutter) {
  Random& random = builder.random();
  for (int i = 0; i < static_cast<int>(std::lround(110 * clutter)); ++i) builder.add_tree(anywhere(random));
  for (int i = 0; i < static_cast<int>(std::lround(90 * clutter)); ++i) {  // bushes
    builder.add_pole(anywhere(random), random.uniform(0.3, 0.9), random.uniform(0.4, 1.5));
  }
}

void add_street_furniture(SceneBuilder& builder, double clutter) {
  Random& random = builder.random();
  for (int i = 0; i < static_cast<int>(std::lround(45 * clutter)); ++i)
    builder.add_pole(anywhere(random), random.uniform(0.05, 0.12), random.uniform(3.0, 7.0));
  for (int i = 0; i < static_cast<int>(std::lround(35 * clutter)); ++i) {  // cars, benches, bicycle sheds
    const Vector2d place = anywhere(random);
    const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    if (random.chance(0.6)) {
      builder.add_loose({place, {random.uniform(3.8, 5.0), 1.8}, 0.2, 1.0, yaw});
      builder.add_loose({place, {2.4, 1.6}, 1.0, random.uniform(1.4, 1.8), yaw});
    } else {
      builder.add_loose(
          {place, {random.uniform(0.8, 3.0), 0.6}, kBelowGround, random.uniform(0.5, 2.2), yaw});
    }
  }
}

}  // namespace

Route campus_route(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 50));
  const auto near = [&](double x, double y) {
    return Vector2d(x + random.uniform(-4.0, 4.0), y + random.uniform(-4.0, 4.0));
  };
  // Two rounds that share the way in the middle.
  const Vector2d south = near(0, -36), north = near(0, 36);
  return {{south, near(52, -38), near(56, 34), north, south + Vector2d(-2.5, 0), near(-50, -36),
           near(-54, 35), north + Vector2d(-2.5, 0)},
          {}};
}

std::vector<Shape> campus_shapes(const WorldConfig& config, const Polygon& keep_free) {
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 51), keep_free, kPathClearance);
  Random& random = builder.random();
  for (double x = -kHalfX; x <= kHalfX; x += kSpacing) {
    for (double y = -kHalfY; y <= kHalfY; y += kSpacing) {
      if (random.chance(0.2)) continue;  // a lawn
      add_building(builder, {x + random.uniform(-4.0, 4.0), y + random.uniform(-4.0, 4.0)});
    }
  }
  add_vegetation(builder, config.clutter);
  add_street_furniture(builder, config.clutter);
  return builder.take();
}

}  // namespace mmlins::sim

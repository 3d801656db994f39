// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 1.2;  // [m]
constexpr double kBelowGround = -0.6;   // so that no wave of the ground uncovers a foot [m]
constexpr double kHalfX = 36.0;         // of the yard [m]
constexpr double kHalfY = 28.0;

// The boundary: panels of varying height, none quite in line with the next.
void add_boundary(SceneBuilder& builder) {
  Random& random = builder.random();
  const Polygon corners{
      {-kHalfX, -kHalfY}, {kHalfX, -kHalfY + 3.0}, {kHalfX - 4.0, kHalfY}, {-kHalfX + 2.0, kHalfY - 2.0}};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vector2d from = corners[i];
    const Vector2d to = corners[(i + 1) % corners.size()];
    const Vector2d along = (to - from).normalized();
    const Vector2d across(-along.y(), along.x());
    double at = 0.0;
    while (at < (to - from).norm()) {
      const double length = random.uniform(3.0, 9.0);
      const Vector2d shift = across * random.uniform(-0.4, 0.4);
      const double height = random.chance(0.15) ? 0.8 : random.uniform(2.0, 4.5);
      builder.add_wall(from + at * along + shift, from + (at + length) * along + shift, 0.25,
                       {kBelowGround, height});
      at += length;
    }
  }
}

Vector2d anywhere(Random& random) {
  const double x = random.uniform(-0.93, 0.93) * kHalfX;
  return {x, random.uniform(-0.9, 0.9) * kHalfY};
}

void add_sheds(SceneBuilder& builder, int count) {
  Random& random = builder.random();
  for (int i = 0; i < count; ++i) {
    const Vector2d place = anywhere(random);
    const Vector2d size(random.uniform(4.0, 12.0), random.uniform(2.4, 7.0));
    const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double height = random.uniform(2.4, 6.0);
    builder.add_loose({place, size, kBelowGround, height, yaw});
    builder.add_loose({place, size + Vector2d(0.6, 0.6), height - 0.2, height + 0.1, yaw});  // eaves
  }
}

void add_crates(SceneBuilder& builder, int count) {
  Random& random = builder.random();
  for (int i = 0; i < count; ++i) {
    const Vector2d place = anywhere(random);
    const double side = random.uniform(0.5, 2.2);
    const double yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double height = random.uniform(0.4, 1.8);
    builder.add_loose({place, {side, random.uniform(0.5, 2.2)}, kBelowGround, height, yaw});
    if (random.chance(0.4)) {
      builder.add_loose({place,
                         {0.6 * side, 0.5},
                         height,
                         height + random.uniform(0.3, 1.0),
                         yaw + random.uniform(-0.5, 0.5)});
    }
  }
}

}  // namespace

Route yard_route(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 40));
  Polygon route;
  const int count = 9;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + random.uniform(-0.25, 0.25)) / count;
    const double share = random.uniform(0.38, 0.78);
    route.emplace_back(share * kHalfX * std::cos(angle), share * kHalfY * std::sin(angle));
  }
  return {route, {}};
}

std::vector<Shape> yard_shapes(const WorldConfig& config, const Polygon& keep_free) {
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 41), keep_free, kPathClearance);
  Random& random = builder.random();
  add_boundary(builder);
  add_sheds(builder, static_cast<int>(std::lround(14 * config.clutter)));
  add_crates(builder, static_cast<int>(std::lround(70 * config.clutter)));
  for (int i = 0; i < static_cast<int>(std::lround(30 * config.clutter)); ++i)
    builder.add_tree(anywhere(random));
  for (int i = 0; i < 12; ++i)
    builder.add_pole(anywhere(random), random.uniform(0.05, 0.12), random.uniform(4.0, 8.0));
  return builder.take();
}

}  // namespace mmlins::sim

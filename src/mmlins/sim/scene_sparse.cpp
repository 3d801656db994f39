// SPDX-License-Identifier: MIT
// Places that say little about where one is: tunnel, corridors, field.
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kBelowGround = -0.6;  // [m]

struct Tunnel {
  double half_length, half_width, height;  // [m]
};

Tunnel tunnel_of(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 60));
  const double length = random.uniform(240.0, 300.0);
  const double width = random.uniform(10.5, 12.0);
  return {0.5 * length, 0.5 * width, random.uniform(5.2, 6.0)};
}

// What a tunnel has: the same lamps at the same distances, a kerb, now and then a niche or a sign.
void fit_tunnel(SceneBuilder& builder, const Tunnel& tunnel, double clutter) {
  Random& random = builder.random();
  for (const double sign : {-1.0, 1.0}) {
    builder.add(
        {{0.0, sign * (tunnel.half_width - 0.4)}, {2.0 * tunnel.half_length, 0.8}, kBelowGround, 0.18});
    for (double x = 6.0 - tunnel.half_length; x < tunnel.half_length; x += 12.0)
      builder.add({{x, sign * 2.4}, {1.3, 0.25}, tunnel.height - 0.12, tunnel.height});
    for (double x = random.uniform(20.0, 60.0) - tunnel.half_length; x < tunnel.half_length;
         x += random.uniform(45.0, 75.0) / std::max(0.05, clutter)) {
      builder.add({{x, sign * (tunnel.half_width - 0.15)}, {0.9, 0.3}, 0.4, 2.0});
    }
  }
}

constexpr double kHalfCorridor = 1.4;  // half the width of a corridor [m]
constexpr double kCeiling = 2.7;       // [m]

Vector2d ring_of(const WorldConfig& config) {  // half the size of the ring of corridors, along its middle
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 62));
  const double length = random.uniform(88.0, 104.0);
  return {0.5 * length, 0.5 * random.uniform(26.0, 34.0)};
}

// The four walls of a rectangle.
void add_ring(SceneBuilder& builder, const Vector2d& half, double thickness, double top) {
  const Polygon corners{{-half.x(), -half.y()}, {half.x(), -half.y()}, half, {-half.x(), half.y()}};
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d along = (corners[(i + 1) % 4] - corners[i]).normalized() * 0.5 * thickness;
    builder.add_wall(corners[i] - along, corners[(i + 1) % 4] + along, thickness, {kBelowGround, top});
  }
}

// Door frames, cupboards and radiators, thinly spread along one straight wall.
void fit_wall(SceneBuilder& builder, const Vector2d& a, const Vector2d& b, double clutter) {
  Random& random = builder.random();
  const double length = (b - a).norm();
  const Vector2d along = (b - a) / length;
  const double yaw = std::atan2(along.y(), along.x());
  for (double s = random.uniform(3.0, 8.0); s < length - 2.0;
       s += random.uniform(5.0, 12.0) / std::max(0.05, clutter)) {
    if (random.chance(0.7)) {
      for (const double side : {-0.55, 0.55})
        builder.add({a + (s + side) * along, {0.1, 0.1}, kBelowGround, 2.1, yaw});
    } else {
      builder.add_loose(
          {a + s * along, {random.uniform(0.4, 1.2), 0.6}, kBelowGround, random.uniform(0.6, 1.9), yaw});
    }
  }
}

constexpr double kFieldHalf = 60.0;  // of the part where one walks [m]

}  // namespace

Route tunnel_route(const WorldConfig& config) {
  const Tunnel tunnel = tunnel_of(config);
  const double x = tunnel.half_length + 28.0, y = 0.28 * tunnel.half_width;
  return {{{-x, -y}, {x, -y}, {x + 14.0, 0.0}, {x, y}, {-x, y}, {-x - 14.0, 0.0}}, {}};
}

std::vector<Shape> tunnel_shapes(const WorldConfig& config, const Polygon& keep_free) {
  const Tunnel tunnel = tunnel_of(config);
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 61), keep_free, 1.6);
  Random& random = builder.random();
  const double length = 2.0 * tunnel.half_length, outside = 30.0;
  for (const double sign : {-1.0, 1.0}) {  // so thick that the hill is in the walls
    const double y = sign * (tunnel.half_width + 0.5 * outside);
    builder.add({{0.0, y}, {length, outside}, kBelowGround, tunnel.height + 4.0});
  }
  builder.add({{0.0, 0.0}, {length, 2.0 * tunnel.half_width + 1.0}, tunnel.height, tunnel.height + 4.0});
  fit_tunnel(builder, tunnel, config.clutter);
  for (int i = 0; i < static_cast<int>(std::lround(60 * config.clutter)); ++i) {
    const double sign = random.chance(0.5) ? 1.0 : -1.0;
    const Vector2d place(sign * (tunnel.half_length + random.uniform(2.0, 90.0)),
                         random.uniform(-45.0, 45.0));
    if (random.chance(0.6)) {
      builder.add_tree(place);
    } else {
      builder.add_loose({place,
                         {random.uniform(0.5, 4.0), 1.7},
                         kBelowGround,
                         random.uniform(0.6, 3.0),
                         random.uniform(-1.5, 1.5)});
    }
  }
  return builder.take();
}

Route corridor_route(const WorldConfig& config) {
  const Vector2d half = ring_of(config);
  return {{{-half.x(), -half.y()}, {half.x(), -half.y()}, half, {-half.x(), half.y()}}, {}};
}

std::vector<Shape> corridor_shapes(const WorldConfig& config, const Polygon& keep_free) {
  const Vector2d half = ring_of(config);
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 63), keep_free, 0.45);
  const Vector2d wide(kHalfCorridor + 0.1, kHalfCorridor + 0.1);
  add_ring(builder, half + wide, 0.2, kCeiling + 0.2);
  add_ring(builder, half - wide, 0.2, kCeiling + 0.2);
  builder.add({{0, 0}, 2.0 * half + 4.0 * wide, kCeiling, kCeiling + 0.3});
  for (const double side : {-1.0, 1.0}) {
    const Vector2d at = half + side * Vector2d(kHalfCorridor, kHalfCorridor);
    const Polygon corners{{-at.x(), -at.y()}, {at.x(), -at.y()}, at, {-at.x(), at.y()}};
    for (std::size_t i = 0; i < 4; ++i) fit_wall(builder, corners[i], corners[(i + 1) % 4], config.clutter);
  }
  return builder.take();
}

Route field_route(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 64));
  Route route;
  for (int i = 0; i < 7; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + random.uniform(-0.2, 0.2)) / 7;
    const double radius = kFieldHalf * random.uniform(0.6, 1.0);
    route.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return route;
}

std::vector<Shape> field_shapes(const WorldConfig& config, const Polygon& keep_free) {
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 65), keep_free, 2.0);
  Random& random = builder.random();
  for (int i = 0; i < static_cast<int>(std::lround(90 * config.clutter)); ++i) {  // the edge of a wood
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double radius = kFieldHalf + random.uniform(95.0, 125.0);
    builder.add_tree({radius * std::cos(angle), radius * std::sin(angle)});
  }
  for (int i = 0; i < static_cast<int>(std::lround(12 * config.clutter)); ++i) {  // tufts and stones
    const double x = random.uniform(-1.3, 1.3) * kFieldHalf;
    builder.add_pole({x, random.uniform(-1.3, 1.3) * kFieldHalf}, random.uniform(0.1, 0.4),
                     random.uniform(0.1, 0.5));
  }
  return builder.take();
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 0.9;  // [m]
constexpr double kBelowGround = -0.5;   // walls start there, so that no wave of the ground uncovers them [m]

struct Hall {
  Vector2d half_size;  // [m]
  double height;       // [m]
};

Hall hall_of(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 10));
  const double length = random.uniform(29.0, 33.0);
  const double width = random.uniform(19.5, 22.0);
  return {{0.5 * length, 0.5 * width}, random.uniform(4.7, 5.6)};
}

void add_shell(SceneBuilder& builder, const Hall& hall) {
  const double x = hall.half_size.x(), y = hall.half_size.y();
  const Vector2d z_range(kBelowGround, hall.height + 0.5);
  const Polygon corners{
      {-x - 0.15, -y - 0.15}, {x + 0.15, -y - 0.15}, {x + 0.15, y + 0.15}, {-x - 0.15, y + 0.15}};
  for (std::size_t i = 0; i < 4; ++i) builder.add_wall(corners[i], corners[(i + 1) % 4], 0.3, z_range);
  builder.add({{0, 0}, {2 * x + 1, 2 * y + 1}, hall.height, hall.height + 0.4, 0.0});
}

// A place near one of the walls, and the direction along that wall.
struct WallPlace {
  Vector2d place;
  double yaw;  // of the wall [rad]
};

WallPlace place_at_wall(Random& random, const Hall& hall, double distance) {
  const Vector2d inner = hall.half_size - Vector2d(distance, distance);
  const double sign = random.chance(0.5) ? 1.0 : -1.0;
  if (random.chance(0.6)) return {{random.uniform(-inner.x(), inner.x()), sign * inner.y()}, 0.0};
  return {{sign * inner.x(), random.uniform(-inner.y(), inner.y())}, 0.5 * std::numbers::pi};
}

// Doors, cupboards, pipes and ledges on the walls.
void add_wall_fittings(SceneBuilder& builder, const Hall& hall, int count) {
  Random& random = builder.random();
  for (int i = 0; i < count; ++i) {
    const double depth = random.uniform(0.08, 0.5);
    const WallPlace at = place_at_wall(random, hall, 0.5 * depth);
    const double bottom = random.chance(0.6) ? kBelowGround : random.uniform(0.8, 3.0);
    const double top = std::max(bottom, 0.0) + random.uniform(0.3, 2.4);
    builder.add_loose(
        {at.place, {random.uniform(0.4, 3.0), depth}, bottom, std::min(top, hall.height), at.yaw});
  }
}

void add_pillars(SceneBuilder& builder, const Hall& hall) {
  Random& random = builder.random();
  for (int i = 0; i < 10; ++i) {
    const WallPlace at = place_at_wall(random, hall, random.uniform(0.8, 2.8));
    if (random.chance(0.3)) {
      builder.add_pole(at.place, random.uniform(0.2, 0.35), hall.height + 0.2);
    } else {
      const double side = random.uniform(0.4, 0.7);
      builder.add_loose(
          {at.place, {side, side}, kBelowGround, hall.height + 0.2, random.uniform(-0.05, 0.05)});
    }
  }
}

void add_machines(SceneBuilder& builder, const Hall& hall, int count) {
  Random& random = builder.random();
  for (int i = 0; i < count; ++i) {
    const Vector2d place(random.uniform(-0.93, 0.93) * hall.half_size.x(),
                         random.uniform(-0.93, 0.93) * hall.half_size.y());
    const Vector2d size(random.uniform(0.6, 3.0), random.uniform(0.5, 1.6));
    const double yaw = random.chance(0.5) ? 0.0 : random.uniform(-1.5, 1.5);
    builder.add_loose({place, size, kBelowGround, random.uniform(0.6, 2.4), yaw});
  }
}

void add_beams(SceneBuilder& builder, const Hall& hall) {
  Random& random = builder.random();
  for (double x = -hall.half_size.x() + random.uniform(2.0, 4.0); x < hall.half_size.x();
       x += random.uniform(4.5, 6.5)) {
    builder.add({{x, 0.0},
                 {0.3, 2.0 * hall.half_size.y()},
                 hall.height - random.uniform(0.35, 0.6),
                 hall.height + 0.1,
                 0.0});
  }
  for (int i = 0; i < 4; ++i) {
    const double z = hall.height - random.uniform(0.7, 1.2);
    builder.add(
        {{random.uniform(-0.7, 0.7) * hall.half_size.x(), random.uniform(-0.7, 0.7) * hall.half_size.y()},
         {random.uniform(2.0, 6.0), random.uniform(0.2, 0.5)},
         z,
         z + 0.3,
         random.chance(0.5) ? 0.0 : 1.57});
  }
}

}  // namespace

Route hall_route(const WorldConfig& config) {
  const Vector2d half = hall_of(config).half_size;
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 11));
  const auto corner = [&](double x, double y) {
    return Vector2d(x * half.x() * random.uniform(0.5, 0.78), y * half.y() * random.uniform(0.5, 0.75));
  };
  return {{corner(-1, -1), corner(0.1, -0.8), corner(1, -1), corner(1, 1), corner(-0.1, 0.6), corner(-1, 1)},
          {}};
}

std::vector<Shape> hall_shapes(const WorldConfig& config, const Polygon& keep_free) {
  const Hall hall = hall_of(config);
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 12), keep_free, kPathClearance);
  add_shell(builder, hall);
  add_pillars(builder, hall);
  add_beams(builder, hall);
  add_wall_fittings(builder, hall, static_cast<int>(std::lround(18 * config.clutter)));
  add_machines(builder, hall, static_cast<int>(std::lround(26 * config.clutter)));
  return builder.take();
}

}  // namespace mmlins::sim

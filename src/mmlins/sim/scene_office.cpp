// SPDX-License-Identifier: MIT
#include <cmath>
#include <numbers>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 0.4;  // [m]
constexpr double kBelowGround = -0.3;   // [m]
constexpr double kWall = 0.14;          // thickness of inner walls [m]
constexpr double kDoorWidth = 1.15;     // [m]
constexpr double kDoorHeight = 2.05;    // [m]
constexpr double kHalfCorridor = 1.15;  // half its width [m]
constexpr int kRoomsPerSide = 6;

struct Room {
  double x_min, x_max;  // along the corridor [m]
  double door;          // x of the middle of its door [m]
  double depth;         // away from the corridor [m]
  bool visited;
};

struct Office {
  std::vector<Room> sides[2];  // towards +y and -y
  double length = 0.0;         // of the corridor, from x = 0 [m]
  double ceiling = 2.55;       // [m]
};

Office office_of(const WorldConfig& config) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 30));
  Office office;
  office.ceiling = random.uniform(2.5, 2.75);
  for (auto& side : office.sides) {
    double x = 0.0;
    for (int i = 0; i < kRoomsPerSide; ++i) {
      const double width = random.uniform(4.8, 6.6);
      const bool visited = (i + (&side == &office.sides[1] ? 1 : 0)) % 2 == 1;
      side.push_back(
          {x, x + width, x + width * random.uniform(0.42, 0.58), random.uniform(4.8, 6.2), visited});
      x += width;
    }
    office.length = std::max(office.length, x);
  }
  for (auto& side : office.sides) side.back().x_max = office.length;
  return office;
}

// Into the room, around its middle and out again.
void visit(Polygon& route, const Room& room, double sign, double travel) {
  const double door_y = kHalfCorridor + kWall;
  const double near = door_y + 1.3;
  const double far = door_y + room.depth - 1.3;
  const double reach = 1.1;
  const auto add = [&](double x, double y) { route.emplace_back(x, sign * y); };
  add(room.door, 0.35);
  add(room.door, near - 0.3);
  add(room.door - travel * reach, near + 0.4);
  add(room.door - travel * reach, far);
  add(room.door + travel * reach, far);
  add(room.door + travel * reach, near + 0.4);
  add(room.door + travel * 0.03, near - 0.3);
  add(room.door + travel * 0.03, 0.35);
}

void add_corridor_wall(SceneBuilder& builder, const Office& office, int side) {
  const double y = (side == 0 ? 1.0 : -1.0) * (kHalfCorridor + 0.5 * kWall);
  const Vector2d full(kBelowGround, office.ceiling + 0.1);
  double x = 0.0;
  for (const Room& room : office.sides[side]) {
    builder.add_wall({x, y}, {room.door - 0.5 * kDoorWidth, y}, kWall, full);
    builder.add_wall({room.door - 0.5 * kDoorWidth, y}, {room.door + 0.5 * kDoorWidth, y}, kWall,
                     {kDoorHeight, full.y()});
    x = room.door + 0.5 * kDoorWidth;
  }
  builder.add_wall({x, y}, {office.length, y}, kWall, full);
}

// A desk, a cupboard, a shelf or a chair, most of them at the walls.
void furnish(SceneBuilder& builder, const Room& room, double sign, const Office& office, double clutter) {
  Random& random = builder.random();
  const double y_near = kHalfCorridor + kWall;
  const double y_far = y_near + room.depth;
  const int count = static_cast<int>(std::lround(14 * clutter));
  for (int i = 0; i < count; ++i) {
    const double depth = random.uniform(0.3, 0.8);
    const double width = random.uniform(0.5, 2.0);
    const double height = random.chance(0.4) ? random.uniform(0.7, 0.8) : random.uniform(0.45, 2.1);
    const double inset = 0.5 * depth + 0.02;
    const double x = random.uniform(room.x_min + 0.6, room.x_max - 0.6);
    const double y = random.uniform(y_near + 0.6, y_far - 0.4);
    switch (static_cast<int>(random.uniform(0.0, 4.0))) {
      case 0:
        builder.add_loose({{x, sign * (y_far - inset)}, {width, depth}, kBelowGround, height, 0.0});
        break;
      case 1:
        builder.add_loose({{room.x_min + inset, sign * y}, {depth, width}, kBelowGround, height, 0.0});
        break;
      case 2:
        builder.add_loose(
            {{room.x_max - inset - kWall, sign * y}, {depth, width}, kBelowGround, height, 0.0});
        break;
      default:
        builder.add_loose(
            {{x, sign * y}, {0.8 * width, depth}, kBelowGround, 0.75, random.uniform(-1.5, 1.5)});
    }
  }
  for (int i = 0; i < 2; ++i) {  // lamps
    builder.add(
        {{random.uniform(room.x_min + 1, room.x_max - 1), sign * random.uniform(y_near + 1, y_far - 1)},
         {1.2, 0.3},
         office.ceiling - 0.08,
         office.ceiling,
         0.0});
  }
}

void add_rooms(SceneBuilder& builder, const Office& office, int side, double clutter) {
  const double sign = side == 0 ? 1.0 : -1.0;
  const Vector2d full(kBelowGround, office.ceiling + 0.1);
  const double y_near = sign * kHalfCorridor;
  for (const Room& room : office.sides[side]) {
    const double y_far = sign * (kHalfCorridor + kWall + room.depth);
    builder.add_wall({room.x_min, y_near}, {room.x_min, y_far}, kWall, full);
    builder.add_wall({room.x_max, y_near}, {room.x_max, y_far}, kWall, full);
    builder.add_wall({room.x_min, y_far}, {room.x_max, y_far}, 2 * kWall, full);
    furnish(builder, room, sign, office, clutter);
  }
}

// Cabinets, radiators, door frames and cable ducts along the corridor.
void fit_corridor(SceneBuilder& builder, const Office& office) {
  Random& random = builder.random();
  for (int i = 0; i < 24; ++i) {
    const double depth = random.uniform(0.05, 0.3);
    const double y = (random.chance(0.5) ? 1.0 : -1.0) * (kHalfCorridor - 0.5 * depth);
    const double bottom = random.chance(0.5) ? kBelowGround : random.uniform(0.5, 1.8);
    builder.add_loose({{random.uniform(0.3, office.length - 0.3), y},
                       {random.uniform(0.2, 1.0), depth},
                       bottom,
                       std::max(bottom, 0.0) + random.uniform(0.2, 1.2),
                       0.0});
  }
  for (double x = 1.5; x < office.length; x += random.uniform(2.4, 3.6)) {
    builder.add({{x, random.uniform(-0.3, 0.3)}, {0.3, 1.2}, office.ceiling - 0.1, office.ceiling, 0.0});
  }
}

}  // namespace

Route office_route(const WorldConfig& config) {
  const Office office = office_of(config);
  Polygon route{{0.9, 0.35}};
  for (const Room& room : office.sides[0]) {
    if (room.visited) visit(route, room, 1.0, 1.0);
  }
  route.emplace_back(office.length - 0.9, 0.35);
  route.emplace_back(office.length - 0.9, -0.35);
  for (auto room = office.sides[1].rbegin(); room != office.sides[1].rend(); ++room) {
    if (room->visited) visit(route, *room, -1.0, -1.0);
  }
  route.emplace_back(0.9, -0.35);
  return {route, {}};
}

std::vector<Shape> office_shapes(const WorldConfig& config, const Polygon& keep_free) {
  const Office office = office_of(config);
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 31), keep_free, kPathClearance);
  for (int side = 0; side < 2; ++side) {
    add_corridor_wall(builder, office, side);
    add_rooms(builder, office, side, config.clutter);
  }
  fit_corridor(builder, office);
  const Vector2d full(kBelowGround, office.ceiling + 0.1);
  builder.add_wall({-0.1, -8.0}, {-0.1, 8.0}, 0.2, full);
  builder.add_wall({office.length + 0.1, -8.0}, {office.length + 0.1, 8.0}, 0.2, full);
  builder.add(
      {{0.5 * office.length, 0.0}, {office.length + 1.0, 18.0}, office.ceiling, office.ceiling + 0.3, 0.0});
  return builder.take();
}

}  // namespace mmlins::sim

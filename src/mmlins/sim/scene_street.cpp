// SPDX-License-Identifier: MIT
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "mmlins/sim/scene_builder.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;

constexpr double kPathClearance = 1.5;  // [m]
constexpr double kBelowGround = -0.8;   // [m]
constexpr double kHalfStreet = 7.5;     // from the middle of a street to the facades [m]
constexpr double kSight = 70.0;         // facades farther from the path are left out [m]
constexpr int kBlocks = 4;              // per direction; the path runs around the inner 2 x 2
constexpr int kUrbanBlocks = 10;        // the same of the large city

/// Middles of the streets: lines of constant x and of constant y.
struct Streets {
  std::vector<double> x, y;  // [m]
};

Streets streets_of(const WorldConfig& config, int blocks) {
  Random random(sub_seed(static_cast<std::uint64_t>(config.seed), 20));
  Streets streets;
  double x = -random.uniform(150.0, 160.0);
  double y = -random.uniform(115.0, 125.0);
  for (int i = 0; i <= blocks; ++i) {
    streets.x.push_back(x);
    streets.y.push_back(y);
    x += random.uniform(62.0, 88.0);
    y += random.uniform(50.0, 68.0);
  }
  return streets;
}

// One side of a block: from `from` in the direction `along`, the street lies on the side of `out`.
struct BlockSide {
  Vector2d from;
  Vector2d along;
  Vector2d out;
  double length;  // [m]

  Vector2d at(double s, double outwards) const { return from + s * along + outwards * out; }
  double yaw() const { return std::atan2(along.y(), along.x()); }
};

// Pilasters and bays that stand out of the front, ledges between the floors, a recessed look.
void add_front(SceneBuilder& builder, const BlockSide& side, const Vector2d& span, double front,
               double height) {
  Random& random = builder.random();
  double s = span.x() + random.uniform(0.5, 2.0);
  while (s < span.y() - 0.5) {
    const double width = random.uniform(0.3, 1.6);
    const double depth = random.uniform(0.12, 0.6);
    const double bottom = random.chance(0.6) ? kBelowGround : random.uniform(2.2, 4.0);
    builder.add({side.at(s, front + 0.5 * depth - 0.02),
                 {width, depth},
                 bottom,
                 random.uniform(0.5, 1.0) * height,
                 side.yaw()});
    s += width + random.uniform(0.8, 3.5);
  }
  for (double z = random.uniform(3.0, 4.2); z < height; z += random.uniform(3.0, 4.5)) {
    const double depth = random.uniform(0.15, 0.4);
    builder.add({side.at(0.5 * (span.x() + span.y()), front + 0.5 * depth),
                 {span.y() - span.x(), depth},
                 z,
                 z + 0.25,
                 side.yaw()});
  }
}

void add_buildings(SceneBuilder& builder, const BlockSide& side) {
  Random& random = builder.random();
  double s = 0.0;
  while (s < side.length) {
    const double width = std::min(random.uniform(7.0, 17.0), side.length - s);
    const double setback = random.uniform(0.0, 1.6);
    const double height = random.uniform(5.0, 14.0);
    const double depth = random.uniform(7.0, 11.0);
    const bool is_alley = random.chance(0.1);
    if (!is_alley && builder.distance_to_path(side.at(s + 0.5 * width, 0.0)) < kSight) {
      builder.add({side.at(s + 0.5 * width, -setback - 0.5 * depth),
                   {width, depth},
                   kBelowGround,
                   height,
                   side.yaw()});
      add_front(builder, side, {s, s + width}, -setback, height);
    }
    s += is_alley ? 3.5 : width;
  }
}

void add_car(SceneBuilder& builder, const Vector2d& place, double yaw) {
  Random& random = builder.random();
  const double length = random.uniform(3.8, 5.0);
  const double width = random.uniform(1.65, 1.95);
  const double waist = random.uniform(0.85, 1.05);
  const Vector2d along(std::cos(yaw), std::sin(yaw));
  builder.add_loose({place, {length, width}, 0.2, waist, yaw});
  builder.add_loose(
      {place - 0.1 * length * along, {0.55 * length, 0.88 * width}, waist, random.uniform(1.4, 1.75), yaw});
}

// What stands between the facades and the lane.
void furnish(SceneBuilder& builder, const BlockSide& side, double clutter) {
  Random& random = builder.random();
  double s = 3.0;
  while (s < side.length - 3.0) {
    const double kind = random.uniform() / std::max(clutter, 0.01);
    const Vector2d kerb = side.at(s, random.uniform(1.6, 2.1));
    const bool in_sight = builder.distance_to_path(kerb) < kSight;
    if (kind < 0.45 && in_sight) {
      add_car(builder, side.at(s, random.uniform(3.2, 3.6)), side.yaw() + random.uniform(-0.05, 0.05));
    } else if (kind < 0.62 && in_sight) {
      builder.add_tree(kerb);
    } else if (kind < 0.75 && in_sight) {
      builder.add_pole(kerb, random.uniform(0.05, 0.11), random.uniform(3.0, 8.0));
    } else if (kind < 0.85 && in_sight) {
      builder.add_loose({kerb,
                         {random.uniform(0.4, 1.6), random.uniform(0.4, 0.8)},
                         kBelowGround,
                         random.uniform(0.6, 1.6),
                         side.yaw() + random.uniform(-0.2, 0.2)});
    }
    s += random.uniform(3.5, 7.5);
  }
}

void add_block(SceneBuilder& builder, const Vector2d& low, const Vector2d& high, double clutter) {
  const Vector2d size = high - low;
  const BlockSide sides[4] = {{low, {1, 0}, {0, -1}, size.x()},
                              {{high.x(), low.y()}, {0, 1}, {1, 0}, size.y()},
                              {high, {-1, 0}, {0, 1}, size.x()},
                              {{low.x(), high.y()}, {0, -1}, {-1, 0}, size.y()}};
  for (const BlockSide& side : sides) {
    add_buildings(builder, side);
    furnish(builder, side, clutter);
  }
}

std::vector<Shape> city_shapes(const WorldConfig& config, const Polygon& keep_free, int blocks) {
  const Streets streets = streets_of(config, blocks);
  SceneBuilder builder(sub_seed(static_cast<std::uint64_t>(config.seed), 21), keep_free, kPathClearance);
  const Vector2d half_street(kHalfStreet, kHalfStreet);
  for (std::size_t i = 0; i < static_cast<std::size_t>(blocks); ++i) {
    for (std::size_t j = 0; j < static_cast<std::size_t>(blocks); ++j) {
      const Vector2d low(streets.x[i], streets.y[j]);
      const Vector2d high(streets.x[i + 1], streets.y[j + 1]);
      add_block(builder, low + half_street, high - half_street, config.clutter);
    }
  }
  return builder.take();
}

}  // namespace

Route street_route(const WorldConfig& config) {
  const Streets streets = streets_of(config, kBlocks);
  const auto crossing = [&](std::size_t i, std::size_t j) { return Vector2d(streets.x[i], streets.y[j]); };
  // A figure of eight around two of the inner blocks, or a ring around all four of them.
  if (config.seed % 3 == 0) return {{crossing(1, 1), crossing(3, 1), crossing(3, 3), crossing(1, 3)}, {}};
  return {{crossing(1, 1), crossing(2, 1), crossing(2, 2), crossing(3, 2), crossing(3, 3), crossing(2, 3),
           crossing(2, 2), crossing(1, 2)},
          {}};
}

std::vector<Shape> street_shapes(const WorldConfig& config, const Polygon& keep_free) {
  return city_shapes(config, keep_free, kBlocks);
}

Route urban_route(const WorldConfig& config) {
  const Streets streets = streets_of(config, kUrbanBlocks);
  // As columns and rows of crossings: a long tour that drives several streets twice and crosses itself.
  constexpr std::array<std::pair<int, int>, 22> kTour{
      {{1, 1}, {4, 1}, {4, 3}, {2, 3}, {2, 5}, {4, 5}, {4, 3}, {7, 3}, {7, 1}, {9, 1}, {9, 4},
       {7, 4}, {7, 7}, {9, 7}, {9, 9}, {5, 9}, {5, 7}, {7, 7}, {7, 5}, {2, 5}, {2, 8}, {1, 8}}};
  Route route;
  for (const auto& [i, j] : kTour)
    route.corners.emplace_back(streets.x[static_cast<std::size_t>(i)],
                               streets.y[static_cast<std::size_t>(j)]);
  return route;
}

std::vector<Shape> urban_shapes(const WorldConfig& config, const Polygon& keep_free) {
  return city_shapes(config, keep_free, kUrbanBlocks);
}

}  // namespace mmlins::sim

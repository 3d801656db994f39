// SPDX-License-Identifier: MIT
#include "mmlins/sim/lane_finder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;
constexpr double kDeepest = 4.0;   // of the ground below the carrier [m]
constexpr double kLookDown = 1.2;  // height from which the ground of a cell is sought [m]
constexpr double kSlope = 0.15;    // of the ground along a lane
constexpr double kGap = 0.2;       // between the rays that feel for obstacles [m]
constexpr double kSideRoom = 0.1;  // beside a mover [m]
constexpr double kEndRoom = 0.25;  // before and behind it [m]
constexpr std::array<double, 4> kFeelers{0.2, 0.45, 0.75, 0.97};  // heights, as shares of the mover's

/// What a lane of each kind is like [m].
struct LaneKind {
  double nearest, farthest;  // its middle from the way of the carrier
  double shortest, half_length;
};
LaneKind lane_kind(MoverKind kind) {
  return kind == MoverKind::kPerson ? LaneKind{0.6, 6.0, 2.5, 8.0} : LaneKind{0.0, 6.0, 14.0, 75.0};
}

std::optional<double> ground_below(const World& still, const Vector2d& p, double z) {
  const auto hit = still.cast({{p.x(), p.y(), z}, {0.0, 0.0, -1.0}}, kDeepest);
  if (!hit || hit->normal.z() < 0.9) return std::nullopt;
  return z - hit->range;
}

/// How far a body of this width and height can go from `foot` in a direction [m].
double free_way(const World& still, const Vector3d& foot, const Vector2d& along, MoverKind kind) {
  const Vector3d size = size_of(kind);
  const Vector3d across(-along.y(), along.x(), 0.0);
  const double half_width = 0.5 * size.y() + kSideRoom;
  const int gaps = static_cast<int>(std::ceil(2.0 * half_width / kGap));
  double way = lane_kind(kind).half_length + 0.5 * size.x() + kEndRoom;
  for (int i = 0; i <= gaps; ++i) {
    const double aside = half_width * (2.0 * i / gaps - 1.0);
    for (const double share : kFeelers) {
      const Vector3d from = foot + aside * across + Vector3d(0.0, 0.0, share * size.z());
      if (const auto hit = still.cast({from, {along.x(), along.y(), 0.0}}, way)) way = hit->range;
    }
  }
  return way - 0.5 * size.x() - kEndRoom;
}

// A ray that starts inside of something does not see it: so from a free middle sideways first.
bool is_free_aside(const World& still, const Vector3d& foot, const Vector2d& along, MoverKind kind) {
  const Vector3d size = size_of(kind);
  for (const double sign : {-1.0, 1.0}) {
    for (const double share : kFeelers) {
      const Ray ray{foot + Vector3d(0.0, 0.0, share * size.z()), {-sign * along.y(), sign * along.x(), 0.0}};
      if (still.cast(ray, 0.5 * size.y() + kSideRoom)) return false;
    }
  }
  return true;
}

/// The heights of the ground from one cell to the next, as far as it is even.
std::vector<double> heights_along(const World& still, const Vector3d& foot, const Vector2d& step, int count) {
  std::vector<double> heights;
  double z = foot.z();
  for (int i = 1; i <= count; ++i) {
    const auto ground = ground_below(still, foot.head<2>() + i * step, z + kLookDown);
    if (!ground || std::abs(*ground - z) > kSlope * step.norm() + 0.02) break;
    z = *ground;
    heights.push_back(z);
  }
  return heights;
}

struct Site {
  Vector2d middle;
  Vector2d along;
};

Site random_site(MoverKind kind, const Vector2d& carrier, const Vector2d& heading, Random& random) {
  const LaneKind lane = lane_kind(kind);
  const Vector2d left(-heading.y(), heading.x());
  const double base = std::atan2(heading.y(), heading.x());
  const auto towards = [](double angle) { return Vector2d(std::cos(angle), std::sin(angle)); };
  if (kind == MoverKind::kPerson) {
    const double distance = random.uniform(lane.nearest, lane.farthest);
    const Vector2d middle = carrier + distance * towards(random.uniform(-kPi, kPi));
    const bool is_along = random.chance(0.4);
    return {middle, towards(is_along ? base + random.uniform(-0.1, 0.1) : random.uniform(-kPi, kPi))};
  }
  if (random.chance(0.5)) {  // beside the way of the carrier
    const double sign = random.chance(0.5) ? 1.0 : -1.0;
    return {carrier + sign * random.uniform(2.9, lane.farthest) * left, heading};
  }
  return {carrier + random.uniform(-4.0, 4.0) * heading,
          towards(base + 0.5 * kPi + random.uniform(-0.1, 0.1))};
}

}  // namespace

std::optional<Lane> find_lane(MoverKind kind, double cell, const LaneSite& site, Random& random) {
  const auto last = static_cast<double>(site.carrier.size()) - 6.0;
  const auto tick = static_cast<std::size_t>(std::max(0.0, random.uniform(0.0, last)));
  const Vector3d& carrier = site.carrier[tick];
  const Vector2d moved = (site.carrier[tick + 5] - carrier).head<2>();
  const Vector2d heading = moved.norm() > 1e-3 ? Vector2d(moved.normalized()) : Vector2d::UnitX();
  const Site at = random_site(kind, carrier.head<2>(), heading, random);
  const Vector3d to_middle(at.middle.x() - carrier.x(), at.middle.y() - carrier.y(), 0.0);
  if (to_middle.norm() > 1e-6 && site.still.cast({carrier, to_middle.normalized()}, to_middle.norm()))
    return std::nullopt;  // not in view
  const auto ground = ground_below(site.still, at.middle, carrier.z());
  if (!ground) return std::nullopt;
  const Vector3d foot(at.middle.x(), at.middle.y(), *ground);
  if (!is_free_aside(site.still, foot, at.along, kind)) return std::nullopt;

  std::array<std::vector<double>, 2> heights;  // behind the middle and ahead of it
  for (std::size_t side = 0; side < 2; ++side) {
    const Vector2d towards = side == 0 ? Vector2d(-at.along) : at.along;
    const double way = free_way(site.still, foot, towards, kind);
    if (way < 0.0) return std::nullopt;
    heights[side] = heights_along(site.still, foot, cell * towards, static_cast<int>(way / cell));
  }
  Lane lane{at.middle - static_cast<double>(heights[0].size()) * cell * at.along, at.along, cell, {}};
  lane.heights.assign(heights[0].rbegin(), heights[0].rend());
  lane.heights.push_back(*ground);
  lane.heights.insert(lane.heights.end(), heights[1].begin(), heights[1].end());
  if (cell * static_cast<double>(lane.heights.size() - 1) < lane_kind(kind).shortest) return std::nullopt;
  return lane;
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/degrade/effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "mmlins/math/random.hpp"

namespace mmlins::degrade {

namespace {

using math::Random;
using math::sub_seed;

enum RandomPart : std::uint64_t { kPacket, kPoint, kChoice, kSectorPart, kHoles, kFlutter };

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr double kTornShare = 0.25;         // of the directions that a torn membrane leaves open
constexpr double kMembraneNoise = 0.01;     // [m]
constexpr Duration kPacketTime{1'000'000};  // what a network packet of a LiDAR spans
constexpr double kNearestScatter = 1.0;     // smoke seems to begin here [m]
constexpr double kFarthestScatter = 8.0;    // [m]
constexpr double kScatterEchoShare = 0.5;   // of the shots that smoke swallows: seen as an echo of the smoke

Random random_of(const EffectContext& context, const EffectPoint& point) {
  return Random(sub_seed(sub_seed(context.sweep_seed, kPoint), point.index));
}

double range_of(const EffectPoint& point) { return point.position.cast<double>().norm(); }

EffectPoint at_range(EffectPoint point, double range) {
  point.position = (point.position.cast<double>() * (range / range_of(point))).cast<float>();
  return point;
}

/// Smooth random function of direction and time with mean 0, between -1 and 1.
double flutter(const Eigen::Vector3d& direction, double seconds, std::uint64_t seed, double hz) {
  constexpr int kWaves = 4;
  Random random(sub_seed(seed, kFlutter));
  double sum = 0.0;
  for (int i = 0; i < kWaves; ++i) {
    const Eigen::Vector3d wave = 2.5 * random.normal3();
    const double rate = kTwoPi * hz * random.uniform(0.4, 1.0);
    sum += std::sin(wave.dot(direction) + rate * seconds + kTwoPi * random.uniform());
  }
  return sum / kWaves;
}

bool in_a_hole(const Eigen::Vector3d& direction, double seconds, std::uint64_t seed) {
  // Holes wander slowly over the membrane. The sum of the waves is near to normal with deviation
  // sqrt(1/2/4), of which a quarter lies above 0.674 deviations.
  static_assert(kTornShare == 0.25);
  return flutter(direction, seconds, sub_seed(seed, kHoles), 0.2) > 0.674 * 0.354;
}

std::vector<EffectPoint> bag(const std::vector<EffectPoint>& points, const EffectContext& context) {
  std::vector<EffectPoint> left;
  for (const EffectPoint& point : points) {
    if (!point.has_echo) {
      left.push_back(point);
      continue;
    }
    const Eigen::Vector3d direction = point.position.cast<double>().normalized();
    const double seconds = to_seconds(point.since_begin);
    const bool open =
        context.event.kind == EventKind::kTornBag && in_a_hole(direction, seconds, context.event_seed);
    Random random = random_of(context, point);
    const double membrane =
        membrane_range(direction, seconds, context.event.effective_severity(), context.event_seed) +
        kMembraneNoise * random.normal();
    left.push_back(open || range_of(point) <= membrane ? point : at_range(point, membrane));
  }
  return left;
}

std::vector<EffectPoint> smoke(const std::vector<EffectPoint>& points, const EffectContext& context) {
  const double extinction = context.event.effective_severity();
  std::vector<EffectPoint> left;
  for (const EffectPoint& point : points) {
    if (!point.has_echo) {
      left.push_back(point);
      continue;
    }
    Random random = random_of(context, point);
    const double range = range_of(point);
    if (random.uniform() < std::exp(-2.0 * extinction * range)) {  // through the smoke and back
      left.push_back(point);
      continue;
    }
    if (!random.chance(kScatterEchoShare)) continue;
    const double depth = -std::log(1.0 - random.uniform()) / (2.0 * extinction);
    const double scatter = kNearestScatter + std::fmod(depth, kFarthestScatter - kNearestScatter);
    if (scatter < range) left.push_back(at_range(point, scatter));
  }
  return left;
}

/// Keeps what `keep` says; beams without an echo are no concern of it.
template <typename Keep>
std::vector<EffectPoint> filtered(const std::vector<EffectPoint>& points, const Keep& keep) {
  std::vector<EffectPoint> left;
  for (const EffectPoint& point : points) {
    if (!point.has_echo || keep(point)) left.push_back(point);
  }
  return left;
}

std::vector<EffectPoint> sector(const std::vector<EffectPoint>& points, const EffectContext& context) {
  const double middle = kTwoPi * Random(sub_seed(context.event_seed, kSectorPart)).uniform();
  const double half_width = std::numbers::pi * context.event.effective_severity();
  return filtered(points, [&](const EffectPoint& point) {
    const double azimuth = std::atan2(point.position.y(), point.position.x());
    return std::abs(std::remainder(azimuth - middle, kTwoPi)) > half_width;
  });
}

std::vector<EffectPoint> thin_to(const std::vector<EffectPoint>& points, const EffectContext& context) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> lots;
  for (const EffectPoint& point : points) {
    if (point.has_echo) lots.emplace_back(random_of(context, point).bits(), point.index);
  }
  // Where the event covers only a part of the sweep, it leaves that part of the number.
  const double share =
      static_cast<double>(lots.size()) / static_cast<double>(std::max<std::size_t>(1, context.sweep_size));
  const auto number = static_cast<std::size_t>(std::llround(share * context.event.effective_severity()));
  std::sort(lots.begin(), lots.end());
  lots.resize(std::min(number, lots.size()));
  std::set<std::uint32_t> drawn;
  for (const auto& lot : lots) drawn.insert(lot.second);
  return filtered(points, [&](const EffectPoint& point) { return drawn.count(point.index) > 0; });
}

std::vector<EffectPoint> voxel(const std::vector<EffectPoint>& points, const EffectContext& context) {
  std::set<std::array<int, 3>> taken;
  const double edge = context.event.effective_severity();
  return filtered(points, [&](const EffectPoint& point) {
    const Eigen::Vector3d cell = (point.position.cast<double>() / edge).array().floor();
    return taken.insert({static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())})
        .second;
  });
}

std::vector<EffectPoint> packet_loss(const std::vector<EffectPoint>& points, const EffectContext& context) {
  std::vector<EffectPoint> left;
  for (const EffectPoint& point : points) {
    const auto packet = static_cast<std::uint64_t>(point.since_begin / kPacketTime);
    Random random(sub_seed(sub_seed(context.event_seed, kPacket), packet));
    if (!random.chance(context.event.effective_severity())) left.push_back(point);
  }
  return left;
}

}  // namespace

double membrane_range(const Eigen::Vector3d& direction, double seconds, double distance, std::uint64_t seed) {
  constexpr double kDepth = 0.5;     // of the folds, as a share of the distance
  constexpr double kNearest = 0.15;  // [m]
  constexpr double kFarthest = 1.5;  // [m]
  constexpr double kFlutterHz = 1.5;
  return std::clamp(distance * (1.0 + kDepth * flutter(direction, seconds, seed, kFlutterHz)), kNearest,
                    kFarthest);
}

std::vector<EffectPoint> apply_effect(const std::vector<EffectPoint>& points, const EffectContext& context) {
  const double severity = context.event.effective_severity();
  switch (context.event.kind) {
    case EventKind::kBlackout:
    case EventKind::kKidnap:
      return {};
    case EventKind::kElevator:  // is in the world and the motion
      return points;
    case EventKind::kBag:
    case EventKind::kTornBag:
      return bag(points, context);
    case EventKind::kSector:
      return sector(points, context);
    case EventKind::kSmoke:
      return smoke(points, context);
    case EventKind::kThin:
      return filtered(points, [&](const EffectPoint& p) { return random_of(context, p).chance(severity); });
    case EventKind::kThinTo:
      return thin_to(points, context);
    case EventKind::kVoxel:
      return voxel(points, context);
    case EventKind::kRangeCap:
      return filtered(points, [&](const EffectPoint& point) { return range_of(point) <= severity; });
    case EventKind::kPacketLoss:
      return packet_loss(points, context);
  }
  return points;
}

}  // namespace mmlins::degrade

// SPDX-License-Identifier: MIT
#include "mmlins/sim/mover_planner.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/sim/lane_finder.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kAttempts = 60;           // at finding a lane, for each mover
constexpr double kTurnChance = 0.004;   // per tick
constexpr double kEnterChance = 0.05;   // per tick
constexpr double kLeastPresence = 0.3;  // share of the time
constexpr std::int16_t kNowhere = -1;

// How far from the carrier a mover may appear and disappear [m].
double far_from_carrier(MoverKind kind) { return kind == MoverKind::kPerson ? 35.0 : 70.0; }

/// Cells of a lane that are too near to the carrier at one tick, and where the carrier is from there.
struct Blocked {
  int first = 0, last = -1;  // none if last < first
  double ahead = 0.0;        // of the first cell [m]
  double aside = 0.0;        // [m]
};

Blocked blocked_at(const Lane& lane, MoverKind kind, const CarrierPlaces& carrier, std::size_t tick) {
  const Vector2d here = carrier[tick].head<2>();
  const Vector2d before = carrier[tick > 0 ? tick - 1 : tick].head<2>();
  const Vector2d after = carrier[std::min(tick + 1, carrier.size() - 1)].head<2>();
  const Vector2d across(-lane.along.y(), lane.along.x());
  // Between two ticks both may come nearer to each other, by at most half of what they move.
  const auto step_along = [&](const Vector2d& axis) {
    return std::max(std::abs((here - before).dot(axis)), std::abs((after - here).dot(axis)));
  };
  const Vector2d q = here - lane.from;
  Blocked blocked;
  blocked.ahead = q.dot(lane.along);
  blocked.aside = q.dot(across);
  const Vector3d size = size_of(kind);
  const double reach_aside = 0.5 * size.y() + clearance_of(kind) + 0.5 * step_along(across);
  if (std::abs(blocked.aside) >= reach_aside) return blocked;
  const double reach = 0.5 * size.x() + clearance_of(kind) + 0.5 * (step_along(lane.along) + lane.cell);
  blocked.first = static_cast<int>(std::floor((blocked.ahead - reach) / lane.cell));
  blocked.last = static_cast<int>(std::ceil((blocked.ahead + reach) / lane.cell));
  return blocked;
}

/// Where on its lane a mover may be at which tick so that it need never come near the carrier.
class Schedule {
 public:
  Schedule(const Lane& lane, MoverKind kind, const CarrierPlaces& carrier)
      : lane_(lane),
        far_(far_from_carrier(kind)),
        cells_(static_cast<int>(lane.heights.size())),
        ticks_(carrier.size()),
        safe_(static_cast<std::size_t>(cells_) * ticks_, 0) {
    for (std::size_t k = 0; k < ticks_; ++k) blocked_.push_back(blocked_at(lane, kind, carrier, k));
    for (std::size_t k = ticks_; k-- > 0;) {
      for (int c = 0; c < cells_; ++c) safe_[index(k, c)] = is_free(k, c) && can_go_on(k, c) ? 1 : 0;
    }
  }

  bool is_safe(std::size_t tick, int cell) const {
    return cell >= 0 && cell < cells_ && safe_[index(tick, cell)] != 0;
  }
  bool is_far(std::size_t tick, int cell) const {
    return std::hypot(cell * lane_.cell - blocked_[tick].ahead, blocked_[tick].aside) > far_;
  }
  std::size_t ticks() const { return ticks_; }
  int cells() const { return cells_; }

 private:
  std::size_t index(std::size_t tick, int cell) const {
    return tick * static_cast<std::size_t>(cells_) + static_cast<std::size_t>(cell);
  }
  bool is_free(std::size_t tick, int cell) const {
    return cell < blocked_[tick].first || cell > blocked_[tick].last;
  }
  bool can_go_on(std::size_t tick, int cell) const {
    if (tick + 1 == ticks_ || is_far(tick, cell)) return true;
    return is_safe(tick + 1, cell - 1) || is_safe(tick + 1, cell) || is_safe(tick + 1, cell + 1);
  }

  const Lane& lane_;
  double far_;
  int cells_;
  std::size_t ticks_;
  std::vector<Blocked> blocked_;
  std::vector<std::uint8_t> safe_;
};

/// To and fro; waits, turns or leaves where it must.
class Walker {
 public:
  Walker(const Schedule& schedule, Random& random) : schedule_(schedule), random_(random) {}

  std::vector<std::int16_t> walk() {
    direction_ = random_.chance(0.5) ? 1 : -1;
    std::vector<std::int16_t> cells{first_cell()};
    for (std::size_t k = 1; k < schedule_.ticks(); ++k) {
      cells.push_back(cells.back() == kNowhere ? entered(k) : next(k, cells.back()));
    }
    return cells;
  }

 private:
  std::int16_t first_cell() {
    for (int i = 0; i < 30; ++i) {
      const int cell = static_cast<int>(random_.uniform(0.0, schedule_.cells()));
      if (schedule_.is_safe(0, cell)) return static_cast<std::int16_t>(cell);
    }
    return kNowhere;
  }
  std::int16_t entered(std::size_t tick) {
    if (!random_.chance(kEnterChance)) return kNowhere;
    direction_ = random_.chance(0.5) ? 1 : -1;
    const int end = direction_ > 0 ? 0 : schedule_.cells() - 1;
    return static_cast<std::int16_t>(schedule_.is_safe(tick, end) && schedule_.is_far(tick, end) ? end
                                                                                                 : kNowhere);
  }
  std::int16_t next(std::size_t tick, int cell) {
    const int ahead = cell + direction_;
    if (ahead < 0 || ahead >= schedule_.cells() || random_.chance(kTurnChance)) direction_ = -direction_;
    for (const int step : {direction_, 0, -direction_}) {
      if (schedule_.is_safe(tick, cell + step)) return static_cast<std::int16_t>(cell + step);
    }
    return kNowhere;  // it is far away
  }

  const Schedule& schedule_;
  Random& random_;
  int direction_ = 1;
};

CarrierPlaces places_of(const Motion& motion, double duration) {
  const auto count = static_cast<std::size_t>(std::ceil(duration / kMoverTick)) + 2;
  CarrierPlaces places;
  for (std::size_t k = 0; k < count; ++k)
    places.push_back(motion.at(kMoverTick * static_cast<double>(k)).T_world_imu.t);
  return places;
}

MoverKind kind_of(SceneKind scene, Random& random) {
  switch (scene) {
    case SceneKind::kStreet:
    case SceneKind::kUrban:
    case SceneKind::kTunnel:
      return MoverKind::kCar;
    case SceneKind::kCampus:
      return random.chance(0.5) ? MoverKind::kCar : MoverKind::kPerson;
    default:
      return MoverKind::kPerson;
  }
}

double speed_of(const WorldConfig& config, MoverKind kind, Random& random) {
  if (config.mover_speed > 0.0) return config.mover_speed;
  return kind == MoverKind::kPerson ? random.uniform(0.7, 1.8) : random.uniform(5.0, 12.0);
}

std::optional<Mover> planned(const WorldConfig& config, const World& still, const CarrierPlaces& carrier,
                             Random& random) {
  const MoverKind kind = kind_of(config.scene, random);
  const double cell = kMoverTick * speed_of(config, kind, random);
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    auto lane = find_lane(kind, cell, {still, carrier}, random);
    if (!lane) continue;
    const Schedule schedule(*lane, kind, carrier);
    std::vector<std::int16_t> cells = Walker(schedule, random).walk();
    const auto absent = std::count(cells.begin(), cells.end(), kNowhere);
    if (static_cast<double>(absent) > (1.0 - kLeastPresence) * static_cast<double>(cells.size())) continue;
    return Mover(kind, std::move(*lane), std::move(cells));
  }
  return std::nullopt;
}

}  // namespace

double clearance_of(MoverKind kind) { return kind == MoverKind::kPerson ? 0.8 : 2.0; }

std::vector<Mover> plan_movers(const WorldConfig& config, const World& still, const Motion& motion,
                               double duration) {
  std::vector<Mover> movers;
  if (config.movers == 0) return movers;
  const CarrierPlaces carrier = places_of(motion, duration);
  const std::uint64_t seed = sub_seed(static_cast<std::uint64_t>(config.seed), 90);
  for (int i = 0; i < config.movers; ++i) {
    Random random(sub_seed(seed, static_cast<std::uint64_t>(i)));
    if (auto mover = planned(config, still, carrier, random)) movers.push_back(std::move(*mover));
  }
  if (movers.size() < static_cast<std::size_t>(config.movers))
    log::warning("world.movers: only {} of {} find room to move", movers.size(), config.movers);
  return movers;
}

}  // namespace mmlins::sim

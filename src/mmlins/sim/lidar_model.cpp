// SPDX-License-Identifier: MIT
#include "mmlins/sim/lidar_model.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/base/parallel.hpp"
#include "mmlins/sim/lidar_tables.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::sim {

namespace {

using math::Vector3d;

constexpr std::size_t kMostLasers = 128;
constexpr std::size_t kGrain = 512;  // beams per piece of parallel work
// A pose is computed afresh at least this often and carried on with velocity, acceleration and angular rate
// in between: what is left out, angular acceleration * t^2 / 2, stays below 1e-7 rad for 50 rad/s^2.
constexpr Duration kPoseInterval{60'000};
// A surface of this reflectivity, hit squarely, is always seen up to this share of the maximum range.
constexpr double kSureReflectivity = 0.1;
constexpr double kSureRangeShare = 0.4;
// Steps between front and back that a sensor cannot tell apart: less is a slanted surface, from more two
// separate echoes come.
constexpr double kSmallestEdge = 0.1;  // [m]
constexpr double kLargestEdge = 1.5;   // [m]
constexpr float kFullIntensity = 255.0F;

// Rotates by a small rotation vector; the term left out, |w|^3 / 6, stays below 1e-11.
Vector3d rotated(const Vector3d& w, const Vector3d& v) {
  const Vector3d turned = w.cross(v);
  return v + turned + 0.5 * w.cross(turned);
}

// The shot of a sensor at `dt` seconds after the kinematics; its time is left open.
Ray ray_after(const Kinematics& at, double dt, const Vector3d& p_imu_start, const Vector3d& direction_imu) {
  const Vector3d turn = dt * at.angular_rate_imu;
  const Vector3d p_world_imu =
      at.T_world_imu.t + dt * at.velocity_world + (0.5 * dt * dt) * at.acceleration_world;
  return {p_world_imu + at.T_world_imu.R * rotated(turn, p_imu_start),
          at.T_world_imu.R * rotated(turn, direction_imu)};
}

}  // namespace

LidarModel::LidarModel(const LidarConfig& config, std::uint64_t seed)
    : config_(config),
      table_(config.table()),
      seed_(seed),
      T_imu_lidar_(config.T_imu_lidar()),
      min_cos_incidence_(std::cos(config.max_incidence_deg * std::numbers::pi / 180.0)),
      pattern_(make_pattern(config, table_, seed)) {
  Random random(sub_seed(seed, kMostLasers));
  for (std::size_t i = 0; i < kMostLasers; ++i) laser_biases_.push_back(config.laser_bias * random.normal());
}

Duration LidarModel::period() const { return from_seconds(1.0 / config_.rate_hz); }

SimulatedScan LidarModel::scan(const World& world, const Motion& motion, Duration begin, Duration end) const {
  const std::vector<Beam> beams = pattern_->beams(begin, end);
  const std::vector<Return> returns = shoot(world, motion, beams);
  SimulatedScan result;
  sensor::LidarScan& scan = result.scan;
  Duration first = begin;
  Duration last = begin;
  for (std::size_t i = 0; i < beams.size(); ++i) {
    if (returns[i].surface < 0) continue;
    if (scan.points.empty()) first = beams[i].time;
    last = beams[i].time;
    scan.points.push_back(returns[i].point);
    scan.offsets.push_back(static_cast<float>(to_seconds(last - first)));
    scan.intensities.push_back(returns[i].intensity);
    scan.rings.push_back(beams[i].ring);
    result.truth.ranges.push_back(returns[i].range);
    result.truth.surfaces.push_back(returns[i].surface);
  }
  scan.start_time = Time(first);
  scan.end_time = Time(last);
  return result;
}

std::vector<LidarModel::Return> LidarModel::shoot(const World& world, const Motion& motion,
                                                  const std::vector<Beam>& beams) const {
  std::vector<Return> returns(beams.size());
  parallel::for_ranges(beams.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Duration anchor_time{};
    Kinematics anchor;
    for (std::size_t i = begin; i < end; ++i) {
      if (i == begin || beams[i].time - anchor_time > kPoseInterval / 2) {
        anchor_time = beams[i].time + (i == begin ? Duration{0} : kPoseInterval / 2);
        anchor = motion.at(to_seconds(anchor_time));
      }
      const double dt = to_seconds(beams[i].time - anchor_time);
      const Vector3d direction_imu = T_imu_lidar_.R * beams[i].direction;
      Ray ray = ray_after(anchor, dt, T_imu_lidar_ * beams[i].origin, direction_imu);
      ray.time = to_seconds(beams[i].time);
      returns[i] = measure(world, ray, beams[i]);
    }
  });
  return returns;
}

// A beam has a width: one that is half on an edge may return a range between the front and the back.
double LidarModel::mixed_range(const World& world, const Ray& ray, const Hit& hit, Random& random) const {
  if (!random.chance(config_.mixed_pixels)) return hit.range;
  const double angle = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double share = random.uniform();
  const double spread = 0.5 * table_.beam_divergence_deg * std::numbers::pi / 180.0;
  const Vector3d across = ray.direction.unitOrthogonal();
  const Vector3d aside = std::cos(angle) * across + std::sin(angle) * ray.direction.cross(across);
  Ray rim = ray;
  rim.direction = (ray.direction + std::tan(spread) * aside).normalized();
  const auto other = world.cast(rim, table_.farthest);
  if (!other || other->surface == hit.surface) return hit.range;
  const double step = other->range - hit.range;
  if (std::abs(step) < kSmallestEdge || std::abs(step) > kLargestEdge) return hit.range;
  return hit.range + share * step;
}

LidarModel::Return LidarModel::measure(const World& world, const Ray& ray, const Beam& beam) const {
  const double farthest = table_.farthest;
  const auto hit = world.cast(ray, farthest);
  if (!hit) return {};
  // Every shot has random numbers of its own: no result depends on which thread does what.
  Random random(sub_seed(seed_, static_cast<std::uint64_t>(beam.time.count()) * kMostLasers + beam.ring));
  const double cos_incidence = -hit->normal.dot(ray.direction);
  if (cos_incidence < min_cos_incidence_) return {};
  const double sure_range = kSureRangeShare * farthest / hit->range;
  const double strength = hit->reflectivity * cos_incidence / kSureReflectivity * sure_range * sure_range;
  const bool dropped = random.chance(config_.dropout) || random.uniform() > config_.point_share;
  const bool too_weak = random.uniform() > strength;
  double range = hit->range + laser_biases_[beam.ring] + config_.range_noise * random.normal();
  if (dropped || too_weak) return {};
  if (config_.mixed_pixels > 0.0) range += mixed_range(world, ray, *hit, random) - hit->range;
  if (table_.range_step > 0.0) range = table_.range_step * std::round(range / table_.range_step);
  if (range < table_.nearest || range > farthest) return {};
  const auto true_range = static_cast<float>((beam.origin + hit->range * beam.direction).norm());
  return {(beam.origin + range * beam.direction).cast<float>(),
          table_.beam_origin > 0.0 ? true_range : static_cast<float>(hit->range),
          kFullIntensity * static_cast<float>(hit->reflectivity * cos_incidence), hit->surface};
}

}  // namespace mmlins::sim

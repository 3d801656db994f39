// SPDX-License-Identifier: MIT
#include "mmlins/sim/simulation.hpp"

#include <algorithm>
#include <cmath>

#include "mmlins/sim/mover_planner.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/rides.hpp"
#include "mmlins/sim/travel_clock.hpp"

namespace mmlins::sim {

namespace {

constexpr Time kStart = time_from_ns(1'700'000'000'000'000'000);
constexpr Duration kFirstScan{53'000'000};  // the LiDAR does not wake up together with the IMU
constexpr double kPathStep = 0.1;           // between the places that loose objects leave free [s]
constexpr double kQuickPathStep = 0.02;     // the same for carriers that are kidnapped [s]

enum RandomPart : std::uint64_t { kImu, kLidar, kEvents };

std::uint64_t part_seed(const SimulationConfig& config, RandomPart part) {
  return sub_seed(static_cast<std::uint64_t>(config.seed), part);
}

// Where the carrier passes, thinned to places at least a little apart.
Polygon places_passed(const Motion& motion, const SimulationConfig& config) {
  constexpr double kApart = 0.15;  // [m]
  constexpr std::size_t kMostPlaces = 20'000;
  const bool is_kidnapped = std::any_of(config.events.begin(), config.events.end(), [](const auto& event) {
    return event.kind == degrade::EventKind::kKidnap;
  });
  const double step = is_kidnapped ? kQuickPathStep : kPathStep;
  Polygon places;
  for (double t = 0.0; t < config.duration && places.size() < kMostPlaces; t += step) {
    const Eigen::Vector2d place = motion.at(t).T_world_imu.t.head<2>();
    if (places.empty() || (place - places.back()).norm() > kApart) places.push_back(place);
  }
  return places;
}

Status validate_route(const SimulationConfig& config, const std::string& source) {
  const std::size_t corners = config.trajectory.route.size();
  if (config.trajectory.style != PathStyle::kRoute) return {};
  if (corners >= 3 || (corners == 0 && config.world.scene != SceneKind::kCloud)) return {};
  return make_error(
      ErrorCode::kInvalid,
      "{}: trajectory.route needs three corners or more, as in [{{x: 0, y: 0}}, ...]; it has {}", source,
      corners);
}

}  // namespace

Fields SimulationConfig::fields() {
  return {
      field("duration", duration, "s", {1.0, 36000.0}, "length of the recording"),
      field("seed", seed, "", {0, 1e9}, "of all noise; the world has a seed of its own"),
      group("world", world, "the place"),
      group("sensor", sensor, "the LiDAR and where it sits"),
      group("imu", imu, "the inertial sensor"),
      group("trajectory", trajectory, "how the carrier moves"),
      groups("events", events, "what goes wrong with the LiDAR, and when"),
  };
}

Status validate(const SimulationConfig& config, const std::string& source) {
  if (const auto table = load_sensor_table(config.sensor.model); !table) return table.error();
  sensor::Rig rig;
  rig.p_imu_lidar = config.sensor.p_imu_lidar;
  rig.q_imu_lidar_xyzw = config.sensor.q_imu_lidar_xyzw;
  rig.min_range = config.sensor.nearest();
  rig.max_range = config.sensor.farthest();
  if (const Status status = sensor::validate(rig, source + ": sensor"); !status) return status;
  for (const degrade::EventSpec& event : config.events) {
    if (const Status status = degrade::validate(event, from_seconds(config.duration), source); !status) {
      return status;
    }
  }
  if (const Status status = validate_route(config, source); !status) return status;
  if (!config.trajectory.start_in_motion && config.trajectory.stand_still >= config.duration) {
    return make_error(
        ErrorCode::kInvalid,
        "{}: trajectory.stand_still ({} s) must be shorter than duration ({} s), or nothing moves", source,
        config.trajectory.stand_still, config.duration);
  }
  const auto& p = config.sensor.p_imu_lidar;
  if (const Status status = validate_rides(config.events, {p[0], p[1], p[2]}, source); !status) return status;
  return validate_stops(config.trajectory.resolved(), all_stops(config.trajectory.stops, config.events),
                        config.duration, source + ": trajectory.stops");
}

Simulation::Simulation(const SimulationConfig& config) : Simulation(config, nullptr) {}

Simulation::Simulation(const SimulationConfig& config, std::unique_ptr<World> world)
    : config_(config),
      T_world_scene_(config.world.T_world_scene()),
      motion_(make_motion(config.trajectory, scene_route(config.world), config.events)),
      world_(world ? std::move(world) : make_world(config.world, places_passed(*motion_, config))),
      imu_(config.imu, part_seed(config, kImu), from_seconds(config.duration)),
      lidar_(config.sensor, part_seed(config, kLidar)),
      degrader_(config.events, kStart, {part_seed(config, kEvents), config.sensor.nearest()}) {
  std::vector<Mover> movers = plan_movers(config.world, *world_, *motion_, config.duration);
  std::vector<Cabin> cabins;
  for (const degrade::EventSpec& event : config.events) {
    if (event.kind == degrade::EventKind::kElevator)
      cabins.emplace_back(event, *motion_, config.trajectory, config.world.unevenness);
  }
  if (movers.empty() && cabins.empty()) return;
  auto moving = std::make_unique<MovingWorld>(std::move(world_), std::move(movers), std::move(cabins));
  moving_ = moving.get();
  world_ = std::move(moving);
}

Result<sensor::Item> Simulation::next() {
  const Duration length = from_seconds(config_.duration);
  while (true) {
    const Duration scan_end = scan_begin(next_scan_ + 1);
    const Duration scan_recorded = scan_end + from_seconds(config_.sensor.latency);
    const Duration imu_time = imu_.sample_time(next_imu_);
    if (imu_time <= std::min(length, scan_recorded)) {
      const std::int64_t index = next_imu_++;
      if (imu_.is_dropped(index)) continue;
      if (holds(config_.events, degrade::EventKind::kKidnap, to_seconds(imu_time))) continue;
      sensor::ImuSample sample = imu_.sample(*motion_, index);
      sample.time = kStart + sample.time.time_since_epoch();
      record_time_ = kStart + imu_time;
      return sensor::Item(sample);
    }
    if (scan_recorded > length) return sensor::Item(sensor::EndOfData{});
    record_time_ = kStart + scan_recorded;
    if (auto scan = make_scan()) return sensor::Item(std::move(*scan));
  }
}

std::optional<sensor::LidarScan> Simulation::make_scan() {
  SimulatedScan made = lidar_.scan(*world_, *motion_, scan_begin(next_scan_), scan_begin(next_scan_ + 1));
  ++next_scan_;
  made.scan.start_time = kStart + made.scan.start_time.time_since_epoch();
  made.scan.end_time = kStart + made.scan.end_time.time_since_epoch();
  scan_truth_ = std::move(made.truth);
  return degrade(std::move(made.scan));
}

std::optional<sensor::LidarScan> Simulation::degrade(sensor::LidarScan scan) {
  if (config_.events.empty()) return scan;
  const std::vector<Time> times = degrade::point_times(scan);
  const degrade::DegradedSweep sweep = degrader_.apply({scan.start_time, &scan.points, &times});
  if (sweep.lost) return std::nullopt;
  if (!sweep.changed) return scan;
  ScanTruth truth;
  for (std::size_t i = 0; i < sweep.kept.size(); ++i) {
    const std::uint32_t old = sweep.kept[i];
    const bool moved = sweep.points[i] != scan.points[old];
    truth.ranges.push_back(moved ? sweep.points[i].norm() : scan_truth_.ranges[old]);
    truth.surfaces.push_back(moved ? -1 : scan_truth_.surfaces[old]);
  }
  scan_truth_ = std::move(truth);
  return degrade::degraded(scan, sweep);
}

Duration Simulation::scan_begin(std::int64_t index) const { return kFirstScan + index * lidar_.period(); }

double Simulation::progress() const {
  return std::clamp(to_seconds(record_time_ - kStart) / config_.duration, 0.0, 1.0);
}

Time Simulation::start_time() const { return kStart; }
Time Simulation::end_time() const { return kStart + from_seconds(config_.duration); }

Kinematics Simulation::kinematics(Time time) const {
  return transformed(T_world_scene_, motion_->at(to_seconds(time - kStart)));
}
math::SE3 Simulation::T_world_imu(Time time) const { return kinematics(time).T_world_imu; }
math::Vector3d Simulation::velocity_world(Time time) const { return kinematics(time).velocity_world; }
math::Vector3d Simulation::acceleration_world(Time time) const { return kinematics(time).acceleration_world; }
math::Vector3d Simulation::angular_rate_imu(Time time) const { return kinematics(time).angular_rate_imu; }
ImuBias Simulation::bias(Time time) const { return imu_.bias_at(time - kStart); }

math::Trajectory Simulation::truth(double rate_hz) const {
  math::Trajectory truth;
  const auto count = static_cast<std::int64_t>(std::floor(config_.duration * rate_hz + 1e-9));
  for (std::int64_t i = 0; i <= count; ++i) {
    const Time time = kStart + from_seconds(static_cast<double>(i) / rate_hz);
    truth.push_back({time, T_world_imu(time)});
  }
  return truth;
}

std::optional<Hit> Simulation::cast(const Ray& ray_world, double max_range) const {
  const math::SE3 T_scene_world = T_world_scene_.inverse();
  const World& still = moving_ == nullptr ? *world_ : moving_->still();
  auto hit = still.cast({T_scene_world * ray_world.origin, T_scene_world.R * ray_world.direction}, max_range);
  if (hit) hit->normal = T_world_scene_.R * hit->normal;
  return hit;
}

double Simulation::distance_to_surface(const math::Vector3d& p_world, int surface, Time time) const {
  return world_->distance_at(T_world_scene_.inverse() * p_world, surface, to_seconds(time - kStart));
}

const std::vector<Mover>& Simulation::movers() const {
  static const std::vector<Mover> none;
  return moving_ == nullptr ? none : moving_->movers();
}

sensor::Rig Simulation::rig() const {
  sensor::Rig rig;
  rig.lidar_model = config_.sensor.model_name();
  rig.lidar_topic = "/points";
  rig.imu_topic = "/imu/data";
  rig.p_imu_lidar = config_.sensor.p_imu_lidar;
  rig.q_imu_lidar_xyzw = config_.sensor.q_imu_lidar_xyzw;
  const ImuConfig imu = config_.imu.resolved();
  rig.imu_rate_hz = imu.rate_hz;
  rig.gyro_noise_density = imu.gyro_noise_density;
  rig.accel_noise_density = imu.accel_noise_density;
  rig.gyro_bias_walk = imu.gyro_bias_walk;
  rig.accel_bias_walk = imu.accel_bias_walk;
  // A simulated IMU may have no bias at all; a rig always doubts it a little.
  rig.gyro_turn_on_bias = std::max(1e-5, imu.gyro_turn_on_bias);
  rig.accel_turn_on_bias = std::max(1e-3, imu.accel_turn_on_bias);
  rig.min_range = config_.sensor.nearest();
  rig.max_range = config_.sensor.farthest();
  rig.range_noise = std::max(1e-3, config_.sensor.range_noise);
  return rig;
}

}  // namespace mmlins::sim

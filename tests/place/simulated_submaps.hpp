// SPDX-License-Identifier: MIT
#pragma once
// Drives through simulated places along a course and beside it, there and back, with true poses: what
// recognition and registration are measured on.

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/keyframe/submap.hpp"
#include "mmlins/lidar/deskew.hpp"
#include "mmlins/lidar/voxel_downsample.hpp"
#include "mmlins/sim/lidar_model.hpp"
#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::place_test {

/// How a drive goes along the course of its site.
struct DriveSpec {
  std::string sensor = "vlp16";
  bool reverse = false;    ///< the same part of the course, from its end to its beginning
  double offset = 0.0;     ///< to the left of the course, seen in the direction of travel [m]
  double from = 0.0;       ///< time on the course at which it begins [s]
  double duration = 30.0;  ///< [s]
  double step = 1.0;       ///< between keyframes [m]
  int map_id = 0;
  int seed = 1;
};

class Site {
 public:
  explicit Site(sim::SceneKind scene, int seed = 1, double speed = 3.0) : speed_(speed) {
    world_config_.scene = scene;
    world_config_.seed = seed;
    const auto motion = motion_of();
    sim::Polygon passed;
    for (double t = 0.0; t < kLongest / speed_; t += 0.3 / speed_) passed.push_back(place(*motion, t));
    world_ = sim::make_world(world_config_, passed);
  }

  /// Keyframes with true poses in the frame of the scene. Where the way beside the course is barred, it keeps
  /// to the course: see `blocked`.
  [[nodiscard]] keyframe::Keyframes drive(const DriveSpec& spec, std::vector<bool>* blocked = nullptr) const {
    sim::LidarConfig sensor;
    sensor.model = spec.sensor;
    if (spec.sensor == "os1_64") sensor.columns = 512;
    const sim::LidarModel lidar(sensor, static_cast<std::uint64_t>(spec.seed));
    const Beside motion(motion_of(), spec);
    keyframe::Keyframes keyframes;
    std::optional<math::Vector3d> last;
    for (double t = spec.from; t < spec.from + spec.duration; t += 0.05) {
      const math::Vector3d p = motion.at(t).T_world_imu.t;
      if (last && (p - *last).norm() < spec.step) continue;
      last = p;
      if (is_barred(motion, t)) {
        if (blocked != nullptr) blocked->push_back(true);
        keyframes.push_back(empty_keyframe(static_cast<int>(keyframes.size()), spec, motion, t));
        continue;
      }
      if (blocked != nullptr) blocked->push_back(false);
      keyframes.push_back(see(static_cast<int>(keyframes.size()), spec, motion, lidar, t));
    }
    return keyframes;
  }

  /// Submaps of a drive; those in which the way was barred are left out.
  [[nodiscard]] std::vector<keyframe::Submap> submaps(const DriveSpec& spec,
                                                      const keyframe::SubmapConfig& config = {}) const {
    std::vector<bool> blocked;
    const keyframe::Keyframes keyframes = drive(spec, &blocked);
    std::vector<keyframe::Submap> submaps;
    for (const auto& range : keyframe::split_by_travel(keyframes, config)) {
      const auto first = static_cast<std::ptrdiff_t>(range.first),
                 last = static_cast<std::ptrdiff_t>(range.last);
      if (std::any_of(blocked.begin() + first, blocked.begin() + last, [](bool b) { return b; })) continue;
      submaps.push_back(
          keyframe::build_submap({keyframes.begin() + first, keyframes.begin() + last}, config));
      if (submaps.back().travel < 0.7 * config.travel) submaps.pop_back();
    }
    return submaps;
  }

 private:
  static constexpr double kLongest = 1500.0;  // of the courses that objects keep free [m]

  /// A motion shifted to the left of where it goes, there or back.
  class Beside : public sim::Motion {
   public:
    Beside(std::unique_ptr<sim::Motion> course, const DriveSpec& spec)
        : course_(std::move(course)), spec_(spec) {}
    [[nodiscard]] sim::Kinematics at(double seconds) const override {
      sim::Kinematics kinematics = on_course(seconds);
      const math::Vector3d v = kinematics.velocity_world;
      kinematics.T_world_imu.t += spec_.offset * math::Vector3d(-v.y(), v.x(), 0.0).normalized();
      return kinematics;
    }
    [[nodiscard]] sim::Kinematics on_course(double seconds) const {
      if (!spec_.reverse) return course_->at(seconds);
      sim::Kinematics back = course_->at(2.0 * spec_.from + spec_.duration - seconds);
      back.velocity_world = -back.velocity_world;
      back.T_world_imu.R = back.T_world_imu.R * math::so3_exp({0.0, 0.0, std::numbers::pi});
      return back;
    }

   private:
    std::unique_ptr<sim::Motion> course_;
    DriveSpec spec_;
  };

  [[nodiscard]] std::unique_ptr<sim::Motion> motion_of() const {
    sim::TrajectoryConfig config;
    config.style = sim::PathStyle::kRoute;
    config.start_in_motion = true;
    config.stand_still = 0.0;
    config.ramp = 0.1;
    config.speed = speed_;
    config.start_lap = 0.0;
    return sim::make_motion(config, sim::scene_route(world_config_));
  }
  static Eigen::Vector2d place(const sim::Motion& motion, double t) {
    return motion.at(t).T_world_imu.t.head<2>();
  }

  [[nodiscard]] bool is_barred(const Beside& motion, double t) const {
    const math::Vector3d from = motion.on_course(t).T_world_imu.t, to = motion.at(t).T_world_imu.t;
    const double length = (to - from).norm();
    if (length < 1e-6) return false;
    return world_->cast({from, (to - from) / length}, length + 0.3).has_value();
  }

  static Time time_of(double t) { return Time(from_seconds(t)); }

  static keyframe::KeyframePointer empty_keyframe(int id, const DriveSpec& spec, const sim::Motion& motion,
                                                  double t) {
    keyframe::Keyframe kf;
    kf.id = id;
    kf.map_id = spec.map_id;
    kf.time = time_of(t);
    kf.T_map_imu = motion.at(t).T_world_imu;
    kf.down_imu = -kf.T_map_imu.R.transpose().col(2);
    return std::make_shared<const keyframe::Keyframe>(std::move(kf));
  }

  keyframe::KeyframePointer see(int id, const DriveSpec& spec, const sim::Motion& motion,
                                const sim::LidarModel& lidar, double t) const {
    const Duration end = from_seconds(t + 10.0), begin = end - from_seconds(0.1);  // patterns start at 0
    const Shifted shifted(motion, 10.0);
    const sensor::LidarScan scan = lidar.scan(*world_, shifted, begin, end).scan;
    math::Trajectory poses;
    for (int i = 0; i <= 10; ++i) {
      const Duration at = begin + from_seconds(0.01 * i);
      poses.push_back({Time(at), shifted.at(to_seconds(at)).T_world_imu});
    }
    const lidar::Cloud cloud = lidar::deskew(scan, poses, sim::LidarConfig{}.T_imu_lidar(), {0.5, 100.0});
    keyframe::Keyframe kf = *empty_keyframe(id, spec, motion, t);
    kf.T_map_imu = poses.back().pose;
    kf.down_imu = -kf.T_map_imu.R.transpose().col(2);
    kf.points_imu = lidar::voxel_downsample(cloud, 0.2).points;
    return std::make_shared<const keyframe::Keyframe>(std::move(kf));
  }

  /// The same motion, later: scans may begin before a drive does.
  class Shifted : public sim::Motion {
   public:
    Shifted(const sim::Motion& motion, double later) : motion_(motion), later_(later) {}
    [[nodiscard]] sim::Kinematics at(double seconds) const override { return motion_.at(seconds - later_); }

   private:
    const sim::Motion& motion_;
    double later_;
  };

  double speed_;
  sim::WorldConfig world_config_;
  std::unique_ptr<sim::World> world_;
};

/// The true pose of one submap in another, both of the same site.
[[nodiscard]] inline math::SE3 true_T(const keyframe::Submap& target, const keyframe::Submap& source) {
  return target.T_map_submap.inverse() * source.T_map_submap;
}

}  // namespace mmlins::place_test

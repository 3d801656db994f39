// SPDX-License-Identifier: MIT
#include "mmlins/sim/cabin.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/sim/random.hpp"
#include "mmlins/sim/rides.hpp"
#include "mmlins/sim/smooth_step.hpp"

namespace mmlins::sim {

namespace {

using math::Vector3d;

constexpr double kHalfLength = 0.9;    // inside [m]
constexpr double kHalfWidth = 0.8;     // [m]
constexpr double kHeight = 2.3;        // [m]
constexpr double kWall = 0.1;          // [m]
constexpr double kHalfDoor = 0.55;     // [m]
constexpr double kDoorHeight = 2.05;   // [m]
constexpr double kHighestCarry = 1.2;  // of the IMU above the floor [m]
constexpr int kDoorSurface = 999;      // of both leaves; those of the shell are fewer
constexpr double kDoorReflectivity = 0.6;

std::vector<Shape> shell_shapes() {
  const double x = kHalfLength, y = kHalfWidth, w = kWall, z = 0.5 * kHeight;
  const double jamb = 0.5 * (y - kHalfDoor);
  std::vector<Shape> shapes{
      make_box({-x - w, 0, z}, {2 * w, 2 * y + 4 * w, kHeight + w}, 0, 0.5),
      make_box({0, 0, kHeight + w}, {2 * x + 4 * w, 2 * y + 4 * w, 2 * w}, 0, 0.7),
      make_box({x + w, 0, 0.5 * (kHeight + kDoorHeight)}, {2 * w, 2 * y, kHeight - kDoorHeight}, 0, 0.5),
      make_box({x - 0.02, kHalfDoor + jamb, 1.15}, {0.04, 0.16, 0.5}, 0, 0.2),  // the buttons
      make_box({-x + 0.06, 0, 0.9}, {0.04, 1.3, 0.05}, 0, 0.4),                 // handrails
      make_box({0, -y + 0.06, 0.9}, {1.4, 0.04, 0.05}, 0, 0.4),
      make_box({0.2, y - 0.005, 1.5}, {0.7, 0.01, 1.0}, 0, 0.3),  // a frame on the wall
      make_box({0, 0, kHeight - 0.03}, {0.6, 0.6, 0.06}, 0, 0.8)};
  for (const double sign : {-1.0, 1.0}) {
    shapes.push_back(make_box({0, sign * (y + w), z}, {2 * x + 4 * w, 2 * w, kHeight + w}, 0, 0.5));
    shapes.push_back(make_box({x + w, sign * (kHalfDoor + jamb), z}, {2 * w, 2 * jamb, kHeight}, 0, 0.5));
  }
  return shapes;
}

math::SE3 built_around(const Kinematics& carrier, const TrajectoryConfig& trajectory) {
  const Vector3d x_axis = carrier.T_world_imu.R.col(0);
  const double yaw = std::atan2(x_axis.y(), x_axis.x()) - trajectory.mount_yaw_deg * std::numbers::pi / 180.0;
  const double above_floor = std::min(trajectory.height, kHighestCarry);
  return {Eigen::AngleAxisd(yaw, Vector3d::UnitZ()).toRotationMatrix(),
          carrier.T_world_imu.t - Vector3d(0.0, 0.0, above_floor)};
}

}  // namespace

Cabin::Cabin(const degrade::EventSpec& elevator, const Motion& motion, const TrajectoryConfig& trajectory,
             double unevenness)
    : elevator_(elevator),
      T_scene_start_(built_around(motion.at(elevator.start), trajectory.resolved())),
      shell_(shell_shapes(),
             {unevenness, 0.0, sub_seed(77, static_cast<std::uint64_t>(1e3 * elevator.start))}) {}

bool Cabin::is_there(double seconds) const {
  return seconds >= elevator_.start && seconds < elevator_.start + elevator_.duration;
}

math::SE3 Cabin::T_scene_cabin(double seconds) const {
  return {T_scene_start_.R, T_scene_start_.t + Vector3d(0.0, 0.0, elevator_rise(elevator_, seconds).value)};
}

double Cabin::half_gap(double seconds) const {
  const double since = (seconds - elevator_.start) / kDoorTime;
  const double left = (elevator_.start + elevator_.duration - seconds) / kDoorTime;
  return kHalfDoor * (1.0 - smooth_step({std::min(since, left), 1.0, 0.0}).value);
}

Cabin::Sight Cabin::cast(const Ray& ray, double max_range) const {
  const math::SE3 T_cabin_scene = T_scene_cabin(ray.time).inverse();
  const Ray inside{T_cabin_scene * ray.origin, T_cabin_scene.R * ray.direction, ray.time};
  double to_door = max_range;
  bool meets_door = false;
  Vector3d at_door = Vector3d::Zero();
  if (inside.direction.x() > 0.0) {
    const double range = (kHalfLength - inside.origin.x()) / inside.direction.x();
    at_door = inside.origin + range * inside.direction;
    meets_door = range < max_range && std::abs(at_door.y()) < kHalfDoor && at_door.z() < kDoorHeight &&
                 at_door.z() > 0.0;
    if (meets_door) to_door = range;
  }
  auto hit = shell_.cast(inside, to_door);
  if (!hit && meets_door && std::abs(at_door.y()) < half_gap(ray.time)) return {std::nullopt, to_door};
  if (!hit && meets_door) hit = Hit{to_door, -Vector3d::UnitX(), kDoorReflectivity, kDoorSurface};
  if (hit) hit->normal = T_scene_start_.R * hit->normal;
  return {hit, std::nullopt};
}

double Cabin::distance_at(const Vector3d& p, int surface, double seconds) const {
  const Vector3d p_cabin = T_scene_cabin(seconds).inverse() * p;
  return surface == kDoorSurface ? kHalfLength - p_cabin.x() : shell_.distance(p_cabin, surface);
}

}  // namespace mmlins::sim

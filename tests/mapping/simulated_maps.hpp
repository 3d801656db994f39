// SPDX-License-Identifier: MIT
#pragma once
// Maps of simulated places, whose keyframes have true poses (or such with an error that is known), and a back
// end that is fed with them.

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "mmlins/mapping/back_end_mapper.hpp"
#include "tests/place/simulated_submaps.hpp"

namespace mmlins::mapping_test {

/// Keyframes of one map as the odometry hands them on, and how it began.
struct SimulatedMap {
  math::SE3 T_scene_map;                         ///< where it truly lies
  math::SE3 T_world_map;                         ///< where it is said to lie
  std::optional<math::Matrix6d> gap_covariance;  ///< of what is said
  int bridge_before = -1;                        ///< keyframe before which the IMU alone carried the pose
  double bridge_deviation = 0.0;                 ///< of what it carried [m]; of the heading 1 degree
  std::vector<math::SE3> T_scene_imu;            ///< true poses of its keyframes
  keyframe::Keyframes keyframes;
};

/// What the odometry makes of the true poses of a drive; the first stays.
using Drift = std::function<std::vector<math::SE3>(const std::vector<math::SE3>&)>;

/// Makes a map of a drive. Its frame is level and lies at its first keyframe.
/// @param first_id  of its keyframes
inline SimulatedMap make_map(const keyframe::Keyframes& drive, int map_id, int first_id,
                             const Drift& drift = {}) {
  SimulatedMap map;
  for (const auto& kf : drive) map.T_scene_imu.push_back(kf->T_map_imu);
  const math::SE3& first = map.T_scene_imu.front();
  const double yaw = std::atan2(first.R(1, 0), first.R(0, 0));
  map.T_scene_map = {math::so3_exp({0.0, 0.0, yaw}), first.t};
  map.T_world_map = map.T_scene_map;
  const std::vector<math::SE3> measured = drift ? drift(map.T_scene_imu) : map.T_scene_imu;
  for (std::size_t i = 0; i < drive.size(); ++i) {
    keyframe::Keyframe kf = *drive[i];
    kf.id = first_id + static_cast<int>(i);
    kf.map_id = map_id;
    kf.T_map_imu = map.T_scene_map.inverse() * measured[i];
    map.keyframes.push_back(std::make_shared<const keyframe::Keyframe>(std::move(kf)));
  }
  return map;
}

/// Scale and heading of the odometry are a little wrong: each step is this much too long and turned.
inline Drift steady_drift(double scale, double turn_per_step) {
  return [=](const std::vector<math::SE3>& poses) {
    std::vector<math::SE3> measured{poses.front()};
    for (std::size_t i = 1; i < poses.size(); ++i) {
      math::SE3 step = poses[i - 1].inverse() * poses[i];
      step.t *= 1.0 + scale;
      step.R = step.R * math::so3_exp({0.0, 0.0, turn_per_step});
      measured.push_back(measured.back() * step);
    }
    return measured;
  };
}

/// From the pose at `from` on all lie elsewhere: the map was found again in the wrong place.
inline Drift jump(std::size_t from, const math::Vector3d& by) {
  return [=](const std::vector<math::SE3>& poses) {
    std::vector<math::SE3> measured = poses;
    for (std::size_t i = from; i < measured.size(); ++i) measured[i].t += by;
    return measured;
  };
}

/// A filter that knows its pose to 2 cm and 0.1 degrees.
inline math::Matrix6d pose_covariance() {
  math::Vector6d variances;
  variances << math::Vector3d::Constant(3e-6), math::Vector3d::Constant(4e-4);
  return variances.asDiagonal();
}

/// Feeds the maps to the back end, one after the other.
inline void feed(mapping::BackEndMapper& mapper, keyframe::KeyframeStore& store,
                 const std::vector<SimulatedMap>& maps) {
  for (std::size_t i = 0; i < maps.size(); ++i) {
    mapper.begin_map({static_cast<int>(i), maps[i].T_world_map, maps[i].gap_covariance});
    for (const auto& kf : maps[i].keyframes) {
      if (kf->id == maps[i].bridge_before) mapper.bridge(mapping::covariance_of(1.0, maps[i].bridge_deviation));
      MMLINS_CHECK(store.add(kf).ok());
      mapper.add(kf, pose_covariance());
    }
    mapper.end_map();
  }
}

/// Largest distance between where the odometry had the keyframes of a map and where they truly are [m].
inline double largest_drift(const SimulatedMap& map) {
  double largest = 0.0;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const math::SE3 T_scene_imu = map.T_scene_map * map.keyframes[i]->T_map_imu;
    largest = std::max(largest, (T_scene_imu.t - map.T_scene_imu[i].t).norm());
  }
  return largest;
}

/// Largest distance between where the keyframes of a map lie and where they truly are [m].
inline double largest_error(const mapping::BackEndMapper& mapper, const SimulatedMap& map) {
  double largest = 0.0;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const math::Vector3d p = mapper.map_graph().T_world_keyframe(map.keyframes[i]->id).t;
    largest = std::max(largest, (p - map.T_scene_imu[i].t).norm());
  }
  return largest;
}

}  // namespace mmlins::mapping_test

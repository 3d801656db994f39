// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/world_trajectory.hpp"

#include <algorithm>

#include "mmlins/imu/nav_state.hpp"
#include "mmlins/pipeline/carried_stretch.hpp"

namespace mmlins::pipeline {
namespace {

using math::SE3;

/// Where keyframe `k` says that the scan is.
SE3 by(const KeyframePlace& k, const ScanPlace& scan) { return k.T_world_imu * (k.T_map_imu.inverse() * scan.T_map_imu); }

SE3 between_keyframes(const ScanPlace& scan, std::span<const KeyframePlace> keyframes) {
  const auto later = std::upper_bound(keyframes.begin(), keyframes.end(), scan.time,
                                      [](Time time, const KeyframePlace& k) { return time < k.time; });
  const bool has_next = later != keyframes.end() && later->map_id == scan.map_id;
  const bool has_last = later != keyframes.begin() && std::prev(later)->map_id == scan.map_id;
  if (!has_next && !has_last) return scan.T_map_imu;
  if (!has_next) return by(*std::prev(later), scan);
  if (!has_last) return by(*later, scan);
  const KeyframePlace& a = *std::prev(later);
  const double share = to_seconds(scan.time - a.time) / to_seconds(later->time - a.time);
  return math::interpolate(by(a, scan), by(*later, scan), share);
}

/// Carries the poses on from the scan before by the motion in odom, up to and with the scan `last`.
void carry_on(std::span<const ScanPlace> scans, std::span<SE3> poses, std::size_t first, std::size_t last) {
  for (std::size_t i = first; i <= last; ++i) {
    poses[i] = poses[first - 1] * (scans[first - 1].T_odom_imu.inverse() * scans[i].T_odom_imu);
  }
}

/// What the IMU made of the way to the placed scan `end`, where the odometry has been corrected.
MovingPose end_of_carried(std::span<const ScanPlace> scans, std::span<const MovingPose> carried, std::size_t end) {
  MovingPose pose = carried.back();
  const MovingPose& before = carried[carried.size() - 2];
  if (scans[end].carried) {
    pose.T_world_imu = before.T_world_imu * (scans[end - 1].T_odom_imu.inverse() * scans[end].carried->T_odom_imu);
    pose.v_world = pose.T_world_imu.R * scans[end].carried->v_imu;
  } else if (carried.size() > 3) {
    pose.v_world = 2.0 * before.v_world - carried[carried.size() - 3].v_world;
  }
  return pose;
}

/// Fits what the IMU carried, scans first to last, to the placed scan after them.
void fit_between(std::span<const ScanPlace> scans, std::span<SE3> poses, std::size_t first, std::size_t last,
                 const sensor::Rig& rig) {
  const std::size_t end = last + 1;
  const SE3 T_world_end = poses[end];
  carry_on(scans, poses, first, end);
  std::vector<MovingPose> carried;
  for (std::size_t i = first - 1; i <= end; ++i) carried.push_back({scans[i].time, poses[i], poses[i].R * scans[i].v_imu});
  carried.back() = end_of_carried(scans, carried, end);
  const std::vector<SE3> fitted = smooth(carried, {scans[end].time, T_world_end, T_world_end.R * scans[end].v_imu}, rig);
  std::copy(fitted.begin(), fitted.end(), poses.begin() + static_cast<std::ptrdiff_t>(first));
  poses[end] = T_world_end;
}

/// What the IMU carried from some scan that is not placed, first to last, to the placed scan after them, seen from there:
/// its attitude, velocity and gravity are those of the end, whatever it thought of them before. Eq. (7a).
void carry_back(std::span<const ScanPlace> scans, std::span<SE3> poses, std::size_t first, std::size_t last) {
  const ScanPlace& end = scans[last + 1];
  const SE3& T_world_end = poses[last + 1];
  const SE3 T_odom_end = end.carried ? end.carried->T_odom_imu : end.T_odom_imu;
  const math::Vector3d v_odom_end = T_odom_end.R * (end.carried ? end.carried->v_imu : scans[last].v_imu);
  const math::Matrix3d R_world_odom = T_world_end.R * T_odom_end.R.transpose();
  const math::Vector3d v_wrong = T_world_end.R * end.v_imu - R_world_odom * v_odom_end;
  const math::Vector3d gravity(0.0, 0.0, -imu::kGravity);
  const math::Vector3d gravity_wrong = gravity - R_world_odom * gravity;
  for (std::size_t i = first; i <= last; ++i) {
    const double ahead = to_seconds(end.time - scans[i].time);
    const SE3& T_odom_imu = scans[i].T_odom_imu;
    poses[i].R = R_world_odom * T_odom_imu.R;
    poses[i].t = T_world_end.t - R_world_odom * (T_odom_end.t - T_odom_imu.t) - ahead * v_wrong +
                 0.5 * ahead * ahead * gravity_wrong;
  }
}

/// Puts the scans first to last, between two that are placed, where they belong.
void bridge_over(std::span<const ScanPlace> scans, std::span<SE3> poses, std::size_t first, std::size_t last,
                 const sensor::Rig& rig) {
  std::size_t cut = last + 1;
  while (cut > first && !scans[cut].is_cut_off) --cut;
  if (!scans[cut].is_cut_off) return fit_between(scans, poses, first, last, rig);
  if (cut > first) carry_on(scans, poses, first, cut - 1);
  if (cut <= last) carry_back(scans, poses, cut, last);
}

}  // namespace

std::vector<SE3> world_trajectory(std::span<const ScanPlace> scans, std::span<const KeyframePlace> keyframes,
                                  const sensor::Rig& rig) {
  std::vector<SE3> poses;
  poses.reserve(scans.size());
  for (const ScanPlace& scan : scans) poses.push_back(between_keyframes(scan, keyframes));
  std::size_t first = 0;
  while (first < scans.size()) {
    if (scans[first].is_placed || first == 0) {
      ++first;
      continue;
    }
    std::size_t last = first;
    while (last + 1 < scans.size() && !scans[last + 1].is_placed) ++last;
    if (last + 1 < scans.size()) {
      bridge_over(scans, poses, first, last, rig);
    } else {
      carry_on(scans, poses, first, last);
    }
    first = last + 1;
  }
  return poses;
}

}  // namespace mmlins::pipeline

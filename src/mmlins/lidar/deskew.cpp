// SPDX-License-Identifier: MIT
#include "mmlins/lidar/deskew.hpp"

#include <algorithm>
#include <cmath>

#include "mmlins/base/check.hpp"

namespace mmlins::lidar {
namespace {

// One pose serves all points of such a stretch [s]: at 2 rad/s and 50 m range its half costs 1 cm.
constexpr double kBucketSeconds = 2e-4;

struct Pose {
  Eigen::Matrix3f R;
  Eigen::Vector3f t;
};

/// T_imu(end)_lidar(t) in the middle of every bucket.
std::vector<Pose> bucket_poses(const sensor::LidarScan& scan, const math::Trajectory& T_odom_imu,
                               const math::SE3& T_imu_lidar) {
  const double seconds = to_seconds(scan.end_time - scan.start_time);
  const auto num_buckets = static_cast<std::size_t>(seconds / kBucketSeconds) + 1;
  const math::SE3 T_imu_odom = T_odom_imu.back().pose.inverse();
  std::vector<Pose> poses(num_buckets);
  std::size_t node = 0;
  for (std::size_t i = 0; i < num_buckets; ++i) {
    const double offset = std::min(seconds, (static_cast<double>(i) + 0.5) * kBucketSeconds);
    const Time time = std::clamp(scan.start_time + from_seconds(offset), T_odom_imu.front().time, T_odom_imu.back().time);
    while (node + 2 < T_odom_imu.size() && T_odom_imu[node + 1].time < time) ++node;
    const auto& from = T_odom_imu[node];
    const auto& to = T_odom_imu[std::min(node + 1, T_odom_imu.size() - 1)];
    const double span = to_seconds(to.time - from.time);
    const double s = span > 0.0 ? to_seconds(time - from.time) / span : 1.0;
    const math::SE3 T = T_imu_odom * math::interpolate(from.pose, to.pose, s) * T_imu_lidar;
    poses[i] = {T.R.cast<float>(), T.t.cast<float>()};
  }
  return poses;
}

}  // namespace

Cloud deskew(const sensor::LidarScan& scan, const math::Trajectory& T_odom_imu, const math::SE3& T_imu_lidar,
             const RangeGate& gate) {
  MMLINS_CHECK(!T_odom_imu.empty());
  const std::vector<Pose> poses = bucket_poses(scan, T_odom_imu, T_imu_lidar);
  const auto min2 = static_cast<float>(gate.min_range * gate.min_range);
  const auto max2 = static_cast<float>(gate.max_range * gate.max_range);
  Cloud cloud;
  cloud.points.reserve(scan.size());
  cloud.source.reserve(scan.size());
  for (std::size_t i = 0; i < scan.size(); ++i) {
    const Eigen::Vector3f& p_lidar = scan.points[i];
    const float range2 = p_lidar.squaredNorm();
    if (range2 < min2 || range2 > max2) continue;
    const auto bucket = static_cast<std::size_t>(static_cast<double>(scan.offsets[i]) / kBucketSeconds);
    const Pose& T = poses[std::min(bucket, poses.size() - 1)];
    cloud.points.push_back(T.R * p_lidar + T.t);
    cloud.source.push_back(static_cast<std::uint32_t>(i));
  }
  return cloud;
}

}  // namespace mmlins::lidar

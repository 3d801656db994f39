// SPDX-License-Identifier: MIT
#include "mmlins/odometry/lidar_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "mmlins/base/parallel.hpp"

namespace mmlins::odometry {
namespace {

constexpr std::size_t kGrain = 256;

struct Sum {
  filter::PoseInformation information;
  double squared_residuals = 0.0;

  Sum& operator+=(const Sum& other) {
    information += other.information;
    squared_residuals += other.squared_residuals;
    return *this;
  }
};

/// How far a point at `range` may be off for reasons of the state alone: a bound, not a projection.
struct StateSpread {
  double position2 = 0.0;
  double rotation2 = 0.0;

  StateSpread(const imu::ErrorMatrix& P) {
    position2 = P.block<3, 3>(imu::kPosition, imu::kPosition).trace();
    rotation2 = P.block<3, 3>(imu::kRotation, imu::kRotation).trace();
  }
  [[nodiscard]] double at(double range2) const { return position2 + rotation2 * range2; }
};

/// Keeps the bound within what a map of local planes can still answer [m].
constexpr double kMaxGate = 3.0;

}  // namespace

spatial::PlaneMatch PlacedMap::match(const Eigen::Vector3d& p_odom, double gate) const {
  spatial::PlaneMatch match = map.match(T_map_odom * p_odom, gate);
  match.normal = T_map_odom.R.transpose() * match.normal;
  match.widest = T_map_odom.R.transpose() * match.widest;
  return match;
}

LidarMeasurement::LidarMeasurement(const std::vector<Eigen::Vector3f>& keypoints_imu, const PlacedMap& map,
                                   const MatchingConfig& config, const BeamNoise& noise)
    : keypoints_imu_(keypoints_imu),
      map_(map),
      config_(config),
      noise_(noise),
      matches_(keypoints_imu.size()),
      sharers_(keypoints_imu.size(), 1) {}

void LidarMeasurement::count_sharers() {
  std::unordered_map<std::uint32_t, int> count;
  count.reserve(matches_.size());
  for (const auto& match : matches_) {
    if (match.found && match.plane_id != spatial::kUnsharedPlane) ++count[match.plane_id];
  }
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    const bool shared = matches_[i].found && matches_[i].plane_id != spatial::kUnsharedPlane;
    sharers_[i] = shared ? count[matches_[i].plane_id] : 1;
  }
}

filter::PoseInformation LidarMeasurement::linearise(const imu::NavState& state, const imu::ErrorMatrix& P) {
  const StateSpread spread(P);
  const math::Matrix3d R_imu_odom = state.R_odom_imu.transpose();
  parallel::for_ranges(matches_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Eigen::Vector3d q_imu = keypoints_imu_[i].cast<double>();
      const double motion2 = spread.at(q_imu.squaredNorm());
      spatial::PlaneMatch match = map_.match(state.R_odom_imu * q_imu + state.p_odom, kMaxGate);
      if (match.found) {
        const Eigen::Vector3d beam = q_imu - noise_.p_imu_lidar;
        const double along = (R_imu_odom * match.normal).dot(beam);
        match.surface_variance += noise_.bearing * noise_.bearing * std::max(0.0, beam.squaredNorm() - along * along);
        const double variance = match.surface_variance + match.plane_variance + motion2;
        match.found = match.distance * match.distance < config_.gate_sigmas * config_.gate_sigmas * variance;
      }
      matches_[i] = match;
    }
  });
  count_sharers();
  const Sum sum = parallel::ordered_sum(matches_.size(), kGrain, Sum{}, [&](std::size_t begin, std::size_t end) {
    Sum part;
    for (std::size_t i = begin; i < end; ++i) {
      const spatial::PlaneMatch& match = matches_[i];
      if (!match.found) continue;
      const double variance = match.surface_variance + sharers_[i] * match.plane_variance;
      const double normalised = std::abs(match.distance) / std::sqrt(match.surface_variance + match.plane_variance);
      const double huber = normalised <= config_.huber_sigmas ? 1.0 : config_.huber_sigmas / normalised;
      const double weight = huber / variance;
      math::Vector6d J;
      J.head<3>() = keypoints_imu_[i].cast<double>().cross(R_imu_odom * match.normal);
      J.tail<3>() = match.normal;
      part.information.H.noalias() += weight * J * J.transpose();
      part.information.b.noalias() += weight * match.distance * J;
      part.information.cost += weight * match.distance * match.distance;
      part.information.num_residuals += 1;
      part.squared_residuals += match.distance * match.distance;
    }
    return part;
  });
  residual_rms_ = std::sqrt(sum.squared_residuals / std::max(1, sum.information.num_residuals));
  return sum.information;
}

math::Matrix6d LidarMeasurement::unweighted_information(const imu::NavState& state) const {
  math::Matrix6d sum = math::Matrix6d::Zero();
  for (std::size_t i = 0; i < matches_.size(); ++i) {
    if (!matches_[i].found) continue;
    math::Vector6d J;
    J << keypoints_imu_[i].cast<double>().cross(state.R_odom_imu.transpose() * matches_[i].normal), matches_[i].normal;
    sum.noalias() += J * J.transpose();
  }
  return sum;
}

degeneracy::ScanInformation LidarMeasurement::scan_information(const imu::NavState& state) const {
  const math::Matrix3d R_imu_odom = state.R_odom_imu.transpose();
  return parallel::ordered_sum(matches_.size(), kGrain, degeneracy::ScanInformation{}, [&](std::size_t begin, std::size_t end) {
    degeneracy::ScanInformation part;
    for (std::size_t i = begin; i < end; ++i) {
      const spatial::PlaneMatch& match = matches_[i];
      if (!match.found) continue;
      const double weight = 1.0 / (match.surface_variance + sharers_[i] * match.plane_variance);
      const Eigen::Vector3d q_imu = keypoints_imu_[i].cast<double>();
      const auto row = [&](const Eigen::Vector3d& direction) {
        math::Vector6d J;
        J << q_imu.cross(R_imu_odom * direction), direction;
        return J;
      };
      const math::Vector6d along_normal = row(match.normal);
      const math::Vector6d along_widest = row(match.widest);
      const math::Vector6d along_middle = row(match.normal.cross(match.widest));
      part.H.noalias() += weight * along_normal * along_normal.transpose();
      part.spurious.noalias() += weight * match.tilt_variance_widest * along_widest * along_widest.transpose();
      part.spurious.noalias() += weight * match.tilt_variance_middle * along_middle * along_middle.transpose();
    }
    return part;
  });
}

}  // namespace mmlins::odometry

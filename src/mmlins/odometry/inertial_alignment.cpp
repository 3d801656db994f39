// SPDX-License-Identifier: MIT
#include "mmlins/odometry/inertial_alignment.hpp"

#include <Eigen/QR>

#include "mmlins/imu/propagation.hpp"

namespace mmlins::odometry {
namespace {

/// Positions that the specific force alone would give, from rest and without gravity, at each pose's time.
std::vector<math::Vector3d> force_integrals(const sensor::ImuSamples& samples, const math::Trajectory& T_odom_imu,
                                            imu::NavState state) {
  state.p_odom.setZero();
  state.v_odom.setZero();
  state.gravity_odom.setZero();
  std::vector<math::Vector3d> positions;
  std::size_t pose = 0;
  for (std::size_t i = 1; i < samples.size() && pose < T_odom_imu.size(); ++i) {
    const imu::ImuStep step = imu::step_between(samples[i - 1], samples[i]);
    for (; pose < T_odom_imu.size() && T_odom_imu[pose].time <= samples[i].time; ++pose) {
      const imu::ImuStep part{to_seconds(T_odom_imu[pose].time - samples[i - 1].time), step.gyro, step.accel};
      positions.push_back(imu::integrate(state, part).p_odom);
    }
    state = imu::integrate(state, step);
  }
  return positions;
}

}  // namespace

std::optional<InertialAlignment> align_inertially(const sensor::ImuSamples& samples, const math::Trajectory& T_odom_imu,
                                                  const imu::NavState& begin) {
  const std::vector<math::Vector3d> from_force = force_integrals(samples, T_odom_imu, begin);
  const auto count = static_cast<Eigen::Index>(from_force.size());
  if (count < 4) return std::nullopt;
  Eigen::MatrixX3d A(count, 3);
  Eigen::MatrixX3d rest(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& stamped = T_odom_imu[static_cast<std::size_t>(i)];
    const double t = to_seconds(stamped.time - samples.front().time);
    A.row(i) << 1.0, t, 0.5 * t * t;
    rest.row(i) = (stamped.pose.t - from_force[static_cast<std::size_t>(i)]).transpose();
  }
  // The three axes share one design matrix: rows of the solution are p0, v and g.
  const Eigen::Matrix3d solution = A.colPivHouseholderQr().solve(rest);
  const math::Vector3d gravity = solution.row(2).transpose();
  const double elapsed = A(count - 1, 1);
  InertialAlignment result;
  result.gravity_odom = gravity.normalized() * imu::kGravity;
  // What the known magnitude takes from g, the velocity in the middle of the window keeps.
  result.v_odom = solution.row(1).transpose() + 0.5 * elapsed * (gravity - result.gravity_odom);
  return result;
}

}  // namespace mmlins::odometry

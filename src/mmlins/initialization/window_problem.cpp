// SPDX-License-Identifier: MIT
#include "mmlins/initialization/window_problem.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace mmlins::initialization {
namespace {

using imu::kPosition;
using imu::kRotation;
using imu::kVelocity;
using math::Matrix3d;
using math::Vector3d;

// Rounding of the integration [rad], [m], [m/s]: an IMU without noise would have no weight.
constexpr double kRounding = 1e-8;

/// Residual of the IMU between two states and its Jacobians. Eqs. (8)-(10).
struct MotionResidual {
  NodeVector r;
  NodeMatrix J_from = NodeMatrix::Zero();
  NodeMatrix J_to = NodeMatrix::Zero();
  Eigen::Matrix<double, kNodeSize, kFreeGravity> J_shared;
};

MotionResidual motion_residual(const imu::Preintegration& motion, const imu::NavState& from,
                               const imu::NavState& to) {
  const double t = motion.seconds();
  const Matrix3d Rt = from.R_odom_imu.transpose();
  const imu::ImuBias bias{from.gyro_bias, from.accel_bias};
  const imu::ImuDelta delta = imu::corrected(motion, bias);
  const Vector3d moved = Rt * (to.p_odom - from.p_odom - from.v_odom * t - 0.5 * t * t * from.gravity_odom);
  const Vector3d sped_up = Rt * (to.v_odom - from.v_odom - t * from.gravity_odom);
  const Matrix3d R_error = delta.R.transpose() * Rt * to.R_odom_imu;
  const Vector3d turned = math::so3_log(R_error);
  const Matrix3d Jr_inverse = math::so3_right_jacobian_inverse(turned);

  MotionResidual m;
  m.r << turned, moved - delta.p, sped_up - delta.v;
  m.J_from.block<3, 3>(kRotation, kRotation) = -Jr_inverse * to.R_odom_imu.transpose() * from.R_odom_imu;
  m.J_from.block<3, 3>(kPosition, kRotation) = math::skew(moved);
  m.J_from.block<3, 3>(kVelocity, kRotation) = math::skew(sped_up);
  m.J_from.block<3, 3>(kPosition, kPosition) = -Rt;
  m.J_from.block<3, 3>(kPosition, kVelocity) = -Rt * t;
  m.J_from.block<3, 3>(kVelocity, kVelocity) = -Rt;
  m.J_to.block<3, 3>(kRotation, kRotation) = Jr_inverse;
  m.J_to.block<3, 3>(kPosition, kPosition) = Rt;
  m.J_to.block<3, 3>(kVelocity, kVelocity) = Rt;
  m.J_shared << -motion.bias_jacobian, Eigen::Matrix<double, kNodeSize, 3>::Zero();
  const Vector3d correction = motion.bias_jacobian.block<3, 3>(kRotation, 0) * (bias.gyro - motion.bias.gyro);
  m.J_shared.block<3, 3>(kRotation, kSharedGyro) = -Jr_inverse * R_error.transpose() *
                                                   math::so3_right_jacobian(correction) *
                                                   motion.bias_jacobian.block<3, 3>(kRotation, 0);
  m.J_shared.block<3, 3>(kPosition, kSharedGravity) = -0.5 * t * t * Rt;
  m.J_shared.block<3, 3>(kVelocity, kSharedGravity) = -t * Rt;
  return m;
}

void add_motion(Linearised& sum, std::size_t k, const MotionResidual& m, const NodeMatrix& W) {
  ArrowSystem& s = sum.system;
  const NodeMatrix WJ_from = W * m.J_from;
  const NodeMatrix WJ_to = W * m.J_to;
  const Eigen::Matrix<double, kNodeSize, kFreeGravity> WJ_shared = W * m.J_shared;
  const NodeVector Wr = W * m.r;
  s.diagonal[k].noalias() += m.J_from.transpose() * WJ_from;
  s.diagonal[k + 1].noalias() += m.J_to.transpose() * WJ_to;
  s.next[k].noalias() += m.J_from.transpose() * WJ_to;
  s.border[k].noalias() += m.J_from.transpose() * WJ_shared;
  s.border[k + 1].noalias() += m.J_to.transpose() * WJ_shared;
  s.shared.noalias() += m.J_shared.transpose() * WJ_shared;
  s.b[k].noalias() -= m.J_from.transpose() * Wr;
  s.b[k + 1].noalias() -= m.J_to.transpose() * Wr;
  s.b_shared.noalias() -= m.J_shared.transpose() * Wr;
  sum.cost += m.r.dot(Wr);
}

/// Eq. (11).
void add_pose(Linearised& sum, std::size_t k, const PoseMeasurement& pose, const imu::NavState& state) {
  math::Vector6d r;
  r << math::so3_log(Matrix3d(pose.T_odom_imu.R.transpose() * state.R_odom_imu)),
      state.p_odom - pose.T_odom_imu.t;
  math::Matrix6d J = math::Matrix6d::Identity();
  J.topLeftCorner<3, 3>() = math::so3_right_jacobian_inverse(r.head<3>());
  const math::Matrix6d WJ = pose.information * J;
  sum.system.diagonal[k].topLeftCorner<6, 6>() += J.transpose() * WJ;
  sum.system.b[k].head<6>() -= WJ.transpose() * r;
  sum.cost += r.dot(pose.information * r);
}

/// Eq. (12).
void add_prior(Linearised& sum, const imu::NavState& first, const imu::NavState& prior,
               const PriorMatrix& W) {
  const Eigen::Matrix<double, kPriorSize, 1> r = imu::minus(first, prior).tail<kPriorSize>();
  const PriorMatrix J = imu::minus_jacobian(first, prior).bottomRightCorner<kPriorSize, kPriorSize>();
  const PriorMatrix H = J.transpose() * W * J;
  const Eigen::Matrix<double, kPriorSize, 1> b = J.transpose() * (W * r);
  sum.system.diagonal[0].bottomRightCorner<3, 3>() += H.topLeftCorner<3, 3>();
  sum.system.border[0].bottomRows<3>() += H.topRightCorner<3, kDirectedGravity>();
  sum.system.shared += H.bottomRightCorner<kDirectedGravity, kDirectedGravity>();
  sum.system.b[0].tail<3>() -= b.head<3>();
  sum.system.b_shared -= b.tail<kDirectedGravity>();
  sum.cost += r.dot(W * r);
}

int rank_of(const Eigen::MatrixXd& information) {
  // Relative to the scales of its own unknowns, which differ by many orders of magnitude.
  Eigen::VectorXd scale = information.diagonal();
  for (double& s : scale) s = s > 0.0 ? 1.0 / std::sqrt(s) : 0.0;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled, Eigen::EigenvaluesOnly);
  return static_cast<int>((eigen.eigenvalues().array() > 1e-10).count());
}

}  // namespace

WindowProblem::WindowProblem(const Window& window, const StatePrior& prior)
    : poses_(window.poses), prior_(prior.state) {
  for (std::size_t k = 0; k + 1 < poses_.size(); ++k) {
    motions_.push_back(imu::preintegrate(window.samples, {poses_[k].time, poses_[k + 1].time},
                                         {prior_.gyro_bias, prior_.accel_bias}, window.noise));
    const NodeMatrix P = motions_.back().covariance + kRounding * kRounding * NodeMatrix::Identity();
    motion_information_.push_back(P.llt().solve(NodeMatrix::Identity()));
  }
}

States WindowProblem::guess() const {
  States states(poses_.size(), prior_);
  const std::size_t last = poses_.size() - 1;
  for (std::size_t k = 0; k <= last; ++k) {
    const PoseMeasurement& before = poses_[k > 0 ? k - 1 : 0];
    const PoseMeasurement& after = poses_[std::min(k + 1, last)];
    states[k].time = poses_[k].time;
    states[k].R_odom_imu = poses_[k].T_odom_imu.R;
    states[k].p_odom = poses_[k].T_odom_imu.t;
    states[k].v_odom = (after.T_odom_imu.t - before.T_odom_imu.t) / to_seconds(after.time - before.time);
  }
  return states;
}

Linearised WindowProblem::linearise_measurements(const States& states) const {
  Linearised sum{ArrowSystem(states.size(), kFreeGravity)};
  for (std::size_t k = 0; k < poses_.size(); ++k) add_pose(sum, k, poses_[k], states[k]);
  for (std::size_t k = 0; k < motions_.size(); ++k) {
    add_motion(sum, k, motion_residual(motions_[k], states[k], states[k + 1]), motion_information_[k]);
  }
  return sum;
}

Linearised WindowProblem::linearise_free(const States& states, const math::Matrix6d& bias_information) const {
  Linearised sum = linearise_measurements(states);
  math::Vector6d r;
  r << states[0].gyro_bias - prior_.gyro_bias, states[0].accel_bias - prior_.accel_bias;
  sum.system.shared.topLeftCorner<6, 6>() += bias_information;
  sum.system.b_shared.head<6>() -= bias_information * r;
  sum.cost += r.dot(bias_information * r);
  return sum;
}

Linearised WindowProblem::linearise(const States& states, const PriorMatrix& prior_information) const {
  const Linearised free = linearise_measurements(states);
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(kFreeGravity, kDirectedGravity);
  T.bottomRightCorner<3, 2>() = math::sphere_plus_jacobian(states[0].gravity_odom);
  Linearised sum{with_shared(free.system, T), free.cost};
  add_prior(sum, states[0], prior_, prior_information);
  return sum;
}

int WindowProblem::degrees_of_freedom(const PriorMatrix& prior_information) const {
  int squares = rank_of(prior_information) + kNodeSize * static_cast<int>(motions_.size());
  for (const PoseMeasurement& pose : poses_) squares += rank_of(pose.information);
  return squares - kNodeSize * static_cast<int>(poses_.size()) - kDirectedGravity;
}

double WindowProblem::longest_imu_step() const {
  double longest = 0.0;
  for (const auto& motion : motions_) longest = std::max(longest, motion.longest_step);
  return longest;
}

PriorMatrix marginalised(const PriorMatrix& information, int first, int count) {
  PriorMatrix result = information;
  const Eigen::MatrixXd block = information.block(first, first, count, count);
  if (block.diagonal().minCoeff() > 0.0) {
    const Eigen::MatrixXd rows = information.middleRows(first, count);
    result -= rows.transpose() * block.ldlt().solve(rows);
  }
  result.middleRows(first, count).setZero();
  result.middleCols(first, count).setZero();
  return result;
}

}  // namespace mmlins::initialization

// SPDX-License-Identifier: MIT
#include "mmlins/initialization/paper_initializer.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace mmlins::initialization {
namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr std::size_t kFrames = 4;     // the paper's "at least four frames"
constexpr int kGravityIterations = 4;  // as VINS-Mono, which the paper follows here

using Motions = std::vector<imu::Preintegration>;

Motions integrate_between(const Window& window, const Vector3d& gyro_bias) {
  Motions motions;
  for (std::size_t i = 0; i + 1 < window.poses.size(); ++i) {
    motions.push_back(imu::preintegrate(window.samples, {window.poses[i].time, window.poses[i + 1].time},
                                        {gyro_bias, Vector3d::Zero()}, window.noise));
  }
  return motions;
}

/// The paper's equation (4): the bias that takes the least rotation out of q_{i+1}^-1 q_i gamma(b).
/// The sum runs over the three pairs of four frames, where the paper writes i = 0..3.
Vector3d gyro_bias_from_rotations(const PoseMeasurements& poses, const Motions& motions) {
  Matrix3d H = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (std::size_t i = 0; i < motions.size(); ++i) {
    // Second line of (4): gamma(b) ~ gamma [1, J b / 2]; half of J b is the vector part of gamma^-1 q_i^-1
    // q_{i+1}.
    const Matrix3d J = motions[i].bias_jacobian.topLeftCorner<3, 3>();
    const Matrix3d R_i_next = poses[i].T_odom_imu.R.transpose() * poses[i + 1].T_odom_imu.R;
    const Eigen::Quaterniond q(Matrix3d(motions[i].delta.R.transpose() * R_i_next));
    H += J.transpose() * J;
    right += J.transpose() * (2.0 * (q.w() < 0.0 ? -1.0 : 1.0) * q.vec());
  }
  return H.ldlt().solve(right);
}

/// Rows of the paper's equations (6)-(8), with x of (5) = [v_0, ..., v_n, g], all in the frame of the poses.
struct LinearSystem {
  Eigen::MatrixXd H;
  Eigen::VectorXd z;
};

LinearSystem translations_and_velocities(const PoseMeasurements& poses, const Motions& motions) {
  const auto pairs = static_cast<Eigen::Index>(motions.size());
  const Eigen::Index gravity = 3 * (pairs + 1);
  LinearSystem system{Eigen::MatrixXd::Zero(6 * pairs, gravity + 3), Eigen::VectorXd::Zero(6 * pairs)};
  for (Eigen::Index i = 0; i < pairs; ++i) {
    const imu::Preintegration& motion = motions[static_cast<std::size_t>(i)];
    const math::SE3& from = poses[static_cast<std::size_t>(i)].T_odom_imu;
    const math::SE3& to = poses[static_cast<std::size_t>(i) + 1].T_odom_imu;
    const Matrix3d Rt = from.R.transpose();  // the paper's q_L^{I_i}
    const double t = motion.seconds();
    // First lines of (6), (7) and (8): alpha = R_i^T (p_{i+1} - p_i - v_i t - g t^2 / 2).
    system.z.segment<3>(6 * i) = motion.delta.p - Rt * (to.t - from.t);
    system.H.block<3, 3>(6 * i, 3 * i) = -t * Rt;
    system.H.block<3, 3>(6 * i, gravity) = -0.5 * t * t * Rt;
    // Second lines: beta = R_i^T (v_{i+1} - v_i - g t).
    system.z.segment<3>(6 * i + 3) = motion.delta.v;
    system.H.block<3, 3>(6 * i + 3, 3 * i) = -Rt;
    system.H.block<3, 3>(6 * i + 3, 3 * i + 3) = Rt;
    system.H.block<3, 3>(6 * i + 3, gravity) = -t * Rt;
  }
  return system;
}

/// "We refine the gravitational acceleration [...] by constraining its magnitude": g = G (d + B w), solved
/// for w and the velocities, the normal equations made anew each time.
Eigen::VectorXd with_gravity_of_known_length(const LinearSystem& system, const Eigen::VectorXd& x) {
  const Eigen::Index n = x.size() - 3;
  Vector3d gravity = imu::kGravity * x.tail<3>().normalized();
  Eigen::VectorXd velocities = x.head(n);
  for (int iteration = 0; iteration < kGravityIterations; ++iteration) {
    const math::Matrix32d B = imu::kGravity * math::sphere_basis(gravity);
    Eigen::MatrixXd H(system.H.rows(), n + 2);
    H << system.H.leftCols(n), system.H.rightCols<3>() * B;
    const Eigen::VectorXd y = H.householderQr().solve(system.z - system.H.rightCols<3>() * gravity);
    velocities = y.head(n);
    gravity = imu::kGravity * (gravity + B * y.tail<2>()).normalized();
  }
  Eigen::VectorXd result(x.size());
  result << velocities, gravity;
  return result;
}

/// Initial variances of FAST-LIO2: one where it knows nothing. The pose is right by choice here.
imu::ErrorMatrix first_covariance() {
  imu::ErrorVector variance;
  variance << Eigen::Matrix<double, 6, 1>::Constant(1e-10), Vector3d::Constant(1.0), Vector3d::Constant(1e-4),
      Vector3d::Constant(1e-3), Eigen::Vector2d::Constant(1e-5);
  return variance.asDiagonal();
}

}  // namespace

PaperSolution solve_paper(const Window& window) {
  PaperSolution result;
  if (window.poses.size() < kFrames) return result;
  result.status = PaperStatus::kNoImu;
  if (window.samples.empty()) return result;

  result.gyro_bias = gyro_bias_from_rotations(window.poses, integrate_between(window, Vector3d::Zero()));
  // "Re-propagate IMU pre-integration using b_w solved above."
  const LinearSystem system =
      translations_and_velocities(window.poses, integrate_between(window, result.gyro_bias));
  // The paper's equation (9).
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(system.H);
  const Eigen::VectorXd x = qr.solve(system.z);
  result.status = PaperStatus::kSingular;
  if (qr.rank() < system.H.cols() || !x.allFinite() || x.tail<3>().norm() == 0.0) return result;
  result.gravity_norm = x.tail<3>().norm();

  const Eigen::VectorXd refined = with_gravity_of_known_length(system, x);
  result.gravity_odom = refined.tail<3>();
  for (Eigen::Index i = 0; i + 3 < refined.size(); i += 3) result.v_odom.emplace_back(refined.segment<3>(i));
  imu::NavState& state = result.estimate.state;
  state.time = window.poses.back().time;
  state.R_odom_imu = window.poses.back().T_odom_imu.R;
  state.p_odom = window.poses.back().T_odom_imu.t;
  state.v_odom = result.v_odom.back();
  state.gyro_bias = result.gyro_bias;
  state.gravity_odom = result.gravity_odom;
  result.estimate.P = first_covariance();
  result.status = PaperStatus::kSolved;
  return result;
}

math::Trajectory imu_motion(const math::Trajectory& T_first_lidar, const math::SE3& T_imu_lidar) {
  math::Trajectory result;
  for (const auto& stamped : T_first_lidar) {
    result.push_back({stamped.time, T_imu_lidar * stamped.pose * T_imu_lidar.inverse()});
  }
  return result;
}

}  // namespace mmlins::initialization

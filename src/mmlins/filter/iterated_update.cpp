// SPDX-License-Identifier: MIT
#include "mmlins/filter/iterated_update.hpp"

#include <Eigen/LU>

namespace mmlins::filter {

using imu::ErrorMatrix;
using imu::ErrorVector;
using math::Matrix6d;
using math::Vector6d;

PoseInformation& PoseInformation::operator+=(const PoseInformation& other) {
  H += other.H;
  b += other.b;
  cost += other.cost;
  num_residuals += other.num_residuals;
  return *this;
}

namespace {

struct Step {
  ErrorVector d;
  ErrorMatrix P;  ///< posterior in the tangent of the iterate
};

/// One Gauss-Newton step. Only six columns of the state are measured, so a 6x6 system is all there is to
/// solve, and the prior covariance is never inverted: it may be singular. Eqs. (11)-(13).
Step gauss_newton_step(const ErrorMatrix& P_bar, const ErrorVector& d_prior, const PoseInformation& information) {
  const Eigen::Matrix<double, imu::kErrorSize, 6> A = P_bar.leftCols<6>();
  const Matrix6d P_pose = P_bar.topLeftCorner<6, 6>();
  const Matrix6d M = Matrix6d::Identity() + P_pose * information.H;
  const Eigen::PartialPivLU<Matrix6d> lu(M);
  const Vector6d d_pose = lu.solve(-P_pose * information.b - d_prior.head<6>());
  Step step;
  step.d = -A * (information.b + information.H * d_pose) - d_prior;
  // H (I + P H)^-1, symmetric in exact arithmetic.
  const Matrix6d gain = information.H * lu.inverse();
  step.P = P_bar - A * gain * A.transpose();
  step.P = 0.5 * (step.P + step.P.transpose()).eval();
  return step;
}

}  // namespace

UpdateReport iterated_update(const imu::Estimate& prior, const MeasurementModel& measure, const UpdateLimits& limits,
                             const imu::NavState* start) {
  UpdateReport report;
  report.estimate = prior;
  imu::NavState x = start != nullptr ? *start : prior.state;
  ErrorMatrix P = prior.P;
  for (int iteration = 0; iteration < limits.max_iterations; ++iteration) {
    report.information = measure(x, P);
    report.linearised_at = x.T_odom_imu();
    if (report.information.num_residuals < limits.min_residuals) {
      report.status = UpdateStatus::kTooFewResiduals;
      report.estimate = prior;
      return report;
    }
    const ErrorMatrix L = imu::minus_jacobian(x, prior.state);
    const Eigen::PartialPivLU<ErrorMatrix> L_lu(L);
    const ErrorMatrix L_inverse = L_lu.inverse();
    const ErrorMatrix P_bar = L_inverse * prior.P * L_inverse.transpose();
    const ErrorVector d_prior = L_inverse * imu::minus(x, prior.state);
    const Step step = gauss_newton_step(P_bar, d_prior, report.information);
    const imu::NavState next = imu::plus(x, step.d);
    // The covariance moves along to the tangent of the new state. Eq. (14).
    const ErrorMatrix G = imu::minus_jacobian(next, x).inverse();
    x = next;
    P = G * step.P * G.transpose();
    report.iterations = iteration + 1;
    const bool converged = step.d.segment<3>(imu::kRotation).norm() < limits.rotation_tolerance &&
                           step.d.segment<3>(imu::kPosition).norm() < limits.position_tolerance;
    report.status = converged ? UpdateStatus::kConverged : UpdateStatus::kIterationLimit;
    if (converged) break;
  }
  report.estimate = {x, P};
  return report;
}

}  // namespace mmlins::filter

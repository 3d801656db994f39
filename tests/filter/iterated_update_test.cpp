// SPDX-License-Identifier: MIT
#include "mmlins/filter/iterated_update.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <vector>

#include "mmlins/sim/random.hpp"

namespace mmlins::filter {
namespace {

using imu::ErrorMatrix;
using imu::ErrorVector;
using imu::Estimate;
using imu::kErrorSize;
using imu::kPosition;
using imu::kRotation;
using imu::NavState;
using math::Matrix6d;
using math::Vector3d;
using math::Vector6d;

/// Iterates until nothing moves.
constexpr UpdateLimits kPatient{
    .max_iterations = 30, .min_residuals = 1, .rotation_tolerance = 1e-12, .position_tolerance = 1e-12};

NavState random_state(sim::Random& random) {
  NavState state;
  state.R_odom_imu = math::so3_exp(random.normal3());
  state.p_odom = 10.0 * random.normal3();
  state.v_odom = 3.0 * random.normal3();
  state.gyro_bias = 0.01 * random.normal3();
  state.accel_bias = 0.05 * random.normal3();
  return state;
}

/// Fully correlated, as after some propagation. `scale` is the deviation of every number.
ErrorMatrix random_covariance(sim::Random& random, double scale) {
  ErrorMatrix A;
  for (int i = 0; i < A.size(); ++i) A.data()[i] = random.normal();
  return scale * scale / kErrorSize * A * A.transpose();
}

ErrorVector draw(const ErrorMatrix& P, sim::Random& random) {
  ErrorVector white;
  for (int i = 0; i < kErrorSize; ++i) white(i) = random.normal();
  return Eigen::LLT<ErrorMatrix>(P).matrixL() * white;
}

/// Measures the position, with one information matrix.
MeasurementModel position_sensor(const Vector3d& measured, const Eigen::Matrix3d& information) {
  return [=](const NavState& state, const ErrorMatrix&) {
    PoseInformation result;
    const Vector3d r = state.p_odom - measured;
    result.H.bottomRightCorner<3, 3>() = information;
    result.b.tail<3>() = information * r;
    result.cost = r.dot(information * r);
    result.num_residuals = 100;
    return result;
  };
}

TEST(IteratedUpdate, OnALinearProblemItIsTheKalmanFilter) {
  sim::Random random(1);
  for (int run = 0; run < 10; ++run) {
    const Estimate prior{random_state(random), random_covariance(random, 0.3)};
    const Vector3d measured = prior.state.p_odom + 0.3 * random.normal3();
    Eigen::Matrix3d noise = Vector3d(0.1, 0.02, 0.5).cwiseAbs2().asDiagonal();
    const math::Matrix3d R = math::so3_exp(random.normal3());
    noise = R * noise * R.transpose();
    const UpdateReport report = iterated_update(prior, position_sensor(measured, noise.inverse()), kPatient);

    const Eigen::Matrix<double, kErrorSize, 3> PHt = prior.P.middleCols<3>(kPosition);
    const Eigen::Matrix3d S = prior.P.block<3, 3>(kPosition, kPosition) + noise;
    const Eigen::Matrix<double, kErrorSize, 3> K = PHt * S.inverse();
    const ErrorVector expected = K * (measured - prior.state.p_odom);
    const ErrorMatrix expected_P = prior.P - K * PHt.transpose();
    EXPECT_EQ(report.status, UpdateStatus::kConverged);
    // Matrices of size 17 with conditions of 1e4.
    EXPECT_LT((minus(report.estimate.state, prior.state) - expected).norm(), 1e-10) << run;
    // The textbook's covariance lives in the tangent of the prior, ours in that of the posterior.
    const ErrorMatrix L = minus_jacobian(report.estimate.state, prior.state);
    EXPECT_LT((L * report.estimate.P * L.transpose() - expected_P).norm(), 1e-10) << run;
  }
}

TEST(IteratedUpdate, AMeasurementThatSaysNothingKeepsThePrior) {
  sim::Random random(2);
  const Estimate prior{random_state(random), random_covariance(random, 0.3)};
  const auto silent = [](const NavState&, const ErrorMatrix&) {
    PoseInformation nothing;
    nothing.num_residuals = 100;
    return nothing;
  };
  const UpdateReport report = iterated_update(prior, silent, kPatient);
  EXPECT_EQ(report.status, UpdateStatus::kConverged);
  EXPECT_LT(minus(report.estimate.state, prior.state).norm(), 1e-14);
  EXPECT_LT((report.estimate.P - prior.P).norm(), 1e-13);
}

TEST(IteratedUpdate, TooFewResidualsLeaveThePriorUntouched) {
  sim::Random random(3);
  const Estimate prior{random_state(random), random_covariance(random, 0.3)};
  UpdateLimits limits = kPatient;
  limits.min_residuals = 101;
  const UpdateReport report =
      iterated_update(prior, position_sensor(Vector3d(100, 0, 0), Eigen::Matrix3d::Identity()), limits);
  EXPECT_EQ(report.status, UpdateStatus::kTooFewResiduals);
  EXPECT_EQ(report.iterations, 0);
  EXPECT_EQ(report.estimate.state.p_odom, prior.state.p_odom);
  EXPECT_EQ(report.estimate.P, prior.P);
}

TEST(IteratedUpdate, AMeasurementAlongOneDirectionLeavesTheOthersAsTheyWere) {
  sim::Random random(4);
  Estimate prior{random_state(random), ErrorMatrix::Identity()};
  const Vector3d along = Vector3d(1.0, 2.0, -0.5).normalized();
  const Vector3d measured = prior.state.p_odom + 0.7 * along + Vector3d(5.0, -2.5, 0.0);
  const UpdateReport report =
      iterated_update(prior, position_sensor(measured, 400.0 * along * along.transpose()), kPatient);
  const ErrorVector moved = minus(report.estimate.state, prior.state);
  const Vector3d moved_position = moved.segment<3>(kPosition);
  // 5 and -2.5 along x and y are at right angles to it; of 0.7 along it the prior keeps 1/401.
  EXPECT_NEAR(along.dot(moved_position), 0.7 * 400.0 / 401.0, 1e-12);
  EXPECT_LT((moved_position - along.dot(moved_position) * along).norm(), 1e-12);
  ErrorMatrix expected = ErrorMatrix::Identity();
  expected.block<3, 3>(kPosition, kPosition) -= 400.0 / 401.0 * along * along.transpose();
  EXPECT_LT((report.estimate.P - expected).norm(), 1e-12);
  EXPECT_LT(moved.norm() - moved_position.norm(), 1e-12);
}

TEST(IteratedUpdate, APriorThatIsCertainOfSomethingMayBeSingular) {
  sim::Random random(5);
  Estimate prior{random_state(random), random_covariance(random, 0.3)};
  for (const int known : {kPosition + 1, kRotation + 2, imu::kAccelBias}) {
    prior.P.row(known).setZero();
    prior.P.col(known).setZero();
  }
  const Vector3d measured = prior.state.p_odom + Vector3d(0.1, 0.2, 0.3);
  const UpdateReport report =
      iterated_update(prior, position_sensor(measured, 1e4 * Eigen::Matrix3d::Identity()), kPatient);
  EXPECT_EQ(report.status, UpdateStatus::kConverged);
  EXPECT_TRUE(report.estimate.P.allFinite());
  EXPECT_NEAR(report.estimate.state.p_odom.y(), prior.state.p_odom.y(), 1e-12);
  // The prior deviates by about 0.3 m, the measurement by 0.01 m.
  EXPECT_NEAR(report.estimate.state.p_odom.x(), measured.x(), 0.02);
}

/// Points of a room, as seen from a pose: six walls, a distance from which is measured for every point.
class Room {
 public:
  Room(const math::SE3& truth, double deviation) : weight_(1.0 / (deviation * deviation)) {
    sim::Random random(6);
    for (int i = 0; i < 300; ++i) {
      Vector3d p(random.uniform(-4, 4), random.uniform(-3, 3), random.uniform(-1.5, 1.5));
      const int axis = i % 3;
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      p(axis) = side * Vector3d(4.0, 3.0, 1.5)(axis);
      points_imu_.push_back(truth.inverse() * p);
      normals_.push_back(side * Vector3d::Unit(axis));
      offsets_.push_back(normals_.back().dot(p));
    }
  }
  PoseInformation operator()(const NavState& state, const ErrorMatrix&) const {
    PoseInformation sum;
    for (std::size_t i = 0; i < points_imu_.size(); ++i) {
      const double r = normals_[i].dot(state.T_odom_imu() * points_imu_[i]) - offsets_[i];
      Vector6d J;
      J << points_imu_[i].cross(state.R_odom_imu.transpose() * normals_[i]), normals_[i];
      sum.H += weight_ * J * J.transpose();
      sum.b += weight_ * r * J;
      sum.cost += weight_ * r * r;
      ++sum.num_residuals;
    }
    return sum;
  }

 private:
  double weight_;
  std::vector<Vector3d> points_imu_;
  std::vector<Vector3d> normals_;
  std::vector<double> offsets_;
};

TEST(IteratedUpdate, ConvergesToTheTruthFromAWrongPrior) {
  const math::SE3 truth{math::so3_exp({0.1, -0.2, 2.0}), {0.5, -0.8, 0.2}};
  NavState guess;
  guess.R_odom_imu = truth.R * math::so3_exp({0.2, 0.15, -0.3});
  guess.p_odom = truth.t + Vector3d(0.6, -0.5, 0.3);
  const UpdateReport report = iterated_update({guess, ErrorMatrix::Identity()}, Room(truth, 1e-4), kPatient);
  EXPECT_EQ(report.status, UpdateStatus::kConverged);
  EXPECT_LE(report.iterations, 12);
  // The prior is wrong by 0.9 and pulls with a weight of 1 against at least 100 residuals of weight 1e8.
  EXPECT_LT((report.estimate.state.p_odom - truth.t).norm(), 1e-8);
  EXPECT_LT((report.estimate.state.R_odom_imu - truth.R).norm(), 1e-8);
  EXPECT_LT(report.information.cost, 1e-4);
}

TEST(IteratedUpdate, FindsTheMinimumOfPriorAndMeasurementTogether) {
  // A prior as strong as the measurement, off by much: the answer lies between the two, and there the
  // gradient of the sum of both vanishes. That needs the prior's term of the iterated filter.
  sim::Random random(7);
  const math::SE3 truth{math::so3_exp({0.1, -0.2, 2.0}), {0.5, -0.8, 0.2}};
  Estimate prior;
  prior.state.R_odom_imu = truth.R * math::so3_exp({0.2, 0.15, -0.3});
  prior.state.p_odom = truth.t + Vector3d(0.3, -0.2, 0.3);
  prior.P = random_covariance(random, 0.3) + 1e-3 * ErrorMatrix::Identity();
  const Room room(truth, 1.0);
  const ErrorMatrix information = prior.P.inverse();
  const auto cost = [&](const NavState& state) {
    const ErrorVector e = minus(state, prior.state);
    return e.dot(information * e) + room(state, prior.P).cost;
  };
  const NavState found = iterated_update(prior, room, kPatient).estimate.state;
  const double step = 1e-4;
  for (int i = 0; i < kErrorSize; ++i) {
    const ErrorVector d = step * ErrorVector::Unit(i);
    const double forward = cost(imu::plus(found, d));
    const double backward = cost(imu::plus(found, -d));
    // Half the curvature along this number scales what its gradient may be.
    const double curvature = (forward + backward - 2.0 * cost(found)) / (step * step);
    EXPECT_LT(std::abs(forward - backward) / (2.0 * step), 1e-5 * curvature) << i;
  }
}

TEST(IteratedUpdate, PosteriorIsSymmetricAndPositiveHoweverStrongTheMeasurement) {
  sim::Random random(8);
  const math::SE3 truth{math::so3_exp({0.1, -0.2, 2.0}), {0.5, -0.8, 0.2}};
  for (const double deviation : {10.0, 0.1, 1e-3, 1e-5}) {
    for (const double scale : {1.0, 1e-3}) {
      const ErrorMatrix P = random_covariance(random, scale);
      NavState start;
      start.R_odom_imu = truth.R;
      start.p_odom = truth.t;
      const Estimate prior{imu::plus(start, 0.1 * draw(P, random)), P};
      const ErrorMatrix posterior = iterated_update(prior, Room(truth, deviation), {}).estimate.P;
      EXPECT_LT((posterior - posterior.transpose()).norm(), 1e-14 * posterior.norm());
      const ErrorVector eigenvalues = Eigen::SelfAdjointEigenSolver<ErrorMatrix>(posterior).eigenvalues();
      // Rounding of the prior's largest variance.
      EXPECT_GT(eigenvalues(0), -1e-13 * P.norm()) << deviation << ' ' << scale;
      // No measurement makes the state less certain.
      const ErrorVector before = prior.P.diagonal();
      for (int i = kPosition; i < imu::kGravityDirection; ++i)
        EXPECT_LE(posterior(i, i), before(i) * (1.0 + 1e-9));
    }
  }
}

TEST(IteratedUpdate, CovarianceIsThatOfTheErrorsOverManyPriors) {
  // Errors drawn from the prior's covariance, measurements with the declared noise: the posterior's
  // covariance must be that of what remains.
  sim::Random random(9);
  const ErrorMatrix P = random_covariance(random, 0.05) + 1e-6 * ErrorMatrix::Identity();
  const Eigen::Matrix3d noise = Vector3d(0.02, 0.05, 0.01).cwiseAbs2().asDiagonal();
  constexpr int kRuns = 2000;
  double sum = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const Estimate prior{random_state(random), P};
    const NavState truth = imu::plus(prior.state, draw(P, random));
    const Vector3d measured = truth.p_odom + noise.cwiseSqrt() * random.normal3();
    const Estimate posterior =
        iterated_update(prior, position_sensor(measured, noise.inverse()), {}).estimate;
    const ErrorVector error = minus(truth, posterior.state);
    sum += error.dot(posterior.P.ldlt().solve(error)) / kErrorSize;
  }
  // A mean of n * 17 squares of normal numbers deviates by sqrt(2 / 17n) = 0.8 %; five times that.
  EXPECT_NEAR(sum / kRuns, 1.0, 0.04);
}

}  // namespace
}  // namespace mmlins::filter

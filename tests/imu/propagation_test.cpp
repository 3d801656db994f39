// SPDX-License-Identifier: MIT
#include "mmlins/imu/propagation.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <vector>

#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::imu {
namespace {

const Time kStart = time_from_ns(1700000000000000000);
// Central differences with step 1e-6 on numbers of size ten: truncation 1e-12, rounding 1e-15 / 1e-6.
constexpr double kNumerical = 1e-7;

NavState random_state(sim::Random& random) {
  NavState state;
  state.time = kStart;
  state.R_odom_imu = math::so3_exp(random.normal3());
  state.p_odom = 10.0 * random.normal3();
  state.v_odom = 3.0 * random.normal3();
  state.gyro_bias = 0.1 * random.normal3();
  state.accel_bias = 0.5 * random.normal3();
  state.gravity_odom = kGravity * random.normal3().normalized();
  return state;
}

/// Samples of a lively motion at uneven intervals.
sensor::ImuSamples random_samples(sim::Random& random, int count) {
  sensor::ImuSamples samples;
  Time time = kStart;
  for (int i = 0; i < count; ++i) {
    samples.push_back({time, 2.0 * random.normal3(), 5.0 * random.normal3()});
    time += from_seconds(random.uniform(0.001, 0.02));
  }
  return samples;
}

TEST(Propagation, TransitionMatchesNumericalDifferentiationOfTheIntegration) {
  sim::Random random(1);
  for (const double dt : {0.001, 0.005, 0.05, 0.2}) {
    for (const double rate : {0.0, 0.5, 5.0}) {
      const NavState state = random_state(random);
      const ImuStep step{dt, rate * random.normal3() + state.gyro_bias, 10.0 * random.normal3()};
      const NavState next = integrate(state, step);
      const auto f = [&](const Eigen::VectorXd& error) -> Eigen::VectorXd {
        return minus(integrate(plus(state, error), step), next);
      };
      const Eigen::MatrixXd numerical = math::numerical_jacobian(f, Eigen::VectorXd::Zero(kErrorSize));
      const Eigen::MatrixXd difference = transition(state, step) - numerical;
      for (int column = 0; column < kErrorSize; ++column) {
        EXPECT_LT(difference.col(column).cwiseAbs().maxCoeff(), kNumerical)
            << "column " << column << ", " << dt << " s, " << rate << " rad/s";
      }
    }
  }
}

TEST(Propagation, ConstantForceGivesTheParabolaOfSchool) {
  NavState state;
  state.time = kStart;
  state.v_odom = {1.0, -2.0, 0.5};
  const Vector3d accel_odom(0.3, 0.2, -0.1);
  sensor::ImuSamples samples;
  for (int i = 0; i <= 200; ++i) {
    samples.push_back(
        {kStart + from_seconds(0.01 * i), Vector3d::Zero(), accel_odom + Vector3d(0, 0, kGravity)});
  }
  const NavState end = propagate({state, ErrorMatrix::Zero()}, samples, {}).estimate.state;
  EXPECT_EQ(end.time, samples.back().time);
  // Sums of 200 terms of size one.
  EXPECT_LT((end.v_odom - (state.v_odom + 2.0 * accel_odom)).norm(), 1e-12);
  EXPECT_LT((end.p_odom - (2.0 * state.v_odom + 2.0 * accel_odom)).norm(), 1e-12);
}

TEST(Propagation, BiasesAreTakenOffTheReadings) {
  NavState state;
  state.time = kStart;
  state.gyro_bias = {0.1, -0.2, 0.3};
  state.accel_bias = {-0.5, 0.4, 0.2};
  const sensor::ImuSample at_rest{kStart, state.gyro_bias, state.accel_bias + Vector3d(0, 0, kGravity)};
  sensor::ImuSample later = at_rest;
  later.time += from_seconds(1.0);
  const NavState end = propagate({state, ErrorMatrix::Zero()}, {at_rest, later}, {}).estimate.state;
  EXPECT_LT((end.R_odom_imu - Matrix3d::Identity()).norm(), 1e-14);
  EXPECT_LT(end.v_odom.norm(), 1e-14);
}

TEST(Propagation, ReturnsThePoseAtEverySample) {
  sim::Random random(2);
  const sensor::ImuSamples samples = random_samples(random, 20);
  const Propagation motion = propagate({random_state(random), ErrorMatrix::Identity()}, samples, {});
  ASSERT_EQ(motion.T_odom_imu.size(), samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(motion.T_odom_imu[i].time, samples[i].time);
  EXPECT_EQ(motion.T_odom_imu.back().pose.t, motion.estimate.state.p_odom);
  EXPECT_EQ(motion.T_odom_imu.back().pose.R, motion.estimate.state.R_odom_imu);
}

// The covariance promises the mean square of the errors. A sensor with exactly the declared densities is
// simulated a few hundred times, and the errors are compared with the promise.
constexpr int kRuns = 400;
constexpr double kSeconds = 1.0;
constexpr double kRate = 100.0;
const ImuNoise kNoise{0.004, 0.03, 0.002, 0.02};

/// What an ideal IMU reads on a motion that turns and pushes about all axes.
sensor::ImuSamples ideal_samples() {
  sensor::ImuSamples samples;
  for (int i = 0; i <= static_cast<int>(kSeconds * kRate); ++i) {
    const double t = i / kRate;
    samples.push_back({kStart + from_seconds(t), Vector3d(0.8, -0.5 * std::cos(t), 1.2),
                       Vector3d(std::sin(3.0 * t), 2.0, kGravity)});
  }
  return samples;
}

ErrorMatrix start_covariance() {
  ErrorVector sigma;
  sigma << Vector3d::Constant(2e-3), Vector3d::Constant(5e-3), Vector3d::Constant(0.01),
      Vector3d::Constant(1e-3), Vector3d::Constant(0.01), Eigen::Vector2d::Constant(2e-3);
  return sigma.cwiseAbs2().asDiagonal();
}

/// The true state at the end minus the estimated one, and what the filter says about it.
struct Outcome {
  ErrorVector error;
  ErrorMatrix P;
};

Outcome run_once(sim::Random& random) {
  NavState guess;
  guess.time = kStart;
  const ErrorMatrix P = start_covariance();
  ErrorVector error;
  for (int i = 0; i < kErrorSize; ++i) error(i) = std::sqrt(P(i, i)) * random.normal();
  NavState truth = plus(guess, error);
  const sensor::ImuSamples ideal = ideal_samples();
  sensor::ImuSamples noisy = ideal;
  const double per_sample = std::sqrt(kRate);  // from a density to one sample's deviation
  const double per_step = std::sqrt(1.0 / kRate);
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    if (i > 0) {
      truth.gyro_bias += kNoise.gyro_bias_walk * per_step * random.normal3();
      truth.accel_bias += kNoise.accel_bias_walk * per_step * random.normal3();
    }
    noisy[i].gyro += truth.gyro_bias + kNoise.gyro * per_sample * random.normal3();
    noisy[i].accel += truth.accel_bias + kNoise.accel * per_sample * random.normal3();
  }
  NavState unbiased = truth;
  unbiased.gyro_bias.setZero();
  unbiased.accel_bias.setZero();
  NavState end = propagate({unbiased, P}, ideal, {}).estimate.state;
  end.gyro_bias = truth.gyro_bias;
  end.accel_bias = truth.accel_bias;
  const Estimate estimate = propagate({guess, P}, noisy, kNoise).estimate;
  return {minus(end, estimate.state), estimate.P};
}

TEST(Propagation, CovarianceIsThatOfTheErrorsOfManyNoisyRuns) {
  sim::Random random(4);
  ErrorMatrix sum = ErrorMatrix::Zero();  // of whitened errors: n times the identity if P is right
  for (int run = 0; run < kRuns; ++run) {
    const Outcome outcome = run_once(random);
    const ErrorVector whitened = Eigen::LLT<ErrorMatrix>(outcome.P).matrixL().solve(outcome.error);
    sum += whitened * whitened.transpose();
  }
  const ErrorMatrix mean = sum / kRuns;
  // A mean of n squares of normal numbers deviates by sqrt(2/n), one of n products by sqrt(1/n); the largest
  // of 153 such numbers stays below 5 deviations but for one seed in ten thousand.
  for (int i = 0; i < kErrorSize; ++i) {
    EXPECT_NEAR(mean(i, i), 1.0, 5.0 * std::sqrt(2.0 / kRuns)) << i;
    for (int j = 0; j < i; ++j) EXPECT_NEAR(mean(i, j), 0.0, 5.0 * std::sqrt(1.0 / kRuns)) << i << ' ' << j;
  }
  EXPECT_NEAR(mean.trace() / kErrorSize, 1.0, 5.0 * std::sqrt(2.0 / (kErrorSize * kRuns)));
}

TEST(Propagation, APauseIsNotTakenForMotion) {
  sim::Random random(6);
  NavState state = random_state(random);
  state.v_odom = {3.0, 0.0, 0.0};
  const sensor::ImuSample before{kStart, {1.0, 0.0, 0.0}, {0.0, 5.0, 0.0}};
  sensor::ImuSample later = before;
  later.time += from_seconds(100.0);
  const Estimate start{state, start_covariance()};
  const Estimate end = propagate(start, {before, later}, kNoise).estimate;
  EXPECT_EQ(end.state.time, later.time);
  EXPECT_EQ(end.state.p_odom, state.p_odom);
  EXPECT_EQ(end.state.v_odom, state.v_odom);
  EXPECT_EQ(end.state.R_odom_imu, state.R_odom_imu);
  for (int i = kRotation; i < kGyroBias; ++i) EXPECT_GT(end.P(i, i), start.P(i, i) + 0.01) << i;
}

TEST(Propagation, NoiseOfTwoHalfStepsIsNearlyThatOfTheWhole) {
  // Nothing turns and nothing pushes, so that a step's length does not matter to the motion.
  const NavState state;
  const ImuStep whole{0.02, Vector3d::Zero(), Vector3d(0, 0, kGravity)};
  ImuStep half = whole;
  half.dt = 0.01;
  const ErrorMatrix F = transition(state, half);
  const ErrorMatrix twice = F * step_noise(half, kNoise) * F.transpose() + step_noise(half, kNoise);
  const ErrorMatrix once = step_noise(whole, kNoise);
  // Rotation, velocity, position and biases are exact; what the biases leak into them is of higher order.
  for (int i = 0; i < kErrorSize; ++i) {
    const double tolerance = i < kGyroBias ? 0.01 * once(i, i) : 1e-12 * once(i, i);
    EXPECT_NEAR(twice(i, i), once(i, i), tolerance) << i;
  }
}

}  // namespace
}  // namespace mmlins::imu

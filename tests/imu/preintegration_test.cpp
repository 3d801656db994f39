// SPDX-License-Identifier: MIT
#include "mmlins/imu/preintegration.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/math/random.hpp"
#include "mmlins/sensor/imu_buffer.hpp"

namespace mmlins::imu {
namespace {

const Time kStart = time_from_ns(1700000000000000000);
// Sums of some fifty numbers of size ten.
constexpr double kRounding = 1e-12;

Time at(double seconds) { return kStart + from_seconds(seconds); }

sensor::ImuSample silent(double seconds) { return {at(seconds), Vector3d::Zero(), Vector3d::Zero()}; }

/// Samples of a lively motion at uneven intervals, for about `seconds`.
sensor::ImuSamples lively_samples(std::uint64_t seed, double seconds) {
  math::Random random(seed);
  sensor::ImuSamples samples;
  for (double t = 0.0; t < seconds; t += random.uniform(0.002, 0.012)) {
    samples.push_back({at(t), 1.5 * random.normal3(), 5.0 * random.normal3()});
  }
  return samples;
}

NavState some_state(Time time) {
  math::Random random(5);
  NavState state;
  state.time = time;
  state.R_odom_imu = math::so3_exp(random.normal3());
  state.p_odom = 5.0 * random.normal3();
  state.v_odom = 3.0 * random.normal3();
  state.gyro_bias = 0.05 * random.normal3();
  state.accel_bias = 0.3 * random.normal3();
  state.gravity_odom = kGravity * random.normal3().normalized();
  return state;
}

/// The delta as vector [rotation, position, velocity] against another.
Eigen::VectorXd difference(const ImuDelta& a, const ImuDelta& base) {
  Eigen::VectorXd d(9);
  d << math::so3_log(Matrix3d(base.R.transpose() * a.R)), a.p - base.p, a.v - base.v;
  return d;
}

TEST(Preintegration, WithGravityAndTheFirstStateItGivesWhatPropagationGives) {
  const sensor::ImuSamples samples = lively_samples(1, 0.6);
  sensor::ImuBuffer buffer;
  for (const auto& sample : samples) ASSERT_EQ(buffer.add(sample), sensor::ImuAdmission::kAccepted);
  // Both ends between samples, and both at samples.
  for (const TimeSpan& span :
       {TimeSpan{at(0.1234), at(0.4321)}, TimeSpan{samples[3].time, samples[40].time}}) {
    const NavState begin = some_state(span.begin);
    const NavState end =
        propagate({begin, ErrorMatrix::Zero()}, buffer.covering(span.begin, span.end), {}).estimate.state;
    const Preintegration motion = preintegrate(samples, span, {begin.gyro_bias, begin.accel_bias}, {});
    const double t = motion.seconds();
    EXPECT_LT((begin.R_odom_imu * motion.delta.R - end.R_odom_imu).norm(), kRounding);
    EXPECT_LT((begin.v_odom + begin.gravity_odom * t + begin.R_odom_imu * motion.delta.v - end.v_odom).norm(),
              kRounding);
    EXPECT_LT((begin.p_odom + begin.v_odom * t + 0.5 * t * t * begin.gravity_odom +
               begin.R_odom_imu * motion.delta.p - end.p_odom)
                  .norm(),
              kRounding);
  }
}

TEST(Preintegration, BiasJacobianMatchesNumericalDifferentiation) {
  const sensor::ImuSamples samples = lively_samples(2, 0.5);
  const TimeSpan span{at(0.05), at(0.41)};
  const ImuBias bias{{0.02, -0.03, 0.01}, {0.1, 0.2, -0.3}};
  const Preintegration motion = preintegrate(samples, span, bias, {});
  const auto f = [&](const Eigen::VectorXd& d) {
    const ImuBias other{bias.gyro + d.head<3>(), bias.accel + d.tail<3>()};
    return difference(preintegrate(samples, span, other, {}).delta, motion.delta);
  };
  const Eigen::MatrixXd numerical = math::numerical_jacobian(f, Eigen::VectorXd::Zero(6));
  // Central differences with step 1e-6: truncation 1e-12, rounding 1e-15 / 1e-6.
  EXPECT_LT((motion.bias_jacobian - numerical).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Preintegration, CorrectionForAnotherBiasErrsToSecondOrderOnly) {
  const sensor::ImuSamples samples = lively_samples(3, 0.3);
  const TimeSpan span{at(0.02), at(0.22)};
  const Preintegration motion = preintegrate(samples, span, {}, {});
  const auto error_at = [&](double size) {
    const ImuBias other{size * Vector3d(0.02, -0.01, 0.015), size * Vector3d(0.1, 0.2, -0.1)};
    return difference(corrected(motion, other), preintegrate(samples, span, other, {}).delta).norm();
  };
  // Turned by 0.027 rad/s for 0.2 s, a bias of 0.24 m/s^2 over 0.2 s changes by 2.6e-4 m/s.
  EXPECT_LT(error_at(1.0), 3e-4);
  // Half the step must leave a quarter of the error; third-order terms are the tolerance.
  EXPECT_NEAR(error_at(1.0) / error_at(0.5), 4.0, 0.1);
  EXPECT_LT(error_at(0.0), 1e-15);
}

TEST(Preintegration, CovarianceIsThatOfTheErrors) {
  constexpr int kRuns = 500;
  constexpr double kStep = 0.01;
  const ImuNoise noise{0.004, 0.03, 0.0, 0.0};
  sensor::ImuSamples ideal;
  for (int i = 0; i <= 60; ++i) {
    const double t = kStep * i;
    ideal.push_back(
        {at(t), Vector3d(0.8, std::cos(3.0 * t), 1.2), Vector3d(3.0 * std::sin(5.0 * t), 2.0, kGravity)});
  }
  const TimeSpan span{at(0.0), at(0.6)};
  const Preintegration truth = preintegrate(ideal, span, {}, noise);
  const Eigen::LLT<Eigen::MatrixXd> llt(truth.covariance);
  math::Random random(4);
  double nees = 0.0;
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(9);
  for (int run = 0; run < kRuns; ++run) {
    sensor::ImuSamples noisy = ideal;
    for (auto& sample : noisy) {
      sample.gyro += noise.gyro / std::sqrt(kStep) * random.normal3();
      sample.accel += noise.accel / std::sqrt(kStep) * random.normal3();
    }
    const Eigen::VectorXd error = difference(preintegrate(noisy, span, {}, noise).delta, truth.delta);
    nees += llt.matrixL().solve(error).squaredNorm() / (9.0 * kRuns);
    variance += error.cwiseAbs2() / kRuns;
  }
  // 4500 squares have a mean within 3 sqrt(2 / 4500) = 6 % of one; 500 within 20 %. White noise sampled at
  // the ends of the steps is not quite white noise over them: another 5 %.
  EXPECT_NEAR(nees, 1.0, 0.11);
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(variance(i) / truth.covariance(i, i), 1.0, 0.25) << i;
}

TEST(Preintegration, SaysHowLongItWentWithoutASample) {
  sensor::ImuSamples samples;
  for (const double t : {0.0, 0.01, 0.02, 0.25, 0.26, 0.27}) samples.push_back(silent(t));
  const auto longest = [&](double from, double to) {
    return preintegrate(samples, {at(from), at(to)}, {}, {}).longest_step;
  };
  EXPECT_NEAR(longest(0.0, 0.02), 0.01, 1e-9);
  EXPECT_NEAR(longest(0.0, 0.1), 0.23, 1e-9);
  EXPECT_NEAR(longest(0.1, 0.26), 0.23, 1e-9);
  EXPECT_NEAR(longest(0.25, 0.5), 0.23, 1e-9);  // silent after 0.27
  EXPECT_NEAR(longest(-0.3, 0.01), 0.3, 1e-9);  // nothing before 0.0
}

TEST(Preintegration, NoTimeIsNoMotion) {
  const Preintegration motion =
      preintegrate(lively_samples(6, 0.2), {at(0.1), at(0.1)}, {}, {1.0, 1.0, 1.0, 1.0});
  EXPECT_EQ(motion.delta.v, Vector3d(Vector3d::Zero()));
  EXPECT_EQ(motion.delta.R, Matrix3d(Matrix3d::Identity()));
  EXPECT_EQ(motion.covariance.norm(), 0.0);
}

TEST(Preintegration, APauseOfTheRecordingLeavesMuchDoubt) {
  sensor::ImuSamples samples;
  for (const double t : {0.0, 0.01, 1.51, 1.52}) samples.push_back(silent(t));
  const Preintegration motion = preintegrate(samples, {at(0.0), at(1.52)}, {}, {});
  EXPECT_GE(motion.covariance(kVelocity, kVelocity), doubt_after_gap(1.5)(kVelocity, kVelocity));
}

}  // namespace
}  // namespace mmlins::imu

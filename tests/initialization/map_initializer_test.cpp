// SPDX-License-Identifier: MIT
#include "mmlins/initialization/map_initializer.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "mmlins/initialization/acceptance.hpp"
#include "mmlins/initialization/window_problem.hpp"
#include "mmlins/math/numerical_jacobian.hpp"
#include "tests/initialization/simulated_window.hpp"

namespace mmlins::initialization {
namespace {

using imu::ErrorVector;
using math::Vector3d;

constexpr int kRuns = 60;
const PoseNoise kGoodPoses{0.01, 0.05 * kRadians};
const PoseNoise kPoorPoses{0.03, 0.15 * kRadians};

/// Biases as the cold prior has them.
imu::ImuBias random_bias(math::Random& random) {
  const BiasDeviation biases;
  return {biases.gyro * random.normal3(), biases.accel * random.normal3()};
}

double nees_per_dof(const imu::Estimate& estimate, const imu::NavState& truth) {
  const ErrorVector error = imu::minus(truth, estimate.state);
  return error.dot(estimate.P.ldlt().solve(error)) / imu::kErrorSize;
}

TEST(WindowProblem, NormalEquationsAreTheGradientOfTheCost) {
  math::Random random(1);
  const Motion motion = random_motion(random, 1.0);
  const SimulatedWindow simulated = simulate_window(motion, random_bias(random), 4, kPoorPoses, random);
  StatePrior prior = cold_prior(kStart, {});
  prior.information.diagonal().head<3>().setConstant(4.0);
  prior.information.bottomRightCorner<2, 2>().setConstant(30.0);
  prior.information.diagonal().tail<2>().setConstant(100.0);
  prior.state.gravity_odom = imu::kGravity * Vector3d(0.3, -0.2, -1.0).normalized();
  const WindowProblem problem(simulated.window, prior);
  States states = problem.guess();
  for (auto& state : states) state.gravity_odom = imu::kGravity * Vector3d(0.1, 0.05, -1.0).normalized();
  const Linearised here = problem.linearise(states, prior.information);
  constexpr int kUnknowns = 4 * kNodeSize + kDirectedGravity;
  const auto cost = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    States moved = states;
    for (std::size_t k = 0; k < 4; ++k) {
      ErrorVector error;
      error << d.segment<kNodeSize>(static_cast<int>(k) * kNodeSize), d.tail<kDirectedGravity>();
      moved[k] = imu::plus(states[k], error);
    }
    return Eigen::VectorXd::Constant(1, problem.linearise(moved, prior.information).cost);
  };
  const Eigen::VectorXd numerical =
      -0.5 * math::numerical_jacobian(cost, Eigen::VectorXd::Zero(kUnknowns)).transpose();
  Eigen::VectorXd gradient(kUnknowns);
  for (int k = 0; k < 4; ++k)
    gradient.segment<kNodeSize>(k * kNodeSize) = here.system.b[static_cast<std::size_t>(k)];
  gradient.tail<kDirectedGravity>() = here.system.b_shared;
  // Central differences of a cost of up to 1e6 with curvatures of up to 1e10.
  for (int i = 0; i < kUnknowns; ++i) {
    EXPECT_NEAR(gradient(i), numerical(i), 1e-5 * gradient.cwiseAbs().maxCoeff()) << i;
  }
}

TEST(ArrowSystem, SolvesAsADenseSystemWouldAndMarginalisesTheRest) {
  math::Random random(2);
  constexpr int kNodes = 4;
  constexpr int kShared = 5;
  constexpr int kSize = kNodes * kNodeSize + kShared;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kSize, kSize);
  // Factors between neighbours and the shared unknowns, so that the pattern is an arrow.
  for (int k = 0; k + 1 < kNodes; ++k) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(60, kSize);
    for (int r = 0; r < 60; ++r) {
      for (int c = 0; c < 2 * kNodeSize; ++c) J(r, k * kNodeSize + c) = random.normal();
      for (int c = 0; c < kShared; ++c) J(r, kNodes * kNodeSize + c) = random.normal();
    }
    dense += J.transpose() * J;
  }
  ArrowSystem system(kNodes, kShared);
  Eigen::VectorXd b(kSize);
  for (double& value : b) value = random.normal();
  for (int k = 0; k < kNodes; ++k) {
    const auto i = static_cast<std::size_t>(k);
    system.diagonal[i] = dense.block<kNodeSize, kNodeSize>(k * kNodeSize, k * kNodeSize);
    system.border[i] = dense.block<kNodeSize, kShared>(k * kNodeSize, kNodes * kNodeSize);
    system.b[i] = b.segment<kNodeSize>(k * kNodeSize);
    if (k + 1 < kNodes)
      system.next[i] = dense.block<kNodeSize, kNodeSize>(k * kNodeSize, (k + 1) * kNodeSize);
  }
  system.shared = dense.bottomRightCorner<kShared, kShared>();
  system.b_shared = b.tail<kShared>();
  const ArrowSolution solution = solve(system);
  ASSERT_TRUE(solution.ok);
  const Eigen::VectorXd x = dense.ldlt().solve(b);
  // Well conditioned: rounding of sums over fifty products.
  for (int k = 0; k < kNodes; ++k) {
    EXPECT_LT((solution.nodes[static_cast<std::size_t>(k)] - x.segment<kNodeSize>(k * kNodeSize)).norm(),
              1e-12);
  }
  EXPECT_LT((solution.shared - x.tail<kShared>()).norm(), 1e-12);
  const Eigen::MatrixXd inverse = dense.inverse();
  EXPECT_LT((solution.last_covariance - inverse.bottomRightCorner<kNodeSize + kShared, kNodeSize + kShared>())
                .norm(),
            1e-12);
  system.shared.setZero();
  EXPECT_FALSE(solve(system).ok);
}

TEST(MapInitializer, ColdStartIsConsistentWithItsCovariance) {
  for (const int poses : {10, 20, 30}) {
    double nees = 0.0;
    double chi2 = 0.0;
    for (int run = 0; run < kRuns; ++run) {
      math::Random random(
          math::sub_seed(100 + static_cast<std::uint64_t>(poses), static_cast<std::uint64_t>(run)));
      const Motion motion = random_motion(random, run % 2 == 0 ? 1.0 : 0.3);
      const SimulatedWindow simulated =
          simulate_window(motion, random_bias(random), poses, kGoodPoses, random);
      const MapSolution solution = solve_map(simulated.window, cold_prior(kStart, {}), 10);
      ASSERT_EQ(solution.status, SolveStatus::kSolved);
      nees += nees_per_dof(solution.estimate, simulated.last) / kRuns;
      chi2 += solution.figures.chi2_per_dof / kRuns;
    }
    // 1020 squares: within 13 % of one for a filter that is right; six of them (place and heading of the
    // frame) are the last pose's.
    EXPECT_GT(nees, 0.8) << poses;
    EXPECT_LT(nees, 1.3) << poses;
    EXPECT_NEAR(chi2, 1.0, 0.15) << poses;
  }
}

TEST(MapInitializer, CarriedOverThroughAGapItIsConsistentWithItsCovariance) {
  for (const double gap : {2.0, 10.0}) {
    double nees = 0.0;
    for (int run = 0; run < kRuns; ++run) {
      math::Random random(math::sub_seed(200, static_cast<std::uint64_t>(run)));
      const Motion motion = random_motion(random, 1.0);
      const imu::ImuBias bias = random_bias(random);
      const imu::Estimate carried = carried_over(motion, bias, gap, random);
      const SimulatedWindow simulated = window_after_gap(motion, bias, carried, 10, kGoodPoses, random);
      const MapSolution solution =
          solve_map(simulated.window, carried_over_prior(carried, carried.state.T_odom_imu()), 10);
      ASSERT_EQ(solution.status, SolveStatus::kSolved);
      nees += nees_per_dof(solution.estimate, simulated.last) / kRuns;
    }
    EXPECT_GT(nees, 0.8) << gap;
    EXPECT_LT(nees, 1.3) << gap;
  }
}

TEST(MapInitializer, WhatIsCarriedOverMayBeInAnotherFrameThanThePoses) {
  math::Random random(10);
  const Motion motion = random_motion(random, 1.0);
  const imu::Estimate carried = carried_over(motion, {}, 3.0, random);
  const SimulatedWindow simulated = window_after_gap(motion, {}, carried, 10, kGoodPoses, random);
  const math::SE3& first = simulated.window.poses[0].T_odom_imu;
  const MapSolution here = solve_map(simulated.window, carried_over_prior(carried, first), 10);
  const math::SE3 elsewhere{math::so3_exp(Vector3d(0.3, -0.4, 2.0)), Vector3d(10.0, 20.0, -5.0)};
  const imu::Estimate moved = imu::transformed(elsewhere, carried);
  const MapSolution there = solve_map(simulated.window, carried_over_prior(moved, first), 10);
  // Iterations stop within a hundredth of a standard deviation.
  const ErrorVector sigma = here.estimate.P.diagonal().cwiseSqrt();
  const ErrorVector difference = imu::minus(there.estimate.state, here.estimate.state);
  EXPECT_LT(difference.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_NEAR(here.figures.chi2_per_dof, there.figures.chi2_per_dof, 1e-3);
}

TEST(MapInitializer, AtRestItFindsBiasesAndStandsStill) {
  double nees = 0.0;
  int accepted = 0;
  for (int run = 0; run < kRuns; ++run) {
    math::Random random(math::sub_seed(300, static_cast<std::uint64_t>(run)));
    Motion rest;
    rest.velocity.setZero();
    rest.yaw_rate = 0.0;
    rest.wobble = 0.2 * random.normal3();
    rest.frequency = 0.0;  // a tilt that does not change
    for (double& phase : rest.phase) phase = 1.57;
    const imu::ImuBias bias = random_bias(random);
    const SimulatedWindow simulated = simulate_window(rest, bias, 10, kGoodPoses, random);
    const StatePrior prior = rest_prior(simulated.window.poses[0], simulated.window.samples, {}, {});
    const MapSolution solution = solve_map(simulated.window, prior, 10);
    ASSERT_EQ(solution.status, SolveStatus::kSolved);
    EXPECT_LT(solution.estimate.state.v_odom.norm(), 0.05);
    EXPECT_LT((solution.estimate.state.gyro_bias - bias.gyro).norm(), 2e-3);
    accepted += judge(solution, true, {}).accepted() ? 1 : 0;
    nees += nees_per_dof(solution.estimate, simulated.last) / kRuns;
  }
  // Tests at three and five sigmas refuse one window in a few hundred.
  EXPECT_GE(accepted, kRuns - 2);
  // The prior's deviations at rest are upper bounds: it may be cautious, not bold.
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 1.3);
}

TEST(MapInitializer, WithoutExcitationTiltIsDoubtedByTheWholeAccelerometerBias) {
  math::Random random(5);
  Motion straight;
  straight.yaw_rate = 0.0;
  const SimulatedWindow simulated =
      simulate_window(straight, {Vector3d::Zero(), {0.1, 0.0, 0.0}}, 30, kGoodPoses, random);
  const MapSolution solution = solve_map(simulated.window, cold_prior(kStart, {}), 10);
  ASSERT_EQ(solution.status, SolveStatus::kSolved);
  const double inseparable = BiasDeviation{}.accel / imu::kGravity;
  EXPECT_GT(solution.figures.sigma_tilt, 0.95 * inseparable);
  EXPECT_NEAR(tilt_error(solution.estimate.state, simulated.last), inseparable, 3.0 * 0.06 * kRadians);
  // Neither is known alone, but their sum is: tilt and bias are almost fully correlated.
  const auto& P = solution.estimate.P;
  const Eigen::Matrix<double, 3, 2> cross = P.block<3, 2>(imu::kAccelBias, imu::kGravityDirection);
  EXPECT_GT(cross.col(1).norm() / std::sqrt(P(16, 16) * 0.1 * 0.1), 0.9);
}

TEST(MapInitializer, ThePriorOfTheVelocityIsToldFromWhatPosesSay) {
  math::Random random(6);
  const Motion motion = random_motion(random, 0.3);
  const SimulatedWindow simulated = simulate_window(motion, {}, 4, kPoorPoses, random);
  StatePrior prior{simulated.first, PriorMatrix(1e6 * PriorMatrix::Identity())};
  const SolutionFigures figures = solve_map(simulated.window, prior, 10).figures;
  // The prior's 1 mm/s, and gravity for 0.3 s in an attitude known to 1e-3 rad: 3 mm/s.
  EXPECT_LT(figures.sigma_speed, 5e-3);
  // A line through four positions over 0.3 s with 3 cm of error, of which the first is exact: sigma /
  // sqrt(sum t^2).
  EXPECT_NEAR(figures.sigma_speed_unaided, 0.03 / std::sqrt(0.01 + 0.04 + 0.09), 0.01);
}

TEST(MapInitializer, ADirectionThatNoPoseSeesIsLeftToThePrior) {
  math::Random random(7);
  const Motion motion = random_motion(random, 0.5);
  SimulatedWindow simulated = simulate_window(motion, {}, 10, kGoodPoses, random);
  for (std::size_t k = 1; k < simulated.window.poses.size(); ++k) {
    simulated.window.poses[k].information.row(imu::kPosition).setZero();
    simulated.window.poses[k].information.col(imu::kPosition).setZero();
    simulated.window.poses[k].T_odom_imu.t.x() += 100.0;  // must not matter
  }
  EXPECT_NE(solve_map(simulated.window, cold_prior(kStart, {}), 10).status, SolveStatus::kSolved);
  StatePrior prior{simulated.first, PriorMatrix(1e4 * PriorMatrix::Identity())};
  const MapSolution solution = solve_map(simulated.window, prior, 10);
  ASSERT_EQ(solution.status, SolveStatus::kSolved);
  EXPECT_LT((solution.estimate.state.v_odom - simulated.last.v_odom).norm(), 0.05);
  EXPECT_GT(solution.figures.sigma_speed_unaided, 1.0);
}

TEST(MapInitializer, EveryStateOfTheWindowComesOutToStraightenTheScansWith) {
  math::Random random(8);
  const Motion motion = random_motion(random, 1.0);
  const SimulatedWindow simulated = simulate_window(motion, {}, 20, kGoodPoses, random);
  const MapSolution solution = solve_map(simulated.window, cold_prior(kStart, {}), 10);
  ASSERT_EQ(solution.states.size(), 20u);
  for (int k = 0; k < 20; ++k) {
    const auto& state = solution.states[static_cast<std::size_t>(k)];
    const Vector3d v = motion.R(0.0).transpose() * motion.v(kScanPeriod * k);
    EXPECT_EQ(state.time, at(kScanPeriod * k));
    EXPECT_LT((state.v_odom - v).norm(), 0.1) << k;
  }
}

TEST(MapInitializer, SameInputGivesTheSameBits) {
  math::Random random(9);
  const SimulatedWindow simulated = simulate_window(random_motion(random, 1.0), {}, 20, kGoodPoses, random);
  const MapSolution a = solve_map(simulated.window, cold_prior(kStart, {}), 10);
  const MapSolution b = solve_map(simulated.window, cold_prior(kStart, {}), 10);
  EXPECT_EQ(a.estimate.P, b.estimate.P);
  EXPECT_EQ(a.estimate.state.v_odom, b.estimate.state.v_odom);
}

TEST(PoseFromMatching, IsTheLeastOfTheQuadraticButStaysInUnseenDirections) {
  math::Vector6d step;
  step << 0.01, -0.02, 0.005, 0.1, -0.05, 0.0;
  math::Matrix6d H = 1e4 * math::Matrix6d::Identity();
  H(5, 5) = 1e-3;
  const math::Vector6d b = -H * step + 1e-3 * math::Vector6d::Unit(5);
  const math::SE3 T{math::so3_exp(Vector3d(0.3, 0.2, 0.1)), Vector3d(1.0, 2.0, 3.0)};
  const PoseMeasurement pose = pose_from_matching(kStart, T, H, b);
  EXPECT_LT((pose.T_odom_imu.R - T.R * math::so3_exp(step.head<3>())).norm(), 1e-12);
  EXPECT_LT((pose.T_odom_imu.t - T.t - step.tail<3>()).norm(), 1e-12);
}

}  // namespace
}  // namespace mmlins::initialization

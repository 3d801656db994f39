// SPDX-License-Identifier: MIT
#include "mmlins/initialization/acceptance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "tests/initialization/simulated_window.hpp"

namespace mmlins::initialization {
namespace {

using math::Vector3d;

const PoseNoise kGoodPoses{0.01, 0.05 * kRadians};
const InitializationConfig kConfig;

SimulatedWindow good_window(std::uint64_t seed, int poses = 20) {
  math::Random random(seed);
  const Motion motion = random_motion(random, 0.5);
  return simulate_window(motion, {0.004 * random.normal3(), 0.03 * random.normal3()}, poses, kGoodPoses,
                         random);
}

StatePrior cold() { return cold_prior(kStart, {}); }

/// A solution that passes every test.
MapSolution good_solution() {
  MapSolution solution;
  solution.status = SolveStatus::kSolved;
  solution.figures = {20, 1.9, 0.005, 0.05, 0.03, 0.3 * kRadians, 0.0, 0.03, 0.04, 1.0, 100, 1.0, 1.0, 5};
  return solution;
}

TEST(Acceptance, GoodWindowsAreAcceptedAlmostAlways) {
  int accepted = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Initialization start = initialize(good_window(seed).window, cold(), kConfig);
    accepted += start.acceptance.accepted() ? 1 : 0;
  }
  // Tests at three and five sigmas refuse one good window in a few hundred; the next scan brings another.
  EXPECT_GE(accepted, 48);
}

TEST(Acceptance, WhatIsAcceptedIsAsGoodAsItSays) {
  // Whatever the window, an accepted start never errs by more than five of its own sigmas.
  int accepted = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const SimulatedWindow simulated = good_window(seed, 6 + static_cast<int>(seed % 4) * 8);
    const Initialization start = initialize(simulated.window, cold(), kConfig);
    if (!start.acceptance.accepted()) continue;
    ++accepted;
    const imu::NavState& state = start.solution.estimate.state;
    EXPECT_LT(tilt_error(state, simulated.last), 5.0 * start.solution.figures.sigma_tilt) << seed;
    EXPECT_LT((state.v_odom - simulated.last.v_odom).norm(), 5.0 * start.solution.figures.sigma_speed)
        << seed;
  }
  EXPECT_GT(accepted, 20);
}

TEST(Acceptance, WrongPosesAreRefused) {
  SimulatedWindow jump = good_window(3);
  for (std::size_t k = 10; k < 20; ++k) jump.window.poses[k].T_odom_imu.t.x() += 0.3;
  EXPECT_EQ(initialize(jump.window, cold(), kConfig).acceptance.verdict, Verdict::kPosesDisagree);

  // Two unrelated places: every pose somewhere else by half a metre.
  SimulatedWindow noise = good_window(4);
  math::Random random(4);
  for (std::size_t k = 1; k < 20; ++k) noise.window.poses[k].T_odom_imu.t += 0.5 * random.normal3();
  EXPECT_EQ(initialize(noise.window, cold(), kConfig).acceptance.verdict, Verdict::kPosesDisagree);

  // A membrane that moves with the sensor: the scans see no motion at all where the IMU feels a lively one.
  math::Random lively(5);
  SimulatedWindow frozen = simulate_window(random_motion(lively, 1.0), {}, 20, kGoodPoses, lively);
  for (auto& pose : frozen.window.poses) pose.T_odom_imu = {};
  EXPECT_FALSE(initialize(frozen.window, cold(), kConfig).acceptance.accepted());
}

TEST(Acceptance, AMembraneOnASmoothRoadIsRefusedByWhatWasCarriedOver) {
  // Constant velocity, and poses that say stand-still: nothing but the prior's velocity can tell.
  math::Random random(6);
  Motion straight;
  straight.yaw_rate = 0.0;
  SimulatedWindow frozen = simulate_window(straight, {}, 10, kGoodPoses, random);
  for (std::size_t k = 1; k < frozen.window.poses.size(); ++k) {
    frozen.window.poses[k].T_odom_imu = frozen.window.poses[0].T_odom_imu;
    frozen.window.poses[k].T_odom_imu.t += 0.01 * random.normal3();
  }
  imu::ErrorVector sigma;
  sigma << Vector3d::Constant(1e-3), Vector3d::Constant(0.1), Vector3d::Constant(0.1),
      Vector3d::Constant(1e-4), Vector3d::Constant(0.01), Eigen::Vector2d::Constant(3e-3);
  const StatePrior prior =
      carried_over_prior({frozen.first, sigma.cwiseAbs2().asDiagonal()}, frozen.first.T_odom_imu());
  EXPECT_EQ(initialize(frozen.window, prior, kConfig).acceptance.verdict, Verdict::kPosesDisagree);
}

TEST(Acceptance, PosesCopiedFromTheImuAreNotMeasurements) {
  SimulatedWindow simulated = good_window(7);
  const imu::Propagation copy =
      imu::propagate({simulated.first, imu::ErrorMatrix::Zero()}, simulated.window.samples, {});
  for (auto& pose : simulated.window.poses)
    pose.T_odom_imu = *math::pose_at(copy.T_odom_imu, pose.time, from_seconds(0.1));
  const StatePrior prior{simulated.first, PriorMatrix(1e4 * PriorMatrix::Identity())};
  EXPECT_EQ(initialize(simulated.window, prior, kConfig).acceptance.verdict, Verdict::kPosesNotMeasured);
}

TEST(Acceptance, ConstantVelocityIsAcceptedOnlyWithTheDoubtThatIsThere) {
  math::Random random(8);
  Motion straight;
  straight.yaw_rate = 0.0;
  const Vector3d accel_bias(0.05, -0.05, 0.02);
  const SimulatedWindow simulated =
      simulate_window(straight, {Vector3d::Zero(), accel_bias}, 30, kGoodPoses, random);
  const Initialization start = initialize(simulated.window, cold(), kConfig);
  ASSERT_TRUE(start.acceptance.accepted()) << start.acceptance.reason;
  EXPECT_GE(start.solution.figures.sigma_tilt, 0.95 * BiasDeviation{}.accel / imu::kGravity);
  EXPECT_LT(tilt_error(start.solution.estimate.state, simulated.last),
            3.0 * start.solution.figures.sigma_tilt);
}

TEST(Acceptance, FreeFallIsNoObstacle) {
  // The force is nil: nothing of gravity is felt, all of it is seen.
  math::Random random(9);
  Motion motion = random_motion(random, 0.0);
  motion.yaw_rate = 0.2;
  SimulatedWindow simulated = simulate_window(motion, {}, 20, kGoodPoses, random);
  const Vector3d gravity = simulated.first.gravity_odom;
  for (auto& pose : simulated.window.poses) {
    const double t = to_seconds(pose.time - kStart);
    pose.T_odom_imu.t += 0.5 * t * t * gravity;
  }
  for (auto& sample : simulated.window.samples)
    sample.accel -= motion.force(to_seconds(sample.time - kStart));
  const Initialization start = initialize(simulated.window, cold(), kConfig);
  ASSERT_TRUE(start.acceptance.accepted()) << start.acceptance.reason;
  EXPECT_LT(tilt_error(start.solution.estimate.state, simulated.last),
            4.0 * start.solution.figures.sigma_tilt);
  const Vector3d v = simulated.last.v_odom + 1.9 * gravity;
  EXPECT_LT((start.solution.estimate.state.v_odom - v).norm(), 4.0 * start.solution.figures.sigma_speed);
}

TEST(Acceptance, AWrongScaleOfTheAccelerometerIsSeenInTheMagnitudeOfGravity) {
  SimulatedWindow simulated = good_window(10, 30);
  for (auto& sample : simulated.window.samples) sample.accel *= 0.9;
  EXPECT_FALSE(initialize(simulated.window, cold(), kConfig).acceptance.accepted());
}

TEST(Acceptance, NumbersThatAreNoneAreRefused) {
  SimulatedWindow poses = good_window(13);
  poses.window.poses[7].T_odom_imu.t.y() = std::nan("");
  EXPECT_EQ(initialize(poses.window, cold(), kConfig).acceptance.verdict, Verdict::kNotDetermined);
  SimulatedWindow imu = good_window(14);
  imu.window.samples[50].gyro.z() = std::nan("");
  EXPECT_EQ(initialize(imu.window, cold(), kConfig).acceptance.verdict, Verdict::kNotDetermined);
}

TEST(Acceptance, ShortWindowsAndGapsAreNamed) {
  SimulatedWindow simulated = good_window(11, 8);
  EXPECT_EQ(initialize(simulated.window, cold(), kConfig).acceptance.verdict, Verdict::kWindowTooShort);
  simulated.window.poses.resize(3);
  EXPECT_EQ(initialize(simulated.window, cold(), kConfig).acceptance.verdict, Verdict::kTooFewPoses);
  SimulatedWindow gap = good_window(12);
  auto& samples = gap.window.samples;
  samples.erase(samples.begin() + 100, samples.begin() + 140);
  EXPECT_EQ(initialize(gap.window, cold(), kConfig).acceptance.verdict, Verdict::kImuGap);
  samples.clear();
  EXPECT_EQ(initialize(gap.window, cold(), kConfig).acceptance.verdict, Verdict::kImuGap);
  EXPECT_EQ(initialize({}, cold(), kConfig).acceptance.verdict, Verdict::kTooFewPoses);
}

TEST(Acceptance, EveryTestHasItsVerdictItsWordsAndItsFigures) {
  ASSERT_TRUE(judge(good_solution(), false, kConfig).accepted());
  const double infinity = std::numeric_limits<double>::infinity();
  struct Case {
    Verdict verdict;
    double SolutionFigures::*figure;
    double value;
  };
  std::set<std::string> words;
  for (const Case& c : {Case{Verdict::kWindowTooShort, &SolutionFigures::duration, 0.5},
                        Case{Verdict::kImuGap, &SolutionFigures::longest_imu_step, 0.2},
                        Case{Verdict::kPosesDisagree, &SolutionFigures::chi2_per_dof, 4.0},
                        Case{Verdict::kPosesNotMeasured, &SolutionFigures::chi2_per_dof, 1e-3},
                        Case{Verdict::kGravityMagnitude, &SolutionFigures::gravity_error, 0.2},
                        Case{Verdict::kBias, &SolutionFigures::gyro_bias_sigmas, 6.0},
                        Case{Verdict::kBias, &SolutionFigures::accel_bias_sigmas, 6.0},
                        Case{Verdict::kTilt, &SolutionFigures::sigma_tilt, 0.1},
                        Case{Verdict::kSpeed, &SolutionFigures::sigma_speed, 0.2},
                        Case{Verdict::kSpeed, &SolutionFigures::sigma_speed, std::nan("")},
                        Case{Verdict::kSpeedUnsupported, &SolutionFigures::sigma_speed_unaided, infinity}}) {
    MapSolution solution = good_solution();
    solution.figures.*c.figure = c.value;
    const Acceptance acceptance = judge(solution, false, kConfig);
    EXPECT_EQ(acceptance.verdict, c.verdict) << acceptance.reason;
    EXPECT_FALSE(acceptance.reason.empty());
    EXPECT_EQ(acceptance.reason.find('\n'), std::string::npos);
    words.emplace(to_string(c.verdict));
  }
  EXPECT_EQ(words.size(), 9u);
  MapSolution singular = good_solution();
  singular.status = SolveStatus::kSingular;
  EXPECT_EQ(judge(singular, false, kConfig).verdict, Verdict::kNotDetermined);
  singular.status = SolveStatus::kNotConverged;
  EXPECT_EQ(judge(singular, false, kConfig).verdict, Verdict::kNotConverged);
}

TEST(Acceptance, TiltThatTheAccelerometersBiasHidesIsAdmittedAndNoMore) {
  MapSolution solution = good_solution();
  solution.figures.inseparable_tilt = 1.5 * kRadians;
  solution.figures.sigma_tilt = 1.7 * kRadians;  // 0.8 deg besides the 1.5
  EXPECT_TRUE(judge(solution, false, kConfig).accepted());
  solution.figures.sigma_tilt = 1.9 * kRadians;  // 1.2 deg
  EXPECT_EQ(judge(solution, false, kConfig).verdict, Verdict::kTilt);
}

TEST(Acceptance, UnknownMagnitudeOfGravityIsAllowedItsOwnSigmas) {
  MapSolution solution = good_solution();
  solution.figures.gravity_error = 0.5;
  solution.figures.sigma_gravity = 0.2;
  EXPECT_TRUE(judge(solution, false, kConfig).accepted());
}

TEST(InitializationConfig, DefaultsLieInTheirRanges) {
  InitializationConfig config;
  EXPECT_EQ(config.fields().size(), 5u);
}

}  // namespace
}  // namespace mmlins::initialization

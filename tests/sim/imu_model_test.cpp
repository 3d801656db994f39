// SPDX-License-Identifier: MIT
#include "mmlins/sim/imu_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/sim/scenario.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

// What a user of the samples does, by a rule of fourth order: the midpoint rule errs by more than a
// millimetre where a walking robot shakes at 3 Hz. Nothing but the first state and the samples is used.
Vector3d integrated_position(const ImuModel& imu, const Motion& motion, std::int64_t first,
                             std::int64_t last) {
  const Kinematics start = motion.at(to_seconds(imu.sample_time(first)));
  const Vector3d gravity(0, 0, -kGravity);
  math::Matrix3d R = start.T_world_imu.R;
  Vector3d p = start.T_world_imu.t;
  Vector3d v = start.velocity_world;
  for (std::int64_t i = first; i + 1 < last; i += 2) {
    const sensor::ImuSample a = imu.sample(motion, i);
    const sensor::ImuSample b = imu.sample(motion, i + 1);
    const sensor::ImuSample c = imu.sample(motion, i + 2);
    const double h = to_seconds(b.time - a.time);
    const Vector3d half = h / 12.0 * (5.0 * a.gyro + 8.0 * b.gyro - c.gyro + h * a.gyro.cross(b.gyro));
    const Vector3d full = h / 3.0 * (a.gyro + 4.0 * b.gyro + c.gyro + h * a.gyro.cross(c.gyro));
    const Vector3d at_b = R * math::so3_exp(half) * b.accel + gravity;
    const math::Matrix3d R_next = R * math::so3_exp(full);
    const Vector3d at_a = R * a.accel + gravity;
    p += 2.0 * h * v + 2.0 * h * h / 3.0 * (at_a + 2.0 * at_b);
    v += h / 3.0 * (at_a + 4.0 * at_b + R_next * c.accel + gravity);
    R = R_next;
  }
  return p;
}

TEST(ImuModel, PerfectSamplesIntegrateToTheTruthWithinAMillimetreInTenSeconds) {
  for (const ScenarioText& scenario : scenario_texts()) {
    auto config = load_scenario(scenario.name);
    ASSERT_TRUE(config.ok());
    // Named carriers have their own test (carrier_test.cpp): legs sway too fast for this simple integration.
    if (config->trajectory.carrier != Carrier::kCustom) continue;
    config->imu.perfect = true;
    const auto motion = make_motion(config->trajectory, scene_route(config->world));
    const ImuModel imu(config->imu, 1, from_seconds(config->duration));
    for (const std::int64_t first : {0L, 500L, 2000L, 4000L}) {
      const std::int64_t last = first + 2000;
      const Vector3d truth = motion->at(to_seconds(imu.sample_time(last))).T_world_imu.t;
      EXPECT_LT((integrated_position(imu, *motion, first, last) - truth).norm(), 1e-3)
          << scenario.name << " from sample " << first;
    }
  }
}

TEST(ImuModel, AtRestReadsGravityUpAndNoRotation) {
  TrajectoryConfig still;
  still.stand_still = 10.0;
  const auto motion = make_motion(still, {});
  ImuConfig config;
  config.perfect = true;
  const sensor::ImuSample sample = ImuModel(config, 1, from_seconds(10)).sample(*motion, 77);
  EXPECT_NEAR(sample.accel.norm(), kGravity, 1e-12);
  EXPECT_EQ(sample.gyro.norm(), 0.0);
  const Vector3d up_world = motion->at(0.0).T_world_imu.R * sample.accel;
  EXPECT_NEAR(up_world.z(), kGravity, 1e-12);
}

// Root mean square per axis of 3 n numbers scatters by 1 / sqrt(6 n): 0.3 % for n = 20 000.
constexpr int kNumSamples = 20'000;
constexpr double kScatter = 0.015;

TEST(ImuModel, WhiteNoiseHasTheDeclaredDensity) {
  TrajectoryConfig still;
  still.stand_still = 600.0;
  const auto motion = make_motion(still, {});
  const ImuConfig config;
  const ImuModel imu(config, 5, from_seconds(kNumSamples / config.rate_hz));
  const sensor::ImuSample ideal = ideal_sample(motion->at(0.0));
  double gyro_square = 0.0;
  double accel_square = 0.0;
  for (int i = 0; i < kNumSamples; ++i) {
    const sensor::ImuSample sample = imu.sample(*motion, i);
    const ImuBias bias = imu.bias_at(sample.time.time_since_epoch());
    gyro_square += (sample.gyro - ideal.gyro - bias.gyro).squaredNorm();
    accel_square += (sample.accel - ideal.accel - bias.accel).squaredNorm();
  }
  const double per_density = std::sqrt(config.rate_hz);
  const double gyro = std::sqrt(gyro_square / (3 * kNumSamples)) / per_density;
  const double accel = std::sqrt(accel_square / (3 * kNumSamples)) / per_density;
  EXPECT_NEAR(gyro / config.gyro_noise_density, 1.0, kScatter);
  EXPECT_NEAR(accel / config.accel_noise_density, 1.0, kScatter);
}

TEST(ImuModel, BiasWalksAtTheDeclaredRate) {
  const ImuConfig config;
  const Duration step = from_seconds(1.0 / config.rate_hz);
  const ImuModel imu(config, 6, kNumSamples * step);
  double gyro_square = 0.0;
  double accel_square = 0.0;
  for (int i = 0; i < kNumSamples; ++i) {
    gyro_square += (imu.bias_at((i + 1) * step).gyro - imu.bias_at(i * step).gyro).squaredNorm();
    accel_square += (imu.bias_at((i + 1) * step).accel - imu.bias_at(i * step).accel).squaredNorm();
  }
  const double seconds = kNumSamples / config.rate_hz;
  EXPECT_NEAR(std::sqrt(gyro_square / (3 * seconds)) / config.gyro_bias_walk, 1.0, kScatter);
  EXPECT_NEAR(std::sqrt(accel_square / (3 * seconds)) / config.accel_bias_walk, 1.0, kScatter);
}

TEST(ImuModel, TurnOnBiasHasTheDeclaredDeviationOverSeeds) {
  const ImuConfig config;
  double gyro_square = 0.0;
  constexpr int kSeeds = 2000;  // scatter of the deviation: 1 / sqrt(12 000) = 0.9 %
  for (int seed = 0; seed < kSeeds; ++seed) {
    const auto number = static_cast<std::uint64_t>(seed);
    gyro_square += ImuModel(config, number, Duration{0}).bias_at(Duration{0}).gyro.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(gyro_square / (3 * kSeeds)) / config.gyro_turn_on_bias, 1.0, 0.04);
}

/// A body at rest and level for 100 s, as an IMU of this config measures it.
sensor::ImuSamples at_rest(const ImuConfig& config, std::int64_t count = 4000) {
  TrajectoryConfig still;
  still.stand_still = 100.0;
  const auto motion = make_motion(still, {});
  const ImuModel imu(config, 5, from_seconds(100.0));
  sensor::ImuSamples samples;
  for (std::int64_t i = 0; i < count; ++i) samples.push_back(imu.sample(*motion, i));
  return samples;
}

ImuConfig quiet() {
  ImuConfig config;
  config.gyro_noise_density = config.accel_noise_density = 1e-8;
  config.gyro_bias_walk = config.accel_bias_walk = 0.0;
  config.gyro_turn_on_bias = config.accel_turn_on_bias = 0.0;
  return config;
}

TEST(ImuModel, AClassFillsInWhatIsLeftAtItsDefault) {
  ImuConfig config;
  EXPECT_EQ(config.resolved().accel_noise_density, config.accel_noise_density);
  config.model = ImuClass::kTactical;
  config.accel_noise_density = 7e-3;
  EXPECT_EQ(config.resolved().gyro_noise_density, 4e-5);
  EXPECT_EQ(config.resolved().accel_noise_density, 7e-3);
  config.model = ImuClass::kConsumer;
  EXPECT_GT(config.resolved().gyro_noise_density, ImuConfig{}.gyro_noise_density);
}

TEST(ImuModel, ScaleAndMisalignmentDependOnTheSensorAndNotOnTime) {
  ImuConfig config = quiet();
  config.scale_error = 0.01;
  config.misalignment_deg = 0.5;
  const sensor::ImuSamples samples = at_rest(config);
  ImuConfig exact = quiet();
  exact.perfect = true;
  const Vector3d error = samples[0].accel - at_rest(exact, 1)[0].accel;
  EXPECT_LT((samples[3999].accel - samples[0].accel).norm(), 1e-5);
  EXPECT_GT(error.norm(), 0.01);  // two ten-thousandths of what is expected at random
  EXPECT_LT(error.norm(), 5.0 * 0.014 * kGravity);
}

TEST(ImuModel, VibrationHasItsDeclaredStrengthAndNoMean) {
  ImuConfig config = quiet();
  config.vibration = 2.0;
  const sensor::ImuSamples samples = at_rest(config, 16000);
  ImuConfig exact = quiet();
  exact.perfect = true;
  const Vector3d rest = at_rest(exact, 1)[0].accel;
  Vector3d sum = Vector3d::Zero();
  Vector3d squares = Vector3d::Zero();
  for (const sensor::ImuSample& sample : samples) {
    sum += sample.accel - rest;
    squares += (sample.accel - rest).cwiseAbs2();
  }
  const auto n = static_cast<double>(samples.size());
  for (int axis = 0; axis < 3; ++axis) {
    // Waves near to each other in frequency beat: over 80 s that leaves a few percent.
    EXPECT_NEAR(std::sqrt(squares[axis] / n), 2.0, 0.3);
    EXPECT_NEAR(sum[axis] / n, 0.0, 0.02);
  }
}

TEST(ImuModel, ReadingsStopAtTheirLimits) {
  ImuConfig config = quiet();
  config.accel_limit = 9.0;
  const Vector3d accel = at_rest(config, 1)[0].accel;
  EXPECT_LE(accel.cwiseAbs().maxCoeff(), 9.0);
  EXPECT_GT(accel.cwiseAbs().maxCoeff(), 8.9);
}

TEST(ImuModel, StampsAreShiftedAndJitterWithoutRunningBackwards) {
  ImuConfig config = quiet();
  config.time_offset = -0.004;
  config.stamp_jitter = 0.002;  // often cut off at 45 % of the period of 5 ms
  const sensor::ImuSamples samples = at_rest(config);
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double error = to_seconds(samples[i].time.time_since_epoch()) - 0.005 * static_cast<double>(i);
    sum += error;
    EXPECT_LE(std::abs(error + 0.004), 0.00225 + 1e-9);
    EXPECT_GT(samples[i].time, i == 0 ? Time(Duration(-100'000'000)) : samples[i - 1].time);
  }
  EXPECT_NEAR(sum / static_cast<double>(samples.size()), -0.004, 4.0 * 0.002 / std::sqrt(4000.0));
}

TEST(ImuModel, TheDeclaredShareOfSamplesIsDropped) {
  ImuConfig config;
  config.drop_share = 0.1;
  const ImuModel imu(config, 5, from_seconds(10.0));
  int dropped = 0;
  for (std::int64_t i = 0; i < 10'000; ++i) dropped += imu.is_dropped(i) ? 1 : 0;
  EXPECT_NEAR(dropped, 1000, 120);  // four deviations
  EXPECT_FALSE(ImuModel(ImuConfig{}, 5, from_seconds(10.0)).is_dropped(3));
}

}  // namespace
}  // namespace mmlins::sim

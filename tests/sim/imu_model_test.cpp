// SPDX-License-Identifier: MIT
#include "mmlins/sim/imu_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/sim/scenario.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

// What a user of the samples does: midpoint rule, nothing but the first state and the samples.
Vector3d integrated_position(const ImuModel& imu, const Motion& motion, std::int64_t first,
                             std::int64_t last) {
  const Kinematics start = motion.at(to_seconds(imu.sample_time(first)));
  math::Matrix3d R = start.T_world_imu.R;
  Vector3d p = start.T_world_imu.t;
  Vector3d v = start.velocity_world;
  for (std::int64_t i = first; i < last; ++i) {
    const sensor::ImuSample a = imu.sample(motion, i);
    const sensor::ImuSample b = imu.sample(motion, i + 1);
    const double dt = to_seconds(b.time - a.time);
    const math::Matrix3d R_next = R * math::so3_exp(0.5 * dt * (a.gyro + b.gyro));
    const Vector3d acceleration = 0.5 * (R * a.accel + R_next * b.accel) - Vector3d(0, 0, kGravity);
    p += dt * v + 0.5 * dt * dt * acceleration;
    v += dt * acceleration;
    R = R_next;
  }
  return p;
}

TEST(ImuModel, PerfectSamplesIntegrateToTheTruthWithinAMillimetreInTenSeconds) {
  for (const ScenarioText& scenario : scenario_texts()) {
    auto config = load_scenario(scenario.name);
    ASSERT_TRUE(config.ok());
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

}  // namespace
}  // namespace mmlins::sim

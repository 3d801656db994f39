// SPDX-License-Identifier: MIT
// How each kind of carrier moves, with a stop on the way.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mmlins/sim/imu_model.hpp"
#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/simulation.hpp"
#include "mmlins/sim/smooth_step.hpp"

namespace mmlins::sim {
namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr std::array<Carrier, 4> kCarriers{Carrier::kVehicle, Carrier::kHandheld, Carrier::kQuadruped,
                                           Carrier::kDrone};
constexpr double kStopAt = 25.0;
constexpr double kStopFor = 4.0;

std::string name_of(Carrier carrier) { return carrier_names()[static_cast<std::size_t>(carrier)]; }

// A round of corners for those on legs; wide enough for a vehicle.
Route route_for(Carrier carrier) {
  const double scale = carrier == Carrier::kVehicle ? 60.0 : 12.0;
  return {{{-scale, -scale}, {scale, -0.8 * scale}, {1.2 * scale, scale}, {-scale, 0.7 * scale}}, {}};
}

TrajectoryConfig config_of(Carrier carrier) {
  TrajectoryConfig config;
  config.carrier = carrier;
  config.style = PathStyle::kRoute;
  config.stand_still = 2.0;
  config.stops = {{kStopAt, kStopFor}};
  return config;
}

std::unique_ptr<Motion> motion_of(Carrier carrier) {
  return make_motion(config_of(carrier), route_for(carrier));
}

struct State {
  Matrix3d R;
  Vector3d p, v;
};

// From three samples in a row, of fourth order: nothing but the samples is used.
State after_two_steps(const State& s, const std::array<sensor::ImuSample, 3>& u, double h) {
  const double H = 2.0 * h;
  const Vector3d half =
      h / 12.0 * (5.0 * u[0].gyro + 8.0 * u[1].gyro - u[2].gyro) + h * h / 12.0 * u[0].gyro.cross(u[1].gyro);
  const Vector3d full =
      H / 6.0 * (u[0].gyro + 4.0 * u[1].gyro + u[2].gyro) + H * H / 12.0 * u[0].gyro.cross(u[2].gyro);
  const Matrix3d R1 = s.R * math::so3_exp(half);
  const Matrix3d R2 = s.R * math::so3_exp(full);
  const Vector3d gravity(0, 0, -kGravity);
  const Vector3d a0 = s.R * u[0].accel + gravity;
  const Vector3d a1 = R1 * u[1].accel + gravity;
  const Vector3d a2 = R2 * u[2].accel + gravity;
  return {R2, s.p + H * s.v + H * H / 6.0 * (a0 + 2.0 * a1), s.v + H / 6.0 * (a0 + 4.0 * a1 + a2)};
}

double error_of_integration(const Motion& motion, double from, double length) {
  ImuConfig perfect;
  perfect.perfect = true;
  perfect.rate_hz = 200.0;
  const ImuModel imu(perfect, 1, from_seconds(from + length));
  const auto first = static_cast<std::int64_t>(200.0 * from);
  const auto last = first + static_cast<std::int64_t>(200.0 * length);
  const Kinematics start = motion.at(from);
  State state{start.T_world_imu.R, start.T_world_imu.t, start.velocity_world};
  for (std::int64_t i = first; i < last; i += 2) {
    state = after_two_steps(
        state, {imu.sample(motion, i), imu.sample(motion, i + 1), imu.sample(motion, i + 2)}, 1.0 / 200.0);
  }
  return (state.p - motion.at(from + length).T_world_imu.t).norm();
}

TEST(Carrier, PerfectSamplesIntegrateToTheTruthWithinAMillimetreInTenSeconds) {
  for (const Carrier carrier : kCarriers) {
    const auto motion = motion_of(carrier);
    // From standing, across the stop, and on the way.
    for (const double from : {0.0, 20.0, 35.0, 50.0})
      EXPECT_LT(error_of_integration(*motion, from, 10.0), 1e-3) << name_of(carrier) << " from " << from;
  }
}

TEST(Carrier, PerfectSamplesIntegrateToTheTruthWithinFiveCentimetresInAMinute) {
  for (const Carrier carrier : kCarriers) {
    const auto motion = motion_of(carrier);
    for (const double from : {0.0, 10.0, 40.0}) {
      const double error = error_of_integration(*motion, from, 60.0);
      EXPECT_LT(error, 0.05) << name_of(carrier) << " from " << from;
    }
  }
}

// Steps of 1e-4 s: central differences err by h^2/6 times the third derivative, which is below 500 m/s^4.
TEST(Carrier, RatesAreTheDerivativesOfThePose) {
  constexpr double h = 1e-4;
  for (const Carrier carrier : kCarriers) {
    const auto motion = motion_of(carrier);
    for (double t = 0.1; t < 60.0; t += 0.0617) {
      const Kinematics before = motion->at(t - h), now = motion->at(t), after = motion->at(t + h);
      const Vector3d v = (after.T_world_imu.t - before.T_world_imu.t) / (2.0 * h);
      const Vector3d a = (after.velocity_world - before.velocity_world) / (2.0 * h);
      const Matrix3d turn = before.T_world_imu.R.transpose() * after.T_world_imu.R;
      const Vector3d w = math::so3_log(turn) / (2.0 * h);
      EXPECT_LT((now.velocity_world - v).norm(), 1e-5) << name_of(carrier) << " at " << t;
      EXPECT_LT((now.acceleration_world - a).norm(), 1e-5) << name_of(carrier) << " at " << t;
      EXPECT_LT((now.angular_rate_imu - w).norm(), 1e-5) << name_of(carrier) << " at " << t;
    }
  }
}

// Of a function that is smooth of this order, the fourth difference over steps h shrinks like h^4; a jump
// in the third derivative would make it shrink like h^3 only.
TEST(Carrier, SpeedChangesSmoothlyUpToTheFourthDerivativeOfTheWay) {
  const auto fourth = [](double t, double h) {
    const auto f = [](double s) { return smooth_start({s, 1.0, 0.0}).value; };
    return (f(t - 2 * h) - 4 * f(t - h) + 6 * f(t) - 4 * f(t + h) + f(t + 2 * h)) / std::pow(h, 4);
  };
  for (const double joint : {0.0, 1.0}) {
    // The fourth derivative, 840 s^2 (...) - ..., passes through 0 at both joints.
    EXPECT_NEAR(fourth(joint, 1e-2), 0.0, 15.0);
    EXPECT_NEAR(fourth(joint, 1e-3), 0.0, 1.5);
  }
  EXPECT_EQ(smooth_step({1.0, 1.0, 0.0}).value, 1.0);
  EXPECT_NEAR(smooth_step({1.0 - 1e-9, 1.0, 0.0}).value, 1.0, 1e-12);
  EXPECT_EQ(smooth_hump({0.5, 1.0, 0.0}).value, 1.0);
  EXPECT_NEAR(smooth_start({1.0 - 1e-9, 1.0, 0.0}).value, 0.5, 2e-9);
}

TEST(Carrier, StandsDuringAStopAndReachesItsSpeedAgain) {
  for (const Carrier carrier : kCarriers) {
    const TrajectoryConfig config = config_of(carrier).resolved();
    const auto motion = motion_of(carrier);
    const Vector3d place = motion->at(kStopAt).T_world_imu.t;
    for (double t = kStopAt; t <= kStopAt + kStopFor; t += 0.1) {
      const Kinematics now = motion->at(t);
      // Rounding of times alone.
      EXPECT_LT((now.T_world_imu.t - place).norm(), 1e-12);
      EXPECT_LT(now.velocity_world.norm(), 1e-12);
      EXPECT_LT(now.acceleration_world.norm(), 1e-12);
      EXPECT_LT(now.angular_rate_imu.norm(), 1e-12);
    }
    EXPECT_GT(motion->at(kStopAt - config.ramp).velocity_world.norm(), 0.3 * config.speed);
    EXPECT_GT(motion->at(kStopAt + kStopFor + config.ramp).velocity_world.norm(), 0.3 * config.speed);
  }
}

TEST(Carrier, FillsInWhatIsLeftAtItsDefault) {
  TrajectoryConfig config;
  config.carrier = Carrier::kDrone;
  config.height = 5.0;
  EXPECT_EQ(config.resolved().height, 5.0);
  EXPECT_EQ(config.resolved().speed, 2.5);
  EXPECT_EQ(config.resolved().stand_still, config.stand_still);
  config.carrier = Carrier::kCustom;
  EXPECT_EQ(config.resolved().speed, TrajectoryConfig{}.speed);
}

std::string error_of(std::vector<Stop> stops) {
  SimulationConfig config;
  config.duration = 60.0;
  config.trajectory.stand_still = 3.0;
  config.trajectory.ramp = 2.0;
  config.trajectory.stops = std::move(stops);
  const Status status = validate(config, "x");
  return status.ok() ? "accepted" : status.error().message;
}

TEST(Carrier, StopsThatOverlapOrLieOutsideAreRefusedInOneLine) {
  EXPECT_EQ(error_of({{30, 5}, {7, 5}}), "accepted");
  EXPECT_EQ(error_of({{55, 5}}), "accepted");
  EXPECT_EQ(error_of({{56, 5}}),
            "x: trajectory.stops: the stop at 56 s for 5 s lies outside of the recording, which lasts 60 s; "
            "let it end within");
  EXPECT_EQ(error_of({{20, 5}, {28, 2}}),
            "x: trajectory.stops: the stop at 28 s overlaps the stop at 20 s for 5 s: slowing down takes 2 s "
            "(trajectory.ramp), so it can begin at 29 s");
  EXPECT_EQ(error_of({{4, 2}}),
            "x: trajectory.stops: the stop at 4 s overlaps the start: slowing down takes 2 s "
            "(trajectory.ramp), so it can begin at 7 s");
}

}  // namespace
}  // namespace mmlins::sim

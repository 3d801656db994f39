// SPDX-License-Identifier: MIT
// What every built-in sensor measures, against its table and a world known in closed form.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/sim/lidar_model.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;
constexpr double kNoise = 0.02;  // [m]

// An even room of 20 x 16 x 6 m.
ShapeWorld even_room() {
  return ShapeWorld({make_box({10.5, 0, 2}, {1, 30, 8}, 0, 0.6), make_box({-10.5, 0, 2}, {1, 30, 8}, 0, 0.6),
                     make_box({0, 8.5, 2}, {30, 1, 8}, 0, 0.6), make_box({0, -8.5, 2}, {30, 1, 8}, 0, 0.6),
                     make_box({0, 0, 6.5}, {30, 30, 1}, 0, 0.6)},
                    {});
}

double distance_in_room(const Vector3d& p) {
  return std::min({std::abs(10.0 - std::abs(p.x())), std::abs(8.0 - std::abs(p.y())), std::abs(p.z()),
                   std::abs(6.0 - p.z())});
}

std::unique_ptr<Motion> moving(double stand_still) {
  TrajectoryConfig trajectory;
  trajectory.semi_axis_x = 5.0;
  trajectory.semi_axis_y = 4.0;
  trajectory.speed = 2.5;
  trajectory.look_deg = 40.0;
  trajectory.look_hz = 0.4;
  trajectory.stand_still = stand_still;
  return make_motion(trajectory, {});
}

LidarConfig sensor_of(const std::string& model, double noise) {
  LidarConfig config;
  config.model = model;
  config.range_noise = noise;
  config.laser_bias = config.dropout = config.mixed_pixels = config.range_step = 0.0;
  return config;
}

SimulatedScan scan_at(const LidarConfig& config, const Motion& motion, double seconds) {
  const LidarModel lidar(config, 17);
  return lidar.scan(even_room(), motion, from_seconds(seconds), from_seconds(seconds) + lidar.period());
}

TEST(EverySensor, RangesOfAStandingScanHaveTheDeclaredMeanAndDeviation) {
  const auto motion = moving(100.0);
  for (const NamedText& text : sensor_texts()) {
    const SimulatedScan made = scan_at(sensor_of(text.name, kNoise), *motion, 1.0);
    const auto n = static_cast<double>(made.scan.size());
    ASSERT_GT(n, 5000.0) << text.name;
    double sum = 0.0, square = 0.0;
    for (std::size_t i = 0; i < made.scan.size(); ++i) {
      const double error =
          made.scan.points[i].cast<double>().norm() - static_cast<double>(made.truth.ranges[i]);
      sum += error;
      square += error * error;
    }
    EXPECT_NEAR(sum / n, 0.0, 4.0 * kNoise / std::sqrt(n)) << text.name;
    EXPECT_NEAR(std::sqrt(square / n) / kNoise, 1.0, 4.0 / std::sqrt(2.0 * n)) << text.name;
  }
}

TEST(EverySensor, RingsAndFiringTimesAreThoseOfTheTable) {
  const auto motion = moving(100.0);
  for (const NamedText& text : sensor_texts()) {
    const SensorTable table = *load_sensor_table(text.name);
    if (table.pattern != PatternKind::kSpinning) continue;
    std::vector<std::size_t> by_ring(table.lasers.size());
    for (std::size_t i = 0; i < by_ring.size(); ++i) by_ring[i] = i;
    std::stable_sort(by_ring.begin(), by_ring.end(), [&](auto a, auto b) {
      return table.lasers[a].elevation_deg < table.lasers[b].elevation_deg;
    });
    const SimulatedScan made = scan_at(sensor_of(text.name, 0.0), *motion, 1.0);
    ASSERT_GT(made.scan.size(), 5000U) << text.name;
    const double start_us = 1e-3 * static_cast<double>(to_ns(made.scan.start_time));
    for (std::size_t i = 0; i < made.scan.size(); ++i) {
      const std::size_t laser = by_ring[made.scan.rings[i]];
      const Vector3d p = made.scan.points[i].cast<double>();
      // The beam starts at some distance from the axis, in the direction of the rotor.
      const double aside = table.lasers[laser].azimuth_deg / kDegPerRad;
      const double across = p.head<2>().norm(), start = table.beam_origin;
      const double along =
          std::sqrt(across * across - std::pow(start * std::sin(aside), 2)) - start * std::cos(aside);
      ASSERT_NEAR(std::atan2(p.z(), along) * kDegPerRad, table.lasers[laser].elevation_deg, 1e-4)
          << text.name;
      const auto firing = static_cast<double>(laser / static_cast<std::size_t>(table.lasers_at_once));
      const double column =
          (start_us + 1e6 * static_cast<double>(made.scan.offsets[i]) - firing * table.laser_period_us) /
          table.column_period_us;
      // Single precision of 0.1 s resolves 7 ns.
      ASSERT_NEAR((column - std::round(column)) * table.column_period_us, 0.0, 0.008) << text.name;
    }
  }
}

double residual(const std::string& model, const Motion& motion, double seconds) {
  const LidarConfig config = sensor_of(model, kNoise);
  const SimulatedScan made = scan_at(config, motion, seconds);
  const double start = to_seconds(made.scan.start_time.time_since_epoch());
  double square = 0.0;
  for (std::size_t i = 0; i < made.scan.size(); ++i) {
    const double time = start + static_cast<double>(made.scan.offsets[i]);
    const Vector3d p_imu = config.T_imu_lidar() * made.scan.points[i].cast<double>();
    square += std::pow(distance_in_room(motion.at(time).T_world_imu * p_imu), 2);
  }
  return std::sqrt(square / static_cast<double>(made.scan.size()));
}

// The residual is the noise times the cosine of incidence, whose mean differs a little between the places
// from which a scan is taken: the standing one is taken where the moving one is.
TEST(EverySensor, AMovingScanPlacedByTheTruthIsAsNearToTheWallsAsAStandingOne) {
  class Frozen : public Motion {
   public:
    explicit Frozen(Kinematics at) : at_(std::move(at)) {}
    Kinematics at(double) const override { return {at_.T_world_imu}; }

   private:
    Kinematics at_;
  };
  const auto motion = moving(0.0);
  for (const NamedText& text : sensor_texts()) {
    const double in_motion = residual(text.name, *motion, 5.0);
    const double standing = residual(text.name, Frozen(motion->at(5.05)), 5.0);
    EXPECT_NEAR(in_motion / standing, 1.0, 0.05) << text.name;
    EXPECT_LT(in_motion, kNoise) << text.name;
  }
}

TEST(EverySensor, BeamsOfTheOusterStartBesideItsAxis) {
  const SensorTable table = *load_sensor_table("os1_64");
  EXPECT_EQ(table.beam_origin, 0.012163);
  LidarConfig config = sensor_of("os1_64", 0.0);
  const auto motion = moving(100.0);
  const math::SE3 T_world_lidar = motion->at(1.0).T_world_imu * config.T_imu_lidar();
  for (const Eigen::Vector3f& p : scan_at(config, *motion, 1.0).scan.points)
    ASSERT_LT(distance_in_room(T_world_lidar * p.cast<double>()), 1e-5);
}

}  // namespace
}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/sim/lidar_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mmlins/sim/scan_pattern.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;
constexpr std::uint64_t kSeed = 17;

// An even box room of 20 x 16 x 6 m, open to no side, with the carrier in its middle.
ShapeWorld even_room() {
  return ShapeWorld({make_box({10.5, 0, 2}, {1, 30, 8}, 0, 0.6), make_box({-10.5, 0, 2}, {1, 30, 8}, 0, 0.6),
                     make_box({0, 8.5, 2}, {30, 1, 8}, 0, 0.6), make_box({0, -8.5, 2}, {30, 1, 8}, 0, 0.6),
                     make_box({0, 0, 6.5}, {30, 30, 1}, 0, 0.6)},
                    {});
}

// Distance from the nearest wall, floor or ceiling of even_room(), in closed form.
double distance_in_room(const Vector3d& p) {
  return std::min({std::abs(10.0 - std::abs(p.x())), std::abs(8.0 - std::abs(p.y())), std::abs(p.z()),
                   std::abs(6.0 - p.z())});
}

TrajectoryConfig walking(double stand_still) {
  TrajectoryConfig trajectory;
  trajectory.semi_axis_x = 5.0;
  trajectory.semi_axis_y = 4.0;
  trajectory.speed = 2.5;
  trajectory.look_deg = 40.0;
  trajectory.look_hz = 0.4;
  trajectory.stand_still = stand_still;
  return trajectory;
}

LidarConfig noise_free(const std::string& model) {
  LidarConfig config;
  config.model = model;
  config.range_noise = 0.0;
  config.laser_bias = 0.0;
  config.dropout = 0.0;
  config.range_step = 0.0;
  config.mixed_pixels = 0.0;
  return config;
}

SimulatedScan scan_at(const LidarConfig& config, const Motion& motion, double seconds) {
  const Duration begin = from_seconds(seconds);
  const LidarModel lidar(config, kSeed);
  return lidar.scan(even_room(), motion, begin, begin + lidar.period());
}

TEST(LidarModel, NoiseOfAStandingScanHasTheDeclaredMeanAndDeviation) {
  const auto motion = make_motion(walking(100.0), {});
  LidarConfig config;
  config.range_noise = 0.015;
  config.laser_bias = 0.0;
  const SimulatedScan made = scan_at(config, *motion, 1.0);
  const double n = static_cast<double>(made.scan.size());
  ASSERT_GT(n, 20'000);
  double sum = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < made.scan.size(); ++i) {
    const double error =
        static_cast<double>(made.scan.points[i].norm()) - static_cast<double>(made.truth.ranges[i]);
    sum += error;
    square += error * error;
  }
  EXPECT_NEAR(sum / n, 0.0, 4.0 * config.range_noise / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(square / n) / config.range_noise, 1.0, 4.0 / std::sqrt(2.0 * n));
}

TEST(LidarModel, NoiseFreePointsOfAStandingScanLieOnTheWalls) {
  const auto motion = make_motion(walking(100.0), {});
  for (const std::string model : {"vlp16", "mid360", "avia"}) {
    const LidarConfig config = noise_free(model);
    const math::SE3 T_world_lidar = motion->at(1.0).T_world_imu * config.T_imu_lidar();
    const SimulatedScan made = scan_at(config, *motion, 1.0);
    ASSERT_GT(made.scan.size(), 5000U);
    for (const Eigen::Vector3f& p_lidar : made.scan.points) {
      // Single precision at 20 m resolves 2e-6 m.
      ASSERT_LT(distance_in_room(T_world_lidar * p_lidar.cast<double>()), 1e-5);
    }
  }
}

TEST(LidarModel, PointsOfAMovingScanLieOnTheWallsWhenEachIsPlacedByItsOwnTime) {
  const auto motion = make_motion(walking(0.0), {});
  for (const std::string model : {"hdl32e", "os1_64", "mid360"}) {
    LidarConfig config = noise_free(model);
    config.q_imu_lidar_xyzw = {0.0, 0.1305262, 0.0, 0.9914449};
    const SimulatedScan made = scan_at(config, *motion, 5.0);
    double worst_at_own_time = 0.0;
    double worst_at_start = 0.0;
    for (std::size_t i = 0; i < made.scan.size(); ++i) {
      const double start = to_seconds(made.scan.start_time.time_since_epoch());
      const double own_time = start + static_cast<double>(made.scan.offsets[i]);
      const Vector3d p_imu = config.T_imu_lidar() * made.scan.points[i].cast<double>();
      worst_at_own_time =
          std::max(worst_at_own_time, distance_in_room(motion->at(own_time).T_world_imu * p_imu));
      worst_at_start = std::max(worst_at_start, distance_in_room(motion->at(start).T_world_imu * p_imu));
    }
    // Single precision of points and times, and poses carried on over 30 us.
    EXPECT_LT(worst_at_own_time, 2e-5);
    EXPECT_GT(worst_at_start, 0.1);  // the distortion is there
  }
}

TEST(LidarModel, RingsAndTimesFollowTheTableOfTheVlp16) {
  const auto motion = make_motion(walking(100.0), {});
  const SimulatedScan made = scan_at(noise_free("vlp16"), *motion, 1.0);
  const std::int64_t start_ns = to_ns(made.scan.start_time);
  for (std::size_t i = 0; i < made.scan.size(); ++i) {
    const Eigen::Vector3d p = made.scan.points[i].cast<double>();
    const int ring = made.scan.rings[i];
    EXPECT_NEAR(std::asin(p.z() / p.norm()) / kRadPerDeg, -15.0 + 2.0 * ring, 1e-4);
    // Rings fire in the order 0 8 1 9 ...
    const std::int64_t laser = ring < 8 ? 2 * ring : 2 * (ring - 8) + 1;
    const double columns =
        static_cast<double>(start_ns + from_seconds(static_cast<double>(made.scan.offsets[i])).count() -
                            laser * 2304) /
        55'296.0;
    EXPECT_NEAR(55'296.0 * (columns - std::round(columns)), 0.0,
                8.0);  // single precision of 0.1 s resolves 7 ns
  }
}

TEST(LidarModel, RotorIsNotLockedToTheScans) {
  const auto pattern = make_spinning({{0.0}, {}, Duration{0}, Duration{100'000}}, 10.03, 0.25);
  const auto first_azimuth = [&](double seconds) {
    const Beam beam = pattern->beams(from_seconds(seconds), from_seconds(seconds + 0.1)).front();
    return std::atan2(beam.direction.y(), beam.direction.x()) / kRadPerDeg;
  };
  // 0.003 turns per scan, clockwise.
  EXPECT_NEAR(first_azimuth(1.0) - first_azimuth(1.1), 0.003 * 360.0, 1e-6);
}

TEST(ScanPattern, NonRepetitiveSensorsStayInTheirFieldOfViewAndDoNotRepeat) {
  const auto mid360 = make_nodding({});
  const auto first = mid360->beams(from_seconds(1.0), from_seconds(1.1));
  const auto second = mid360->beams(from_seconds(1.1), from_seconds(1.2));
  ASSERT_EQ(first.size(), 20'000U);
  double apart = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double elevation = std::asin(first[i].direction.z()) / kRadPerDeg;
    EXPECT_GT(elevation, -7.5);
    EXPECT_LT(elevation, 52.5);
    apart += std::acos(std::min(1.0, first[i].direction.dot(second[i].direction))) / kRadPerDeg;
  }
  EXPECT_GT(apart / static_cast<double>(first.size()), 1.0);

  const auto avia = make_rosette({});
  for (const Beam& beam : avia->beams(from_seconds(1.0), from_seconds(1.1))) {
    EXPECT_LT(std::acos(beam.direction.x()) / kRadPerDeg, 36.0);
  }
}

TEST(LidarModel, EachLaserHasAConstantErrorOfItsOwn) {
  const auto motion = make_motion(walking(100.0), {});
  LidarConfig config = noise_free("hdl32e");
  config.laser_bias = 0.02;
  const SimulatedScan made = scan_at(config, *motion, 1.0);
  std::vector<double> bias(32, 0.0);
  for (std::size_t i = 0; i < made.scan.size(); ++i) {
    const double error =
        static_cast<double>(made.scan.points[i].norm()) - static_cast<double>(made.truth.ranges[i]);
    double& known = bias[made.scan.rings[i]];
    if (known == 0.0) known = error;
    EXPECT_NEAR(error, known, 1e-5);  // single precision
  }
  double square = 0.0;
  for (const double b : bias) square += b * b;
  EXPECT_NEAR(std::sqrt(square / 32.0), 0.02, 4.0 * 0.02 / std::sqrt(64.0));
}

TEST(LidarModel, DropsTheDeclaredShareOfShots) {
  const auto motion = make_motion(walking(100.0), {});
  LidarConfig config = noise_free("vlp16");
  const auto all = static_cast<double>(scan_at(config, *motion, 1.0).scan.size());
  config.dropout = 0.3;
  const auto left = static_cast<double>(scan_at(config, *motion, 1.0).scan.size());
  EXPECT_NEAR(left / all, 0.7, 4.0 * std::sqrt(0.3 * 0.7 / all));
}

TEST(LidarModel, ReturnsNothingOutsideItsRange) {
  const auto motion = make_motion(walking(100.0), {});
  LidarConfig config;
  config.min_range = 3.0;
  config.max_range = 6.0;
  const SimulatedScan made = scan_at(config, *motion, 1.0);
  ASSERT_GT(made.scan.size(), 1000U);
  for (const Eigen::Vector3f& p : made.scan.points) {
    EXPECT_GT(p.norm(), 3.0F - 1e-5F);
    EXPECT_LT(p.norm(), 6.0F + 1e-5F);
  }
}

}  // namespace
}  // namespace mmlins::sim

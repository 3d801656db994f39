// SPDX-License-Identifier: MIT
#include "mmlins/sim/sensor_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "mmlins/base/text_file.hpp"
#include "mmlins/sim/lidar_tables.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

constexpr double kDegPerRad = 180.0 / std::numbers::pi;

/// The beams of the first two columns of a sensor.
std::vector<Beam> first_beams(const std::string& model) {
  LidarConfig config;
  config.model = model;
  config.rotor_slip = 0.0;
  const SensorTable table = *load_sensor_table(model);
  const Duration two_columns = from_seconds(2e-6 * table.column_period_us);
  return make_pattern(config, table, 1)->beams(Duration{0}, two_columns);
}

double elevation_of(const Beam& beam) { return std::asin(beam.direction.z()) * kDegPerRad; }
double azimuth_of(const Beam& beam) {
  return std::atan2(beam.direction.y(), beam.direction.x()) * kDegPerRad;
}

TEST(SensorTable, AllBuiltInOnesLoadAndSayWhatTheyAre) {
  std::map<std::string, std::size_t> lasers;
  for (const NamedText& text : sensor_texts()) {
    const auto table = load_sensor_table(text.name);
    ASSERT_TRUE(table.ok()) << table.error().message;
    EXPECT_TRUE(text.yaml.starts_with("# ")) << text.name;
    lasers[text.name] = table->lasers.size();
  }
  const std::map<std::string, std::size_t> expected{{"vlp16", 16}, {"vlp32c", 32}, {"hdl32e", 32},
                                                    {"rs16", 16},  {"os1_64", 64}, {"mid360", 0},
                                                    {"avia", 6}};
  EXPECT_EQ(lasers, expected);
}

// The manual's firing sequence: 2.304 us from laser to laser, 55.296 us from sequence to sequence.
TEST(SensorTable, Vlp16FiresInTheOrderAndAtTheTimesOfItsManual) {
  const std::vector<Beam> beams = first_beams("vlp16");
  ASSERT_EQ(beams.size(), 32U);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const std::size_t laser = i % 16;
    EXPECT_EQ(beams[i].time.count(),
              static_cast<std::int64_t>(i / 16) * 55'296 + static_cast<std::int64_t>(laser) * 2304);
    const double elevation = laser % 2 == 0 ? -15.0 + static_cast<double>(laser) : static_cast<double>(laser);
    EXPECT_NEAR(elevation_of(beams[i]), elevation, 1e-9);
  }
}

TEST(SensorTable, Vlp32cFiresInPairsWhoseLasersLookAside) {
  const std::vector<Beam> beams = first_beams("vlp32c");
  ASSERT_EQ(beams.size(), 64U);
  for (std::size_t i = 0; i + 1 < 32; i += 2) {
    EXPECT_EQ(beams[i].time, beams[i + 1].time);
    EXPECT_EQ(beams[i].time.count(), static_cast<std::int64_t>(i / 2) * 2304);
  }
  // Of the first pair, -25 degrees at +1.4 and -1 degrees at -4.2: 5.6 degrees apart.
  EXPECT_NEAR(elevation_of(beams[0]), -25.0, 1e-9);
  EXPECT_NEAR(elevation_of(beams[1]), -1.0, 1e-9);
  EXPECT_NEAR(std::remainder(azimuth_of(beams[0]) - azimuth_of(beams[1]), 360.0), 5.6, 1e-6);
}

TEST(SensorTable, AUserAddsASensorByWritingATable) {
  const std::string path =
      (std::filesystem::temp_directory_path() / "mmlins_sensor_table_test.yaml").string();
  ASSERT_TRUE(write_text_file(path,
                              "lasers: [{elevation_deg: -5}, {elevation_deg: 5}]\nlaser_period_us: 10\n"
                              "column_period_us: 50\nfarthest: 33\n")
                  .ok());
  const auto table = load_sensor_table(path);
  ASSERT_TRUE(table.ok()) << table.error().message;
  EXPECT_EQ(table->farthest, 33.0);
  const std::vector<Beam> beams = first_beams(path);
  ASSERT_EQ(beams.size(), 4U);
  EXPECT_EQ(beams[3].time.count(), 60'000);
}

TEST(SensorTable, UnknownSensorsAndImpossibleTablesAreRefusedInOneLine) {
  const std::string path = (std::filesystem::temp_directory_path() / "mmlins_sensor_table_bad.yaml").string();
  const std::map<std::string, std::string> faults{
      {"lasers: []\n", "lasers"},
      {"lasers: [{elevation_deg: 1}]\nnearest: 20\nfarthest: 10\n", "nearest"},
      {"lasers: [{elevation_deg: 1}, {elevation_deg: 2}]\nlaser_period_us: 60\n", "column_period_us"},
      {"lasers: [{elevaton_deg: 1}]\n", "elevation_deg"}};
  for (const auto& [text, word] : faults) {
    ASSERT_TRUE(write_text_file(path, text).ok());
    const auto table = load_sensor_table(path);
    ASSERT_FALSE(table.ok()) << text;
    EXPECT_NE(table.error().message.find(word), std::string::npos) << table.error().message;
    EXPECT_NE(table.error().message.find(path), std::string::npos) << table.error().message;
  }
  const auto unknown = load_sensor_table("vlp17");
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("vlp16"), std::string::npos);
}

// A wall at 5 m with its edge in the middle of the view, and another one behind it at 6 m.
SimulatedScan scan_of_an_edge(const LidarConfig& config) {
  const ShapeWorld world(
      {make_box({5.5, 10, 1}, {1, 20, 9}, 0, 0.8), make_box({6.5, 0, 1}, {1, 40, 9}, 0, 0.8)}, {});
  TrajectoryConfig standing;
  standing.stand_still = 100.0;
  standing.semi_axis_x = standing.semi_axis_y = 0.5;
  const auto motion = make_motion(standing, {});
  return LidarModel(config, 3).scan(world, *motion, Duration{0}, from_seconds(0.5));
}

LidarConfig exact_sensor() {
  LidarConfig config;
  config.range_noise = config.laser_bias = config.dropout = config.mixed_pixels = 0.0;
  config.range_step = 0.0;
  return config;
}

TEST(LidarModel, RangesAreMultiplesOfTheRangeStep) {
  LidarConfig config = exact_sensor();
  config.range_step = 0.004;
  config.range_noise = 0.01;
  for (const Eigen::Vector3f& point : scan_of_an_edge(config).scan.points) {
    const double range = point.cast<double>().norm();
    EXPECT_NEAR(range, 0.004 * std::round(range / 0.004), 2e-6);  // single precision at 20 m
  }
}

TEST(LidarModel, BeamsOnAnEdgeMayReturnARangeBetween) {
  LidarConfig config = exact_sensor();
  const auto num_between = [](const SimulatedScan& made) {
    int count = 0;
    for (std::size_t i = 0; i < made.scan.size(); ++i) {
      const double error =
          static_cast<double>(made.scan.points[i].norm()) - static_cast<double>(made.truth.ranges[i]);
      count += std::abs(error) > 1e-4;
      EXPECT_LT(std::abs(error), 1.5);
    }
    return count;
  };
  EXPECT_EQ(num_between(scan_of_an_edge(config)), 0);
  config.mixed_pixels = 1.0;
  const SimulatedScan mixed = scan_of_an_edge(config);
  const int between = num_between(mixed);
  EXPECT_GT(between, 10);
  EXPECT_LT(between, static_cast<int>(mixed.scan.size() / 50));  // only at the edges
}

}  // namespace
}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/sim/simulation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <map>

#include "mmlins/base/parallel.hpp"
#include "mmlins/sim/rides.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

SimulationConfig small(int seed = 3) {
  SimulationConfig config;
  config.duration = 2.5;
  config.seed = seed;
  config.sensor.columns = 180;
  config.trajectory.stand_still = 0.5;
  config.trajectory.ramp = 0.5;
  return config;
}

struct Recording {
  sensor::ImuSamples imu;
  std::vector<sensor::LidarScan> scans;
};

Recording record(Simulation& simulation) {
  Recording recording;
  while (true) {
    const auto item = simulation.next();
    EXPECT_TRUE(item.ok());
    if (const auto* sample = std::get_if<sensor::ImuSample>(&*item)) recording.imu.push_back(*sample);
    if (const auto* scan = std::get_if<sensor::LidarScan>(&*item)) recording.scans.push_back(*scan);
    if (std::holds_alternative<sensor::EndOfData>(*item)) return recording;
  }
}

Recording record(const SimulationConfig& config) {
  Simulation simulation(config);
  return record(simulation);
}

bool same_data(const Recording& a, const Recording& b) {
  if (a.imu.size() != b.imu.size() || a.scans.size() != b.scans.size()) return false;
  for (std::size_t i = 0; i < a.imu.size(); ++i) {
    if (a.imu[i].time != b.imu[i].time || a.imu[i].gyro != b.imu[i].gyro || a.imu[i].accel != b.imu[i].accel)
      return false;
  }
  for (std::size_t i = 0; i < a.scans.size(); ++i) {
    if (a.scans[i].start_time != b.scans[i].start_time || a.scans[i].points != b.scans[i].points ||
        a.scans[i].offsets != b.scans[i].offsets || a.scans[i].intensities != b.scans[i].intensities) {
      return false;
    }
  }
  return true;
}

TEST(Simulation, SameSeedGivesTheSameDataWhateverTheNumberOfThreads) {
  parallel::set_num_threads(1);
  const Recording alone = record(small());
  parallel::set_num_threads(3);
  const Recording together = record(small());
  parallel::set_num_threads(0);
  EXPECT_TRUE(same_data(alone, together));
}

TEST(Simulation, AnotherSeedGivesOtherData) {
  const Recording one = record(small(3));
  const Recording other = record(small(4));
  EXPECT_FALSE(one.scans.front().points == other.scans.front().points);
  EXPECT_NE(one.imu.front().gyro, other.imu.front().gyro);
}

TEST(Simulation, ItemsComeInTheOrderOfTheirRecordTime) {
  Simulation simulation(small());
  Time last_record = simulation.start_time();
  Time last_imu = simulation.start_time() - Duration{1};
  int num_scans = 0;
  while (true) {
    const auto item = simulation.next();
    ASSERT_TRUE(item.ok());
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    EXPECT_GE(simulation.record_time(), last_record);
    last_record = simulation.record_time();
    if (const auto* sample = std::get_if<sensor::ImuSample>(&*item)) {
      EXPECT_GT(sample->time, last_imu);
      last_imu = sample->time;
    } else {
      const auto& scan = std::get<sensor::LidarScan>(*item);
      ++num_scans;
      EXPECT_GE(simulation.record_time(), scan.end_time);
      EXPECT_GE(last_imu, scan.end_time);  // all IMU samples up to the scan's end came before it
    }
  }
  EXPECT_EQ(num_scans, 24);  // 2.5 s at 10 Hz, the first one from 53 ms on
  EXPECT_DOUBLE_EQ(simulation.progress(), 1.0);
}

TEST(Simulation, StampsHaveTheDeclaredRatesAndScansDoNotOverlap) {
  const Recording recording = record(small());
  ASSERT_EQ(recording.imu.size(), 501U);
  for (std::size_t i = 1; i < recording.imu.size(); ++i) {
    EXPECT_EQ((recording.imu[i].time - recording.imu[i - 1].time).count(), 5'000'000);
  }
  for (std::size_t i = 0; i < recording.scans.size(); ++i) {
    const sensor::LidarScan& scan = recording.scans[i];
    EXPECT_EQ(scan.offsets.front(), 0.0F);
    EXPECT_TRUE(std::is_sorted(scan.offsets.begin(), scan.offsets.end()));
    EXPECT_NEAR(to_seconds(scan.end_time - scan.start_time), 0.1, 1e-3);  // columns of 0.56 ms
    if (i == 0) continue;
    EXPECT_GT(scan.start_time, recording.scans[i - 1].end_time);
    EXPECT_NEAR(to_seconds(scan.start_time - recording.scans[i - 1].start_time), 0.1, 1e-3);
  }
}

TEST(Simulation, MovingNoiseFreeScansLieOnTheUnevenWorldWhenPlacedByTheTruth) {
  SimulationConfig config = small();
  config.sensor.range_noise = 0.0;
  config.sensor.laser_bias = 0.0;
  config.sensor.range_step = 0.0;
  config.sensor.mixed_pixels = 0.0;
  Simulation simulation(config);
  double worst = 0.0;
  while (true) {
    const auto item = simulation.next();
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    const auto* scan = std::get_if<sensor::LidarScan>(&*item);
    if (scan == nullptr) continue;
    for (std::size_t i = 0; i < scan->size(); ++i) {
      const Time time = scan->start_time + from_seconds(static_cast<double>(scan->offsets[i]));
      const Vector3d p_world =
          simulation.T_world_imu(time) * (simulation.rig().T_imu_lidar() * scan->points[i].cast<double>());
      worst = std::max(
          worst, std::abs(simulation.distance_to_surface(p_world, simulation.scan_truth().surfaces[i])));
    }
  }
  EXPECT_LT(worst, 2e-5);  // single precision of points and times
}

TEST(Simulation, TruthAgreesWithItselfInEveryForm) {
  const Simulation simulation(small());
  const math::Trajectory truth = simulation.truth(100.0);
  ASSERT_EQ(truth.size(), 251U);
  EXPECT_EQ(truth.front().time, simulation.start_time());
  EXPECT_EQ(truth.back().time, simulation.end_time());
  for (const math::StampedPose& stamped : truth) {
    EXPECT_EQ(simulation.T_world_imu(stamped.time).t, stamped.pose.t);
  }
  // Velocity in the world frame, although the motion was made in the frame of the scene.
  const Time time = simulation.start_time() + from_seconds(2.0);
  const Duration h = from_seconds(1e-4);
  const Vector3d numeric = (simulation.T_world_imu(time + h).t - simulation.T_world_imu(time - h).t) / 2e-4;
  EXPECT_LT((simulation.velocity_world(time) - numeric).norm(), 1e-5);
}

TEST(Scenario, AllBuiltInOnesAreValidAndSayWhatTheyAre) {
  const std::vector<ScenarioText> scenarios = scenario_texts();
  ASSERT_GE(scenarios.size(), 11U);
  for (const ScenarioText& scenario : scenarios) {
    const auto config = load_scenario(scenario.name);
    EXPECT_TRUE(config.ok()) << config.error().message;
    EXPECT_FALSE(summary_of(scenario).empty()) << scenario.name;
  }
}

// What is held out must not be seen during development, under another name either. Within either set, a
// scenario may have twins with and without events.
TEST(Scenario, NothingHeldOutSharesItsWorldOrNoiseWithAnythingElse) {
  std::map<int, bool> worlds;
  std::map<int, bool> seeds;
  for (const ScenarioText& scenario : scenario_texts()) {
    const auto config = load_scenario(scenario.name);
    ASSERT_TRUE(config.ok());
    const bool held_out = scenario.name.starts_with("heldout");
    const int world = 100 * config->world.seed + static_cast<int>(config->world.scene);
    EXPECT_EQ(worlds.emplace(world, held_out).first->second, held_out) << scenario.name;
    EXPECT_EQ(seeds.emplace(config->seed, held_out).first->second, held_out) << scenario.name;
    EXPECT_EQ(held_out, scenario.yaml.find("HELD OUT") != std::string::npos) << scenario.name;
  }
}

TEST(Scenario, NoPathLeadsThroughAnything) {
  constexpr double kReach = 0.35;  // [m]
  for (const ScenarioText& scenario : scenario_texts()) {
    const auto config = load_scenario(scenario.name);
    ASSERT_TRUE(config.ok());
    const Simulation simulation(*config);
    const math::Trajectory truth = simulation.truth(5.0);
    for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
      const Vector3d here = truth[i].pose.t;
      const Vector3d step = truth[i + 1].pose.t - here;
      // An elevator passes through floors.
      const double seconds = to_seconds(truth[i].time - simulation.start_time());
      if (holds(config->events, degrade::EventKind::kElevator, seconds)) continue;
      if (step.norm() > 1e-6) {
        ASSERT_FALSE(simulation.cast({here, step.normalized()}, step.norm()).has_value())
            << scenario.name << " after " << to_seconds(truth[i].time - simulation.start_time()) << " s";
      }
      for (int k = 0; k < 12; ++k) {
        const double angle = k * std::numbers::pi / 6.0;
        ASSERT_FALSE(simulation.cast({here, {std::cos(angle), std::sin(angle), 0.0}}, kReach).has_value())
            << scenario.name << " after " << to_seconds(truth[i].time - simulation.start_time()) << " s";
      }
    }
  }
}

TEST(Scenario, MisspeltNamesGetTheNearestRightOne) {
  const auto config = load_scenario("dev_hal16");
  ASSERT_FALSE(config.ok());
  EXPECT_NE(config.error().message.find("'dev_hall16'"), std::string::npos) << config.error().message;
}

TEST(Scenario, StandingStillForTheWholeTimeIsRefused) {
  const auto config = load_scenario("demo", {"trajectory.stand_still=40"});
  ASSERT_FALSE(config.ok());
  EXPECT_NE(config.error().message.find("stand_still"), std::string::npos) << config.error().message;
}

}  // namespace
}  // namespace mmlins::sim

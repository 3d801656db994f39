// SPDX-License-Identifier: MIT
// Events inside of a simulated recording.

#include <gtest/gtest.h>

#include "mmlins/sim/scenario.hpp"
#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {
namespace {

using degrade::EventKind;

SimulationConfig small(std::vector<degrade::EventSpec> events) {
  SimulationConfig config;
  config.duration = 2.5;
  config.sensor.columns = 180;
  config.trajectory.stand_still = 0.5;
  config.trajectory.ramp = 0.5;
  config.events = std::move(events);
  return config;
}

struct Recorded {
  sensor::LidarScan scan;
  ScanTruth truth;
};

std::vector<Recorded> scans_of(const SimulationConfig& config, Simulation& simulation) {
  EXPECT_TRUE(validate(config, "test").ok());
  std::vector<Recorded> scans;
  while (true) {
    const auto item = simulation.next();
    EXPECT_TRUE(item.ok());
    if (const auto* scan = std::get_if<sensor::LidarScan>(&*item)) {
      scans.push_back({*scan, simulation.scan_truth()});
    }
    if (std::holds_alternative<sensor::EndOfData>(*item)) return scans;
  }
}

std::vector<Recorded> scans_of(const SimulationConfig& config) {
  Simulation simulation(config);
  return scans_of(config, simulation);
}

TEST(SimulatedEvents, ABlackoutRemovesThePointsOfItsTimeAndNoOthers) {
  const auto clean = scans_of(small({}));
  const auto dark = scans_of(small({{EventKind::kBlackout, 1.0, 0.5, 0.0}}));
  ASSERT_EQ(dark.size(), clean.size());
  const Time begin = Simulation(small({})).start_time() + from_seconds(1.0);
  for (std::size_t i = 0; i < clean.size(); ++i) {
    std::vector<Eigen::Vector3f> expected;
    const std::vector<Time> times = degrade::point_times(clean[i].scan);
    for (std::size_t k = 0; k < times.size(); ++k) {
      const bool active = times[k] >= begin && times[k] < begin + from_seconds(0.5);
      if (!active) expected.push_back(clean[i].scan.points[k]);
    }
    EXPECT_EQ(dark[i].scan.points, expected);
    EXPECT_EQ(dark[i].truth.ranges.size(), expected.size());
  }
}

TEST(SimulatedEvents, LostPacketsLeaveAGapBetweenScans) {
  const auto scans = scans_of(small({{EventKind::kPacketLoss, 0.8, 1.0, 1.0}}));
  double longest = 0.0;
  for (std::size_t i = 1; i < scans.size(); ++i) {
    EXPECT_FALSE(scans[i].scan.points.empty());
    longest = std::max(longest, to_seconds(scans[i].scan.start_time - scans[i - 1].scan.end_time));
  }
  EXPECT_NEAR(longest, 1.0, 1e-3);  // a column is fired every half millisecond
}

TEST(SimulatedEvents, AMembraneIsOnNoSurfaceOfTheWorldAndStaysBeyondTheMinimumRange) {
  SimulationConfig config = small({{EventKind::kBag, 1.0, 1.0, 1.0}});
  const auto scans = scans_of(config);
  const Recorded& covered = scans.at(14);  // from 1.453 s on
  ASSERT_GT(covered.scan.size(), 100U);
  for (std::size_t i = 0; i < covered.scan.size(); ++i) {
    EXPECT_EQ(covered.truth.surfaces[i], -1);
    EXPECT_GE(covered.scan.points[i].norm(), config.sensor.nearest() - 1e-5);
    EXPECT_LT(covered.scan.points[i].norm(), 1.6);
  }
}

TEST(SimulatedEvents, EventsAreReadFromAScenarioAndFromTheCommandLine) {
  const auto config = load_scenario("demo", {"events=[{kind: bag, start: 5, duration: 2, severity: 0.4}]"});
  ASSERT_TRUE(config.ok()) << config.error().message;
  ASSERT_EQ(config->events.size(), 1U);
  EXPECT_EQ(config->events[0].kind, EventKind::kBag);
  EXPECT_EQ(config->events[0].severity, 0.4);
}

TEST(SimulatedEvents, AnEventOutsideOfTheRecordingIsRefused) {
  const auto config = load_scenario("demo", {"events=[{kind: bag, start: 29, duration: 2}]"});
  ASSERT_FALSE(config.ok());
  EXPECT_EQ(
      config.error().message,
      "demo: event bag:29:2:0.6 lies outside of the recording, which lasts 30.000 s; let it begin and end "
      "within");
}

}  // namespace
}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
// People and cars that move about.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mmlins/sim/mover_planner.hpp"
#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

struct Place {
  SceneKind scene;
  Carrier carrier;
  int fewest;  // movers of 20 that find a lane
};
const std::vector<Place>& places() {
  static const std::vector<Place> list{
      {SceneKind::kHall, Carrier::kHandheld, 15},     {SceneKind::kOffice, Carrier::kQuadruped, 10},
      {SceneKind::kCorridor, Carrier::kHandheld, 10}, {SceneKind::kYard, Carrier::kDrone, 15},
      {SceneKind::kCampus, Carrier::kVehicle, 10},    {SceneKind::kStreet, Carrier::kVehicle, 3},
      {SceneKind::kUrban, Carrier::kVehicle, 3},      {SceneKind::kTunnel, Carrier::kVehicle, 3}};
  return list;
}

SimulationConfig config_at(const Place& place) {
  SimulationConfig config;
  config.duration = 60.0;
  config.world.scene = place.scene;
  config.world.movers = 20;
  config.trajectory.carrier = place.carrier;
  config.trajectory.style = PathStyle::kRoute;
  return config;
}

std::string name_of(const Place& place) { return scene_names()[static_cast<std::size_t>(place.scene)]; }

TEST(Movers, NobodyComesNearTheCarrierInAMinute) {
  for (const Place& place : places()) {
    const SimulationConfig config = config_at(place);
    ASSERT_TRUE(validate(config, "x").ok());
    const Simulation simulation(config);
    const math::SE3 T_scene_world = config.world.T_world_scene().inverse();
    EXPECT_GE(static_cast<int>(simulation.movers().size()), place.fewest) << name_of(place);
    double nearest = 1e9;
    for (double t = 0.0; t < config.duration; t += 0.02) {
      const Vector3d carrier =
          T_scene_world * simulation.T_world_imu(simulation.start_time() + from_seconds(t)).t;
      for (const Mover& mover : simulation.movers()) {
        const auto at = mover.place(mover_instant(t));
        if (!at) continue;
        const double distance = mover.distance_from_body(carrier.head<2>(), *at);
        ASSERT_GE(distance, clearance_of(mover.kind())) << name_of(place) << " after " << t << " s";
        nearest = std::min(nearest, distance);
      }
    }
    EXPECT_LT(nearest, 25.0) << name_of(place) << ": but they are about";
  }
}

TEST(Movers, NobodyGoesThroughWallsOrJumps) {
  for (const Place& place : places()) {
    const SimulationConfig config = config_at(place);
    const Simulation simulation(config);
    const math::SE3 T_world_scene = config.world.T_world_scene();
    for (const Mover& mover : simulation.movers()) {
      double way = 0.0;
      auto before = mover.place(mover_instant(0.0));
      for (double t = 0.2; t < config.duration; t += 0.2) {
        const auto now = mover.place(mover_instant(t));
        if (before && now) {
          const Vector3d step = *now - *before;
          way += step.norm();
          EXPECT_LT(step.norm(), 0.2 * 12.0 * 1.02);
          EXPECT_LT(std::abs(step.z()), 0.2 * step.head<2>().norm() + 0.05) << name_of(place);
          const Vector3d chest = T_world_scene * (*before + Vector3d(0, 0, 0.9));
          if (step.norm() > 1e-6) {
            EXPECT_FALSE(simulation.cast({chest, (T_world_scene.R * step).normalized()}, step.norm()))
                << name_of(place) << " after " << t << " s";
          }
        }
        before = now;
      }
      EXPECT_GT(way, 1.0) << name_of(place);
    }
  }
}

TEST(Movers, PointsLieOnTheirSurfacesAtTheTimeOfTheirFiring) {
  SimulationConfig config = config_at({SceneKind::kHall, Carrier::kHandheld, 0});
  config.duration = 6.0;
  config.sensor.range_noise = config.sensor.laser_bias = config.sensor.mixed_pixels = 0.0;
  config.sensor.range_step = 0.0;
  Simulation simulation(config);
  const math::SE3 T_imu_lidar = simulation.rig().T_imu_lidar();
  int on_movers = 0, others = 0;
  double worst = 0.0, worst_at_start = 0.0;
  while (true) {
    const auto item = simulation.next();
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    const auto* scan = std::get_if<sensor::LidarScan>(&*item);
    if (scan == nullptr) continue;
    for (std::size_t i = 0; i < scan->size(); ++i) {
      const int surface = simulation.scan_truth().surfaces[i];
      (surface >= kFirstMoverSurface ? on_movers : others) += 1;
      const Time time = scan->start_time + from_seconds(static_cast<double>(scan->offsets[i]));
      const Vector3d p = simulation.T_world_imu(time) * (T_imu_lidar * scan->points[i].cast<double>());
      worst = std::max(worst, std::abs(simulation.distance_to_surface(p, surface, time)));
      worst_at_start =
          std::max(worst_at_start, std::abs(simulation.distance_to_surface(p, surface, scan->start_time)));
    }
  }
  EXPECT_GT(on_movers, 5000);
  EXPECT_GT(others, on_movers);
  EXPECT_LT(worst, 2e-5);           // single precision of points and times
  EXPECT_GT(worst_at_start, 0.02);  // they do move during a scan
}

TEST(Movers, AreTheSameForTheSameSeedAndOthersForAnother) {
  const SimulationConfig config = config_at({SceneKind::kYard, Carrier::kHandheld, 0});
  SimulationConfig other = config;
  other.world.seed = 2;
  const auto where = [](const SimulationConfig& c) {
    std::vector<double> x;
    for (const Mover& mover : Simulation(c).movers()) {
      const auto at = mover.place(mover_instant(7.77));
      x.push_back(at ? at->x() : 0.0);
    }
    return x;
  };
  EXPECT_EQ(where(config), where(config));
  EXPECT_NE(where(config), where(other));
}

TEST(Movers, HaveTheDeclaredSpeed) {
  SimulationConfig config = config_at({SceneKind::kYard, Carrier::kHandheld, 0});
  config.world.mover_speed = 1.5;
  for (const Mover& mover : Simulation(config).movers()) EXPECT_NEAR(mover.lane().cell, 0.15, 1e-12);
}

}  // namespace
}  // namespace mmlins::sim

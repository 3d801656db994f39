// SPDX-License-Identifier: MIT
// Kidnaps and elevators.

#include "mmlins/sim/rides.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/sim/open_simulation.hpp"

namespace mmlins::sim {
namespace {

using degrade::EventKind;
using math::Vector3d;

SimulationConfig on_the_ground_floor(std::vector<degrade::EventSpec> events) {
  SimulationConfig config;
  config.duration = 40.0;
  config.world.scene = SceneKind::kFloors;
  config.world.yaw_deg = 0.0;
  config.world.offset = {0.0, 0.0, 0.0};
  config.sensor.columns = 360;
  config.sensor.range_noise = config.sensor.laser_bias = config.sensor.mixed_pixels = 0.0;
  config.imu.perfect = true;
  config.trajectory.carrier = Carrier::kHandheld;
  config.trajectory.style = PathStyle::kRoute;
  config.trajectory.route = {{3.0, -0.5, 0.0}, {20.0, -0.5, 0.0}, {20.0, 0.5, 0.0}, {3.0, 0.5, 0.0}};
  config.trajectory.stand_still = 2.0;
  config.events = std::move(events);
  return config;
}

Time at(const Simulation& simulation, double seconds) {
  return simulation.start_time() + from_seconds(seconds);
}

double way_between(const Simulation& simulation, double from, double to) {
  double way = 0.0;
  constexpr double kStep = 1e-3;
  for (double t = from; t < to - 0.5 * kStep; t += kStep) {
    const Vector3d step =
        simulation.T_world_imu(at(simulation, t + kStep)).t - simulation.T_world_imu(at(simulation, t)).t;
    way += step.head<2>().norm();
  }
  return way;
}

TEST(Kidnap, MovesTheCarrierByTheDeclaredWayAndLetsItTravelOn) {
  for (const double metres : {2.0, 12.0}) {
    const SimulationConfig config = on_the_ground_floor({{EventKind::kKidnap, 10.0, 4.0, metres}});
    ASSERT_TRUE(validate(config, "x").ok());
    const Simulation simulation(config);
    const Simulation free(on_the_ground_floor({}));
    // It may cover 2 m of the way to and fro: it is in motion when it is lifted.
    if (metres > 5.0) {
      EXPECT_NEAR(way_between(simulation, 10.0, 14.0), metres, 0.02);
    }
    // Later it goes the way of the free carrier at another time.
    const Vector3d place = simulation.T_world_imu(at(simulation, 14.0)).t;
    double nearest = 1e9;
    for (double t = 8.0; t < 40.0; t += 0.01)
      nearest = std::min(nearest, (free.T_world_imu(at(free, t)).t - place).head<2>().norm());
    EXPECT_LT(nearest, 0.01);
    EXPECT_NEAR(simulation.velocity_world(at(simulation, 14.0)).head<2>().norm(), 1.2, 0.5);
    EXPECT_EQ(simulation.T_world_imu(at(simulation, 10.0)).t, free.T_world_imu(at(free, 10.0)).t);
    EXPECT_NEAR(simulation.velocity_world(at(simulation, 10.0 + 1e-4)).x(),
                free.velocity_world(at(free, 10.0 + 1e-4)).x(), 1e-9);
  }
}

TEST(Kidnap, LeavesNoSamplesAndNoPointsWithinAndAllOthers) {
  const SimulationConfig config = on_the_ground_floor({{EventKind::kKidnap, 10.02, 3.0, 8.0}});
  Simulation simulation(config);
  const Time begin = at(simulation, 10.02), end = at(simulation, 13.02);
  int samples = 0;
  double points_before = 0.0, points_after = 0.0;
  while (true) {
    const auto item = simulation.next();
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    if (const auto* sample = std::get_if<sensor::ImuSample>(&*item)) {
      EXPECT_TRUE(sample->time < begin || sample->time >= end);
      ++samples;
      continue;
    }
    const auto& scan = std::get<sensor::LidarScan>(*item);
    EXPECT_FALSE(scan.points.empty());
    for (const Time time : degrade::point_times(scan)) {
      ASSERT_TRUE(time < begin || time >= end);
      (time < begin ? points_before : points_after) += 1.0;
    }
  }
  EXPECT_EQ(samples, 8001 - 600);
  EXPECT_NEAR(points_after / points_before, (39.95 - 13.02) / (10.02 - 0.05), 0.1);
}

TEST(Elevator, RisesByTheDeclaredHeightAndTheImuFeelsIt) {
  for (const double rise : {3.2, -1.5}) {
    const SimulationConfig config = on_the_ground_floor({{EventKind::kElevator, 12.0, 9.0, rise}});
    ASSERT_TRUE(validate(config, "x").ok());
    Simulation simulation(config);
    const math::SE3 before = simulation.T_world_imu(at(simulation, 12.0));
    const math::SE3 after = simulation.T_world_imu(at(simulation, 21.0));
    EXPECT_LT((after.t - before.t - Vector3d(0, 0, rise)).norm(), 1e-9);
    // The first sample and those within; a midpoint rule of 5 ms steps errs by far less than a millimetre.
    double v = 0.0, z = 0.0;
    while (true) {
      const auto item = simulation.next();
      if (std::holds_alternative<sensor::EndOfData>(*item)) break;
      const auto* sample = std::get_if<sensor::ImuSample>(&*item);
      if (sample == nullptr || sample->time < at(simulation, 12.0)) continue;
      if (sample->time > at(simulation, 21.0)) break;
      const Vector3d up = before.R * sample->accel - Vector3d(0, 0, kGravity);
      EXPECT_LT(up.head<2>().norm(), 1e-9);
      EXPECT_LT(sample->gyro.norm(), 1e-9);
      v += 0.005 * up.z();
      z += 0.005 * v;
    }
    EXPECT_NEAR(v, 0.0, 1e-6);
    EXPECT_NEAR(z, rise, 1e-3);
  }
}

TEST(Elevator, TheLidarSeesNothingButTheCabinWhileItRises) {
  Simulation simulation(on_the_ground_floor({{EventKind::kElevator, 12.0, 8.0, 3.2}}));
  const math::SE3 T_imu_lidar = simulation.rig().T_imu_lidar();
  int through_the_door = 0, within = 0;
  double worst = 0.0;
  while (true) {
    const auto item = simulation.next();
    if (std::holds_alternative<sensor::EndOfData>(*item)) break;
    const auto* scan = std::get_if<sensor::LidarScan>(&*item);
    if (scan == nullptr) continue;
    for (std::size_t i = 0; i < scan->size(); ++i) {
      const Time time = scan->start_time + from_seconds(static_cast<double>(scan->offsets[i]));
      const double seconds = to_seconds(time - simulation.start_time());
      const int surface = simulation.scan_truth().surfaces[i];
      const bool on_cabin = surface >= kFirstCabinSurface;
      if (seconds < 12.0 || seconds >= 20.0) {
        ASSERT_FALSE(on_cabin) << seconds;
      }
      if (seconds >= 13.0 && seconds < 19.0) {
        ASSERT_TRUE(on_cabin) << seconds;
      }
      if (on_cabin) {
        ++within;
        const Vector3d p = simulation.T_world_imu(time) * (T_imu_lidar * scan->points[i].cast<double>());
        // The ranges of this sensor are multiples of 2 mm.
        worst = std::max(worst, std::abs(simulation.distance_to_surface(p, surface, time)));
        ASSERT_LT(scan->points[i].norm(), 3.0F);
      } else if (seconds >= 12.0 && seconds < 20.0) {
        ++through_the_door;
      }
    }
  }
  EXPECT_GT(within, 50'000);
  EXPECT_GT(through_the_door, 100);
  EXPECT_LT(worst, 1.1e-3);
}

TEST(Elevator, LeadsToTheStoreyAboveThroughItsFloor) {
  EXPECT_TRUE(open_simulation(on_the_ground_floor({{EventKind::kElevator, 12.0, 8.0, 3.2}}), "x").ok());
}

std::string error_of(std::vector<degrade::EventSpec> events, std::array<double, 3> p = {0.05, 0.02, 0.12}) {
  SimulationConfig config = on_the_ground_floor(std::move(events));
  config.sensor.p_imu_lidar = p;
  const Status status = validate(config, "x");
  return status.ok() ? "accepted" : status.error().message;
}

TEST(Rides, ImpossibleOnesAreRefusedInOneLine) {
  EXPECT_EQ(error_of({{EventKind::kElevator, 12.0, 8.0, 0.0}}), "accepted");
  EXPECT_EQ(error_of({{EventKind::kElevator, 12.0, 3.0, 0.0}}),
            "x: event elevator:12:3:3.2: an elevator takes 4 s or longer, as its doors take 1 s each way");
  EXPECT_EQ(error_of({{EventKind::kElevator, 12.0, 8.0, 0.0}, {EventKind::kKidnap, 19.0, 4.0, 5.0}}),
            "x: event kidnap:19:4:5 overlaps elevator:12:8:3.2; one ride at a time");
  EXPECT_EQ(
      error_of({{EventKind::kElevator, 12.0, 8.0, 0.0}}, {0.0, 0.0, 1.0}),
      "x: event elevator:12:8:3.2: the LiDAR would stick out of the cabin; sensor.p_imu_lidar must stay "
      "within 0.5 m");
  EXPECT_EQ(error_of({{EventKind::kElevator, 2.5, 8.0, 0.0}}),
            "x: trajectory.stops: the stop at 2.5 s overlaps the start: slowing down takes 1.5 s "
            "(trajectory.ramp), so it can begin at 5 s");
}

}  // namespace
}  // namespace mmlins::sim

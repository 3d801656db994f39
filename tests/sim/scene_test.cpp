// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "mmlins/sim/scenes.hpp"
#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

/// A carrier that suits the scene, on its course.
SimulationConfig carrier_in(SceneKind scene, int seed) {
  const bool outdoors = scene == SceneKind::kStreet || scene == SceneKind::kUrban ||
                        scene == SceneKind::kCampus || scene == SceneKind::kTunnel ||
                        scene == SceneKind::kField;
  SimulationConfig config;
  config.world.scene = scene;
  config.world.seed = seed;
  config.world.ground_waves = outdoors ? 0.03 : 0.0;
  config.trajectory.style = PathStyle::kRoute;
  config.trajectory.speed = outdoors ? 6.0 : 1.2;
  config.trajectory.corner_smoothing = outdoors ? 1.5 : 0.75;
  config.trajectory.corner_ratio = 0.5;
  config.trajectory.rise = 0.03;
  config.trajectory.start_in_motion = true;
  config.trajectory.look_deg = 0.0;
  return config;
}

/// Places half a metre apart on one lap, in the scene.
std::vector<Vector3d> lap_of(const SimulationConfig& config) {
  const auto motion = make_motion(config.trajectory, scene_route(config.world));
  const Vector3d start = motion->at(0.0).T_world_imu.t;
  std::vector<Vector3d> places{start};
  double travelled = 0.0;
  for (double t = 0.0; t < 3600.0; t += 0.05) {
    const Vector3d p = motion->at(t).T_world_imu.t;
    if ((p - places.back()).norm() < 0.5) continue;
    travelled += (p - places.back()).norm();
    places.push_back(p);
    if (travelled > 30.0 && (p - start).head<2>().norm() < 0.6 && std::abs(p.z() - start.z()) < 0.5) break;
  }
  return places;
}

Polygon flat(const std::vector<Vector3d>& places) {
  Polygon polygon;
  for (const Vector3d& p : places) polygon.emplace_back(p.head<2>());
  return polygon;
}

constexpr std::array kNewScenes{SceneKind::kCampus, SceneKind::kUrban, SceneKind::kCorridor,
                                SceneKind::kTunnel, SceneKind::kField, SceneKind::kDecoy,
                                SceneKind::kFloors};

TEST(Scenes, NoCourseLeadsThroughAnything) {
  constexpr double kReach = 0.3;  // [m]
  for (const SceneKind scene : kNewScenes) {
    for (const int seed : {1, 2, 5}) {
      const SimulationConfig config = carrier_in(scene, seed);
      const std::vector<Vector3d> places = lap_of(config);
      const auto world = make_world(config.world, flat(places));
      for (std::size_t i = 0; i + 1 < places.size(); ++i) {
        const Vector3d step = places[i + 1] - places[i];
        ASSERT_FALSE(world->cast({places[i], step.normalized()}, step.norm()).has_value())
            << "scene " << static_cast<int>(scene) << " seed " << seed << " at " << places[i].transpose();
        for (int k = 0; k < 8; ++k) {
          const double angle = k * std::numbers::pi / 4.0;
          ASSERT_FALSE(world->cast({places[i], {std::cos(angle), std::sin(angle), 0.0}}, kReach).has_value())
              << "scene " << static_cast<int>(scene) << " seed " << seed << " at " << places[i].transpose();
        }
      }
    }
  }
}

double length_of(const std::vector<Vector3d>& places) {
  double length = 0.0;
  for (std::size_t i = 0; i + 1 < places.size(); ++i) length += (places[i + 1] - places[i]).norm();
  return length;
}

TEST(Scenes, CoursesHaveTheLengthsThatTheyAreSaidToHave) {
  EXPECT_GT(length_of(lap_of(carrier_in(SceneKind::kUrban, 1))), 3000.0);
  EXPECT_NEAR(length_of(lap_of(carrier_in(SceneKind::kCampus, 1))), 500.0, 100.0);
  EXPECT_NEAR(length_of(lap_of(carrier_in(SceneKind::kCorridor, 1))), 250.0, 30.0);
}

// Whatever the one hall shows inside its walls, the other shows at the same place and range.
TEST(Scenes, TheTwoHallsLookTheSame) {
  const SimulationConfig config = carrier_in(SceneKind::kDecoy, 3);
  WorldConfig world_config = config.world;
  world_config.unevenness = 0.0;
  world_config.ground_waves = 0.0;
  const auto world = make_world(world_config, flat(lap_of(config)));
  const double apart = 2.0 * 13.0 + 22.0 + 0.6;
  int num_compared = 0;
  for (int k = 0; k < 2000; ++k) {
    const double angle = 0.7 * k;
    const Vector3d direction =
        Vector3d(std::cos(angle), std::sin(angle), 0.3 * std::sin(1.7 * k)).normalized();
    const Vector3d place(2.0, 5.0, 1.3);
    const auto one = world->cast({place, direction}, 20.0);
    const auto other = world->cast({place + Vector3d(apart, 0, 0), direction}, 20.0);
    if (!one || !other) continue;
    // Through the doorways, one looks at a closed door and the other into the corridor.
    const double x_one = place.x() + one->range * direction.x();
    const double x_other = place.x() + other->range * direction.x();
    if (std::max(std::abs(x_one), std::abs(x_other)) > 12.99) continue;
    EXPECT_NEAR(one->range, other->range, 1e-9);
    ++num_compared;
  }
  EXPECT_GT(num_compared, 1000);
}

TEST(Scenes, TheCourseOfTheStoreysReachesEveryFloor) {
  const SimulationConfig config = carrier_in(SceneKind::kFloors, 1);
  std::array<int, 3> places_on{};
  for (const Vector3d& p : lap_of(config)) {
    for (std::size_t storey = 0; storey < 3; ++storey)
      places_on[storey] +=
          std::abs(p.z() - config.trajectory.height - 3.2 * static_cast<double>(storey)) < 0.1;
  }
  for (const int count : places_on) EXPECT_GT(count, 40);
}

}  // namespace
}  // namespace mmlins::sim

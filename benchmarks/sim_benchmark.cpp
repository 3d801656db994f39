// SPDX-License-Identifier: MIT
// Rays per second: of whole sensors on one and two cores, and of the two ways to find the first surface.

#include <benchmark/benchmark.h>

#include <cmath>
#include <ctime>
#include <numbers>

#include "mmlins/base/parallel.hpp"
#include "mmlins/sim/embree_world.hpp"
#include "mmlins/sim/lidar_model.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

const std::vector<std::string> kModels{"vlp16", "vlp32c", "hdl32e", "rs16", "os1_64", "mid360", "avia"};

double shots_per_second(const SensorTable& table) {
  const bool is_spinning = table.pattern == PatternKind::kSpinning;
  return is_spinning ? 1e6 * static_cast<double>(table.lasers.size()) / table.column_period_us
                     : 1e6 / table.point_period_us;
}

/// Of all threads of the process [s].
double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Scans of a carrier that drives through city blocks; columns as the sensor has them. The rates go by the
/// wall clock, those named cpu by the processor time of all threads together: x_real_time_cpu is what as many
/// cores would reach if nothing else used them.
void scan_in_the_street(benchmark::State& state) {
  LidarConfig lidar_config;
  lidar_config.model = kModels[static_cast<std::size_t>(state.range(0))];
  parallel::set_num_threads(static_cast<int>(state.range(1)));
  WorldConfig world_config;
  world_config.scene = SceneKind::kStreet;
  TrajectoryConfig trajectory;
  trajectory.style = PathStyle::kRoute;
  trajectory.speed = 8.0;
  trajectory.start_in_motion = true;
  trajectory.height = 1.5;
  const auto motion = make_motion(trajectory, scene_route(world_config));
  const auto world = make_world(world_config, scene_route(world_config).corners);
  const LidarModel lidar(lidar_config, 1);
  const Duration period = lidar.period();
  std::int64_t scan = 0;
  const double begun = processor_time();
  for (auto _ : state) {
    benchmark::DoNotOptimize(lidar.scan(*world, *motion, scan * period, (scan + 1) * period));
    ++scan;
  }
  const double cpu = processor_time() - begun;
  parallel::set_num_threads(0);
  state.SetLabel(lidar_config.model);
  const double simulated = static_cast<double>(scan) * to_seconds(period);
  const double rays = simulated * shots_per_second(lidar_config.table());
  state.counters["rays_per_s"] = benchmark::Counter(rays, benchmark::Counter::kIsRate);
  state.counters["x_real_time"] = benchmark::Counter(simulated, benchmark::Counter::kIsRate);
  state.counters["rays_per_s_cpu"] = rays / cpu;
  state.counters["x_real_time_cpu"] = simulated / cpu * static_cast<double>(state.range(1));
}
BENCHMARK(scan_in_the_street)
    ->ArgsProduct({benchmark::CreateDenseRange(0, 6, 1), {1, 2}})
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond)
    ->MinTime(1.0);

void add_box(TriangleMesh& mesh, const Shape& box) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  const Eigen::Vector2d y_axis(-box.x_axis.y(), box.x_axis.x());
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3d s =
        Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1).cwiseProduct(box.half_size);
    const Eigen::Vector2d flat = s.x() * box.x_axis + s.y() * y_axis;
    mesh.vertices.push_back(box.center + Vector3d(flat.x(), flat.y(), s.z()));
  }
  for (const auto& [a, b, c, d] :
       {std::array{0U, 1U, 3U, 2U}, std::array{4U, 5U, 7U, 6U}, std::array{0U, 1U, 5U, 4U},
        std::array{2U, 3U, 7U, 6U}, std::array{0U, 2U, 6U, 4U}, std::array{1U, 3U, 7U, 5U}}) {
    mesh.triangles.push_back({first + a, first + b, first + c});
    mesh.triangles.push_back({first + a, first + c, first + d});
  }
}

// The side alone, of twelve flat pieces: in favour of the mesh.
void add_cylinder(TriangleMesh& mesh, const Shape& shape) {
  constexpr std::uint32_t kPieces = 12;
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::uint32_t i = 0; i < kPieces; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPieces;
    const Vector3d out(shape.half_size.x() * std::cos(angle), shape.half_size.x() * std::sin(angle), 0.0);
    mesh.vertices.push_back(shape.center + out - Vector3d(0, 0, shape.half_size.z()));
    mesh.vertices.push_back(shape.center + out + Vector3d(0, 0, shape.half_size.z()));
    const std::uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % kPieces);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
  }
}

TriangleMesh mesh_of(const std::vector<Shape>& shapes) {
  TriangleMesh mesh;
  for (const Shape& shape : shapes) {
    if (shape.kind == ShapeKind::kBox) {
      add_box(mesh, shape);
    } else {
      add_cylinder(mesh, shape);
    }
  }
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const auto& [x, y] :
       {std::array{-1.0, -1.0}, std::array{1.0, -1.0}, std::array{1.0, 1.0}, std::array{-1.0, 1.0}})
    mesh.vertices.emplace_back(500.0 * x, 500.0 * y, 0.0);
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
  return mesh;
}

/// The beams of a 32-ring sensor from the course of the scene.
std::vector<Ray> rays_in(const WorldConfig& config) {
  const Polygon course = scene_route(config).corners;
  std::vector<Ray> rays;
  for (const Eigen::Vector2d& place : course) {
    for (int ring = 0; ring < 32; ++ring) {
      for (int column = 0; column < 360; ++column) {
        const double elevation = (-30.67 + ring * 4.0 / 3.0) * std::numbers::pi / 180.0;
        const double azimuth = column * std::numbers::pi / 180.0;
        rays.push_back({{place.x(), place.y(), 1.4},
                        {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation)}});
      }
    }
  }
  return rays;
}

/// First argument: scene; second: 0 our tree of shapes and a plane, 1 Embree's triangles.
void first_surface(benchmark::State& state) {
  WorldConfig config;
  config.scene = static_cast<SceneKind>(state.range(0));
  const Polygon course = scene_route(config).corners;
  const std::vector<Shape> shapes = config.scene == SceneKind::kHall     ? hall_shapes(config, course)
                                    : config.scene == SceneKind::kStreet ? street_shapes(config, course)
                                                                         : campus_shapes(config, course);
  std::unique_ptr<World> world;
  if (state.range(1) == 0) {
    world = std::make_unique<ShapeWorld>(shapes, ShapeWorld::Roughness{});  // even: no search for the relief
  } else {
    world = make_mesh_world(mesh_of(shapes));
  }
  const std::vector<Ray> rays = rays_in(config);
  for (auto _ : state) {
    for (const Ray& ray : rays) benchmark::DoNotOptimize(world->cast(ray, 80.0));
  }
  state.SetLabel(state.range(1) == 0 ? "tree of shapes" : "Embree triangles");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}
BENCHMARK(first_surface)
    ->ArgsProduct({{static_cast<int>(SceneKind::kHall), static_cast<int>(SceneKind::kStreet),
                    static_cast<int>(SceneKind::kCampus)},
                   {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->MinTime(0.3);

/// A hall of a million discs.
void cloud_of_discs(benchmark::State& state) {
  Random random(1);
  std::vector<Disc> discs;
  for (int i = 0; i < 1'000'000; ++i) {
    const Vector3d n = random.normal3().normalized();
    discs.push_back({30.0 * n, n, 0.15});
  }
  const auto world = make_disc_world(std::move(discs));
  std::vector<Ray> rays;
  for (int i = 0; i < 100'000; ++i) rays.push_back({{1, 2, 1}, random.normal3().normalized()});
  for (auto _ : state) {
    for (const Ray& ray : rays) benchmark::DoNotOptimize(world->cast(ray, 80.0));
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(rays.size()));
}
BENCHMARK(cloud_of_discs)->Unit(benchmark::kMillisecond)->MinTime(0.3);

}  // namespace
}  // namespace mmlins::sim

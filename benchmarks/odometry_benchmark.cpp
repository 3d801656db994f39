// SPDX-License-Identifier: MIT
// The hot pieces of the odometry on one simulated 32-ring scan, one thread.

#include <benchmark/benchmark.h>

#include "mmlins/base/check.hpp"
#include "mmlins/base/parallel.hpp"
#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/lidar/voxel_downsample.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"
#include "mmlins/sim/scenario.hpp"
#include "mmlins/spatial/knn_map.hpp"
#include "mmlins/spatial/plane_map.hpp"

namespace mmlins {
namespace {

/// A minute of the development hall seen from true poses: what a map and a scan look like.
struct Scene {
  sensor::Rig rig;
  sensor::LidarScan scan;
  math::Trajectory motion;
  lidar::Cloud cloud;
  lidar::Cloud map_points;
  lidar::Cloud keypoints;
  std::vector<std::vector<Eigen::Vector3d>> map_scans;
};

math::Trajectory motion_of(const sim::Simulation& simulation, const sensor::LidarScan& scan) {
  math::Trajectory motion;
  for (Time time = scan.start_time; time < scan.end_time; time += Duration(5'000'000)) {
    motion.push_back({time, simulation.T_world_imu(time)});
  }
  motion.push_back({scan.end_time, simulation.T_world_imu(scan.end_time)});
  return motion;
}

Scene make_scene() {
  parallel::set_num_threads(1);
  auto config = sim::load_scenario("dev_hall32", {"duration=20"});
  MMLINS_CHECK(config.ok());
  sim::Simulation simulation(*config);
  Scene scene;
  scene.rig = simulation.rig();
  for (auto item = simulation.next(); !std::holds_alternative<sensor::EndOfData>(*item); item = simulation.next()) {
    auto* scan = std::get_if<sensor::LidarScan>(&*item);
    if (scan == nullptr) continue;
    scene.motion = motion_of(simulation, *scan);
    scene.cloud = lidar::deskew(*scan, scene.motion, scene.rig.T_imu_lidar(), {scene.rig.min_range, scene.rig.max_range});
    scene.map_points = lidar::voxel_downsample(scene.cloud, 0.25);
    scene.keypoints = lidar::voxel_downsample(scene.map_points, 0.5);
    std::vector<Eigen::Vector3d> points;
    for (const auto& p : scene.map_points.points) points.push_back(scene.motion.back().pose * p.cast<double>());
    scene.map_scans.push_back(std::move(points));
    scene.scan = std::move(*scan);
  }
  return scene;
}

const Scene& scene() {
  static const Scene instance = make_scene();
  return instance;
}

std::unique_ptr<spatial::LocalMap> empty_map(bool planes) {
  if (planes) return std::make_unique<spatial::PlaneMap>(spatial::PlaneMapConfig{}, scene().rig.range_noise);
  return std::make_unique<spatial::KnnMap>(spatial::KnnMapConfig{}, scene().rig.range_noise);
}

std::unique_ptr<spatial::LocalMap> full_map(bool planes) {
  auto map = empty_map(planes);
  for (const auto& points : scene().map_scans) map->insert(points, points.front());
  return map;
}

void BM_Deskew(benchmark::State& state) {
  const Scene& s = scene();
  for (auto _ : state) benchmark::DoNotOptimize(lidar::deskew(s.scan, s.motion, s.rig.T_imu_lidar(), {0.5, 200.0}));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(s.scan.size()));
}

void BM_Downsample(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(lidar::voxel_downsample(scene().cloud, 0.25));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene().cloud.size()));
}

void BM_Linearise(benchmark::State& state, bool planes) {
  const auto map = full_map(planes);
  odometry::LidarMeasurement measurement(scene().keypoints.points, *map, {}, {});
  imu::NavState nav;
  nav.R_odom_imu = scene().motion.back().pose.R;
  nav.p_odom = scene().motion.back().pose.t;
  const imu::ErrorMatrix P = 1e-6 * imu::ErrorMatrix::Identity();
  for (auto _ : state) benchmark::DoNotOptimize(measurement.linearise(nav, P));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(scene().keypoints.size()));
}

void BM_Insert(benchmark::State& state, bool planes) {
  std::int64_t points = 0;
  for (auto _ : state) {
    state.PauseTiming();
    auto map = empty_map(planes);
    state.ResumeTiming();
    for (const auto& scan : scene().map_scans) {
      map->insert(scan, scan.front());
      points += static_cast<std::int64_t>(scan.size());
    }
  }
  state.SetItemsProcessed(points);
}

void BM_PropagateOneScan(benchmark::State& state) {
  sensor::ImuSamples samples;
  for (int i = 0; i <= 20; ++i) samples.push_back({time_from_ns(i * 5'000'000LL), {0.1, 0.2, 0.3}, {0.0, 0.0, 9.81}});
  imu::Estimate estimate;
  estimate.state.time = samples.front().time;
  for (auto _ : state) benchmark::DoNotOptimize(imu::propagate(estimate, samples, {1e-3, 1e-2, 1e-5, 1e-4}));
}

BENCHMARK(BM_Deskew)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Downsample)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Linearise, planes, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Linearise, knn, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Insert, planes, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Insert, knn, false)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_PropagateOneScan)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mmlins

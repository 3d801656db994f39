// SPDX-License-Identifier: MIT
// Is the covariance of the filter the size of its errors? The normalised estimation error squared (NEES),
// e^T P^-1 e / dof, is 1 on average for a filter that knows its own accuracy.
//
// The map here is built from true poses: P is the uncertainty of the state against its map, and only there
// can it be consistent. Against the place where a run began, a pose drifts with the map that it made itself,
// which no odometry without loop closure carries in its covariance.

#include <gtest/gtest.h>

#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/lidar/voxel_downsample.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"
#include "mmlins/sensor/imu_buffer.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins {
namespace {

using imu::Estimate;
using imu::NavState;

struct Recording {
  sensor::ImuBuffer imu;
  std::vector<sensor::LidarScan> scans;
};

Recording record(sim::Simulation& simulation) {
  Recording recording;
  for (;;) {
    auto item = simulation.next();
    if (std::holds_alternative<sensor::EndOfData>(*item)) return recording;
    if (auto* sample = std::get_if<sensor::ImuSample>(&*item)) {
      EXPECT_EQ(recording.imu.add(*sample), sensor::ImuAdmission::kAccepted);
    } else {
      recording.scans.push_back(std::move(std::get<sensor::LidarScan>(*item)));
    }
  }
}

NavState true_state(const sim::Simulation& simulation, Time time) {
  NavState state;
  const math::SE3 T_world_imu = simulation.T_world_imu(time);
  state.time = time;
  state.R_odom_imu = T_world_imu.R;
  state.p_odom = T_world_imu.t;
  state.v_odom = simulation.velocity_world(time);
  state.gyro_bias = simulation.bias(time).gyro;
  state.accel_bias = simulation.bias(time).accel;
  return state;
}

/// Poses of the truth, dense enough to straighten a scan with.
math::Trajectory true_motion(const sim::Simulation& simulation, Time begin, Time end) {
  math::Trajectory motion;
  for (Time time = begin; time < end; time += Duration(2'000'000)) motion.push_back({time, simulation.T_world_imu(time)});
  motion.push_back({end, simulation.T_world_imu(end)});
  return motion;
}

spatial::PlaneMap true_map(const sim::Simulation& simulation, const Recording& recording, const sensor::Rig& rig) {
  spatial::PlaneMap map({.offset_noise = 0.0}, rig.range_noise);
  for (const auto& scan : recording.scans) {
    const auto motion = true_motion(simulation, scan.start_time, scan.end_time);
    const auto cloud = lidar::deskew(scan, motion, rig.T_imu_lidar(), {rig.min_range, rig.max_range});
    std::vector<Eigen::Vector3d> points;
    for (const auto& p : lidar::voxel_downsample(cloud, 0.2).points) points.push_back(motion.back().pose * p.cast<double>());
    map.insert(points, motion.back().pose.t);
  }
  return map;
}

Estimate start_near(const NavState& truth) {
  imu::ErrorVector sigma;
  sigma << math::Vector3d::Constant(0.005), math::Vector3d::Constant(0.02), math::Vector3d::Constant(0.05),
      math::Vector3d::Constant(0.002), math::Vector3d::Constant(0.05), Eigen::Vector2d::Constant(0.005);
  NavState state = truth;
  state.gyro_bias.setZero();
  state.accel_bias.setZero();
  return {state, sigma.cwiseAbs2().asDiagonal()};
}

/// Mean NEES per degree of freedom over the run, after its first three seconds.
double mean_nees(int seed) {
  auto config = sim::load_scenario("dev_hall32", {"duration=20", "trajectory.stand_still=0.5"});
  config->seed = seed;
  // What the filter's noise model leaves out, so that the test is of the filter and not of the model.
  config->sensor.laser_bias = 0.0;
  config->world.unevenness = 0.0;
  config->world.ground_waves = 0.0;
  sim::Simulation simulation(*config);
  const sensor::Rig rig = simulation.rig();
  Recording recording = record(simulation);
  const spatial::PlaneMap map = true_map(simulation, recording, rig);
  const imu::ImuNoise noise{rig.gyro_noise_density, rig.accel_noise_density, rig.gyro_bias_walk, rig.accel_bias_walk};
  Estimate estimate = start_near(true_state(simulation, recording.scans.front().start_time));
  double sum = 0.0;
  int count = 0;
  for (const auto& scan : recording.scans) {
    const auto motion = imu::propagate(estimate, recording.imu.covering(estimate.state.time, scan.end_time), noise);
    const auto cloud = lidar::deskew(scan, motion.T_odom_imu, rig.T_imu_lidar(), {rig.min_range, rig.max_range});
    const auto keypoints = lidar::voxel_downsample(cloud, 0.5);
    odometry::LidarMeasurement measurement(keypoints.points, map, {}, {0.0, rig.T_imu_lidar().t});
    const auto update = filter::iterated_update(
        motion.estimate,
        [&](const NavState& state, const imu::ErrorMatrix& P) { return measurement.linearise(state, P); },
        {.max_iterations = 5, .min_residuals = 50});
    estimate = update.estimate;
    if (to_seconds(scan.end_time - recording.scans.front().start_time) < 3.0) continue;
    const imu::ErrorVector error = imu::minus(true_state(simulation, scan.end_time), estimate.state);
    sum += error.dot(estimate.P.ldlt().solve(error)) / imu::kErrorSize;
    ++count;
  }
  return sum / count;
}

TEST(FilterConsistency, ErrorsAreAsLargeAsTheCovarianceSays) {
  double sum = 0.0;
  const int num_seeds = 6;
  for (int seed = 1; seed <= num_seeds; ++seed) {
    const double nees = mean_nees(seed);
    RecordProperty("nees_seed_" + std::to_string(seed), std::to_string(nees));
    std::printf("seed %d: mean NEES per degree of freedom %.2f\n", seed, nees);
    sum += nees / num_seeds;
  }
  EXPECT_GT(sum, 0.5);
  EXPECT_LT(sum, 2.0);
}

}  // namespace
}  // namespace mmlins

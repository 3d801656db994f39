// SPDX-License-Identifier: MIT
// Finding the state in motion: how long one attempt takes, by poses in the window, with an IMU of 200 Hz.

#include <benchmark/benchmark.h>

#include "mmlins/initialization/acceptance.hpp"
#include "mmlins/initialization/paper_initializer.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::initialization {
namespace {

const imu::ImuNoise kNoise{2.4e-4, 1.7e-3, 0.0, 0.0};

/// Even motion with noise; the time taken does not depend on how lively it is.
Window window_of(int num_poses) {
  math::Random random(1);
  Window window;
  window.noise = kNoise;
  const math::Matrix6d covariance = 1e-4 * math::Matrix6d::Identity();
  for (int k = 0; k < num_poses; ++k) {
    const math::Vector3d p = math::Vector3d(0.15 * k, 0.0, 0.0) + 0.01 * random.normal3();
    const math::Matrix3d R = math::so3_exp(0.01 * random.normal3());
    window.poses.push_back(pose_with_covariance(time_from_ns(100'000'000LL * k), {R, p}, covariance));
  }
  for (int i = 0; i <= 20 * (num_poses - 1); ++i) {
    window.samples.push_back({time_from_ns(5'000'000LL * i), 0.003 * random.normal3(),
                              math::Vector3d(0.0, 0.0, imu::kGravity) + 0.02 * random.normal3()});
  }
  return window;
}

void initialize_cold(benchmark::State& state) {
  const Window window = window_of(static_cast<int>(state.range(0)));
  const InitializationConfig config;
  for (auto _ : state) {
    benchmark::DoNotOptimize(initialize(window, cold_prior(window.poses.front().time, {}), config));
  }
}
BENCHMARK(initialize_cold)->Arg(4)->Arg(10)->Arg(20)->Arg(30)->Unit(benchmark::kMillisecond);

void initialize_as_the_paper(benchmark::State& state) {
  const Window window = window_of(4);
  for (auto _ : state) benchmark::DoNotOptimize(solve_paper(window));
}
BENCHMARK(initialize_as_the_paper)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace mmlins::initialization

// SPDX-License-Identifier: MIT
// Two rounds in a hall: in the second the odometry goes on with local maps that the back end has made of the
// first. The hall is small, and would not be forgotten in between: here everything is, after 5 m.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "mmlins/base/parallel.hpp"
#include "tests/pipeline/edited_recording.hpp"

namespace mmlins::pipeline {
namespace {

const Recording& two_rounds() {
  static const Recording made = simulated({"duration=64", "trajectory.stand_still=1.5", "sensor.columns=120"});
  return made;
}

RunResult run_with(bool rebuild, const Observer& observer = {}) {
  SlamConfig config;
  config.mapping.rebuild.enabled = rebuild;
  config.mapping.rebuild.after = 4;
  config.mapping.rebuild.recent = 5.0;
  config.mapping.rebuild.held_within = 0.0;
  MemoryDataset dataset(two_rounds().items);
  return run(dataset, two_rounds().rig, config, observer);
}

bool same_bits(const RunResult& a, const RunResult& b) {
  return std::equal(a.scans.begin(), a.scans.end(), b.scans.begin(), b.scans.end(),
                    [](const ScanRecord& x, const ScanRecord& y) {
                      return x.time == y.time && x.T_odom_imu.R == y.T_odom_imu.R &&
                             x.T_odom_imu.t == y.T_odom_imu.t && x.T_world_imu.t == y.T_world_imu.t &&
                             x.num_matches == y.num_matches;
                    });
}

/// Where the odometry was at `time` by the truth.
math::SE3 truth_at(Time time) { return math::pose_at(two_rounds().truth, time, from_seconds(1.0)).value(); }

TEST(RebuiltMaps, AreTakenWithoutAJump) {
  const RunResult result = run_with(true);
  ASSERT_GE(result.mapping.num_rebuilt, 1);
  // From scan to scan the odometry moves as the robot does, to what a thousand points with 3 cm of noise
  // tell.
  for (std::size_t i = 1; i < result.scans.size(); ++i) {
    const ScanRecord &a = result.scans[i - 1], &b = result.scans[i];
    if (a.state != odometry::TrackingState::kTracking) continue;
    const math::SE3 moved = a.T_odom_imu.inverse() * b.T_odom_imu;
    const math::SE3 truly = truth_at(a.time).inverse() * truth_at(b.time);
    EXPECT_LT((moved.t - truly.t).norm(), 0.05) << i;
  }
}

TEST(RebuiltMaps, AreTheSameBitsWhoeverIsFaster) {
  parallel::set_num_threads(1);
  const RunResult one = run_with(true);
  parallel::set_num_threads(2);
  // The odometry dawdles: the back end has always been there before.
  const RunResult two = run_with(true, [](const ScanRecord&, double) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return true;
  });
  parallel::set_num_threads(0);
  EXPECT_GE(one.mapping.num_rebuilt, 1);
  EXPECT_EQ(one.mapping.num_rebuilt, two.mapping.num_rebuilt);
  EXPECT_TRUE(same_bits(one, two));
}

TEST(RebuiltMaps, ComeOnlyWhenAskedFor) { EXPECT_EQ(run_with(false).mapping.num_rebuilt, 0); }

}  // namespace
}  // namespace mmlins::pipeline

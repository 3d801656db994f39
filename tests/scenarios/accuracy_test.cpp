// SPDX-License-Identifier: MIT
// The whole odometry on simulated recordings. Scenarios named heldout_* are ones that no parameter was ever
// chosen on. Bounds are what the README promises, not what was last measured.

#include <gtest/gtest.h>

#include "mmlins/eval/evaluation.hpp"
#include "mmlins/pipeline/slam_system.hpp"
#include "mmlins/sim/scenario.hpp"

namespace mmlins {
namespace {

struct Promise {
  std::string scenario;
  double ate;  ///< [m]
};

class Accuracy : public testing::TestWithParam<Promise> {};

TEST_P(Accuracy, IsWithinThePromise) {
  const auto config = sim::load_scenario(GetParam().scenario);
  ASSERT_TRUE(config.ok());
  sim::Simulation simulation(*config);
  const auto result = pipeline::run(simulation, simulation.rig(), {}, {});
  math::Trajectory odometry;
  for (const auto& scan : result.scans) {
    EXPECT_NE(scan.state, odometry::TrackingState::kBridging) << "at " << to_seconds(scan.time - simulation.start_time());
    odometry.push_back({scan.time, scan.T_odom_imu});
  }
  const auto evaluation = eval::evaluate(simulation.truth(), odometry, eval::Alignment::kSe3);
  ASSERT_TRUE(evaluation.ok());
  RecordProperty("ate_m", std::to_string(evaluation->absolute.translation.rmse));
  EXPECT_LT(evaluation->absolute.translation.rmse, GetParam().ate);
  EXPECT_GT(evaluation->coverage.share, 0.98);
}

INSTANTIATE_TEST_SUITE_P(Simulated, Accuracy,
                         testing::Values(Promise{"dev_hall32", 0.01}, Promise{"dev_office_mid360", 0.01},
                                         Promise{"heldout_hall16", 0.03}, Promise{"heldout_yard_mid360", 0.01},
                                         Promise{"heldout_start_in_motion", 0.02}),
                         [](const auto& instance) { return instance.param.scenario; });

}  // namespace
}  // namespace mmlins

// SPDX-License-Identifier: MIT
// A LiDAR under a bag sees the bag. Whatever that shows, it is not the world.

#include <gtest/gtest.h>

#include "tests/odometry/simulated_drive.hpp"

namespace mmlins::odometry {
namespace {

// In a passage between two halls the bag of this drive agrees with itself for a second and a half, and shows motion:
// it explains 45 % of such scans, more than a new map must explain of others.
TEST(Covered, NoMapBeginsInABagThatAgreesWithItselfForAWhile) {
  const Drive drive = SimulatedDrive("dev_decoy", {"duration=85"}, {{degrade::EventKind::kBag, 60.0, 25.0, 0.7}}).run();
  ASSERT_EQ(drive.maps.size(), 1U);
  EXPECT_EQ(drive.maps[0].why_ended, Cause::kBlocked);
  int covered = 0;
  for (const DrivenScan& scan : drive.scans) {
    if (scan.covered_share < 0.9) continue;
    ++covered;
    EXPECT_FALSE(is_placed(scan.state)) << scan.seconds;
  }
  EXPECT_GT(covered, 240);  // of 250
}

}  // namespace
}  // namespace mmlins::odometry

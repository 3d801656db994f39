// SPDX-License-Identifier: MIT
#include "mmlins/registration/verify.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/registration/fit_height.hpp"
#include "mmlins/registration/free_space.hpp"
#include "mmlins/registration/search_around.hpp"
#include "mmlins/registration/structure_grid.hpp"
#include "tests/place/simulated_submaps.hpp"
#include "tests/registration/drawn_submaps.hpp"

namespace mmlins::registration {
namespace {

using keyframe::Submap;
using math::SE3;
using math::Vector3d;
using place_test::Site;
using place_test::true_T;

constexpr double kDeg = M_PI / 180.0;

SE3 pushed(const SE3& T, double distance, double bearing, double yaw_deg) {
  return {T.R * math::so3_exp({0, 0, yaw_deg * kDeg}),
          T.t + distance * Vector3d(std::cos(bearing), std::sin(bearing), 0.02)};
}

PosePrior prior_of(const SE3& T, double sigma, double sigma_deg) {
  PosePrior prior{T, math::Matrix6d::Zero()};
  prior.covariance.diagonal() << Vector3d::Constant(std::pow(sigma_deg * kDeg, 2)),
      Vector3d::Constant(sigma * sigma);
  return prior;
}

/// Part of a round of a hall, seen by scanners of different kinds.
struct HallPair {
  std::vector<Submap> rings, rosette;
  HallPair() {
    const Site site(sim::SceneKind::kHall, 1, 1.5);
    rings = site.submaps({.sensor = "vlp16", .duration = 12, .seed = 1});
    rosette = site.submaps({.sensor = "mid360", .from = 1.7, .duration = 12, .seed = 2});
  }
};
const HallPair& hall() {
  static const HallPair pair;
  return pair;
}

TEST(Verify, BelievesATrueRevisitByAnotherScanner) {
  const SE3 truth = true_T(hall().rings[0], hall().rosette[0]);
  const VerificationConfig config;
  const std::vector<SE3> starts{pushed(truth, 1.5, 0.7, 6)};
  const Verification result =
      verify(prepare(hall().rosette[0], config.registration), prepare(hall().rings[0], config.registration),
             starts, std::nullopt, config);
  EXPECT_TRUE(result.accepted) << result.reason;
  // Points are good to a few centimetres and thousands agree.
  EXPECT_LT((result.registration.T_target_source.t - truth.t).norm(), 0.05);
}

TEST(Verify, DoesNotBelieveAHallTurnedRound) {
  const SE3 truth = true_T(hall().rings[0], hall().rosette[0]);
  const VerificationConfig config;
  const std::vector<SE3> starts{pushed(truth, 0.5, 0.0, 180), pushed(truth, 0.5, 0.0, 90)};
  const Verification result =
      verify(prepare(hall().rosette[0], config.registration), prepare(hall().rings[0], config.registration),
             starts, std::nullopt, config);
  EXPECT_FALSE(result.accepted) << result.reason;
  EXPECT_EQ(result.reason.find('\n'), std::string::npos);
}

TEST(Verify, ATruePairHasFreeRaysAndAShiftedOneHasNot) {
  const SE3 truth = true_T(hall().rings[0], hall().rosette[0]);
  const PreparedSubmap source = prepare(hall().rosette[0], {}), target = prepare(hall().rings[0], {});
  EXPECT_LT(crossing_share(source, target, truth), 0.02);
  EXPECT_GT(crossing_share(source, target, pushed(truth, 6.0, 0.5, 20)), 0.05);
}

TEST(Verify, ACorridorIsOnlyAnEdgeWithAPriorAndSaysNothingAlongItsAxis) {
  const VerificationConfig config;
  const PreparedSubmap source = prepare(drawn_submap(drawn_corridor(), {}, 0.02, 1), config.registration);
  const PreparedSubmap target = prepare(drawn_submap(drawn_corridor(), {}, 0.02, 2), config.registration);
  const std::vector<SE3> starts{level_pose(1.0, 0.2, 0, 2)};
  const Verification alone = verify(source, target, starts, std::nullopt, config);
  EXPECT_FALSE(alone.accepted) << alone.reason;
  const Verification with_prior = verify(source, target, starts, prior_of({}, 1.0, 2.0), config);
  EXPECT_TRUE(with_prior.accepted) << with_prior.reason;
  EXPECT_GT(with_prior.registration.information.inverse()(3, 3), 1.0);
}

// The halls of this site are the same to the millimetre. Odometry knows by centimetres that the second one is
// 48 m from the first; sight alone cannot.
TEST(Verify, TwinHallsAreToldApartByWhereTheyAre) {
  const Site site(sim::SceneKind::kDecoy, 1, 1.5);
  const auto all = site.submaps({.sensor = "mid360", .duration = 75, .seed = 1});
  const VerificationConfig config;
  const SE3 T_hall_twin{math::Matrix3d::Identity(), {48.6, 0, 0}};
  int twins = 0;
  for (const Submap& there : all) {
    for (const Submap& here : all) {
      SE3 twin = there.T_map_submap;
      twin.t.x() -= T_hall_twin.t.x();
      const SE3 alias = here.T_map_submap.inverse() * twin;  // where it would seem to be
      if (alias.t.norm() > 4.0) continue;
      ++twins;
      const std::vector<SE3> starts{alias};
      const auto result = verify(prepare(there, config.registration), prepare(here, config.registration),
                                 starts, prior_of(true_T(here, there), 2.0, 3.0), config);
      EXPECT_FALSE(result.accepted) << result.reason;
    }
  }
  EXPECT_GE(twins, 1);
}

// Storeys of one building, 3 m above each other and much alike: odometry knows the height by decimetres.
TEST(Verify, StoreysAreToldApartByTheirHeight) {
  const Site site(sim::SceneKind::kFloors, 1, 1.2);
  const auto all = site.submaps({.sensor = "mid360", .duration = 130, .step = 2.0, .seed = 1});
  const VerificationConfig config;
  int pairs = 0;
  for (const Submap& there : all) {
    for (const Submap& here : all) {
      const SE3 truth = true_T(here, there);
      if (std::abs(truth.t.z()) < 2.0 || truth.t.head<2>().norm() > 4.0) continue;
      ++pairs;
      SE3 alias = truth;  // as if both were on one floor
      alias.t.z() = 0.0;
      const std::vector<SE3> starts{alias};
      const auto result = verify(prepare(there, config.registration), prepare(here, config.registration),
                                 starts, prior_of(truth, 0.5, 1.0), config);
      EXPECT_FALSE(result.accepted && (result.registration.T_target_source.t - truth.t).norm() > 0.2)
          << result.reason;
    }
  }
  EXPECT_GE(pairs, 2);
}

TEST(SearchAround, FindsItsWayBackFromTwentyMetresAndFifteenDegreesOff) {
  const Site site(sim::SceneKind::kCampus, 1, 3.0);
  const auto old_map = site.submaps({.sensor = "vlp16", .duration = 6, .seed = 1});
  const auto new_map = site.submaps({.sensor = "mid360", .from = 0.8, .duration = 6, .seed = 2});
  ASSERT_FALSE(old_map.empty() || new_map.empty());
  const SE3 truth = true_T(old_map[0], new_map[0]);
  for (int k = 0; k < 4; ++k) {
    const SE3 guess = pushed(truth, 19.0, 1.6 * k, k % 2 == 0 ? 15 : -15);
    const auto starts = search_around(new_map[0], old_map[0], guess, {20, 20, 16 * kDeg}, {});
    ASSERT_FALSE(starts.empty());
    const SE3 apart = starts[0].T_target_source.inverse() * truth;
    // Half a cell each way, half a step of yaw, and noise.
    EXPECT_LT(apart.t.norm(), 1.0) << k;
    EXPECT_LT(math::so3_log(apart.R).norm(), 3 * kDeg) << k;
  }
}

TEST(SearchAround, KeepsWithinItsRegion) {
  SearchConfig config;
  config.min_score = 0.01;
  const auto starts = search_around(hall().rosette[0], hall().rings[0], {}, {2.0, 2.0, 5 * kDeg}, config);
  for (const Start& start : starts) EXPECT_LE(start.T_target_source.t.head<2>().norm(), 2.0 + 1e-9);
}

TEST(FitHeight, IsNotFooledByAScannerThatSeesTheCeilingOnly) {
  Points room, above;
  add_wall(room, {-6, -4}, {6, -4}, 4.0);
  add_wall(room, {-6, 4}, {6, 4}, 4.0);
  add_wall(room, {-6, -4}, {-6, 4}, 4.0);
  above = room;
  add_plane(room, {-6, -4, -1}, {12, 0, 0}, {0, 8, 0});
  add_plane(above, {-6, -4, 3}, {12, 0, 0}, {0, 8, 0});
  const SE3 T = fit_height(drawn_submap(above, {}, 0.01, 1), drawn_submap(room, {}, 0.01, 2),
                           level_pose(0, 0, 1.1, 0), 5.0);
  EXPECT_NEAR(T.t.z(), 0.0, 0.25);  // one step
}

TEST(StructureGrid, BoundsAreNeverBelowWhatTheyBound) {
  math::Random random(9);
  std::vector<keyframe::Column> columns;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector2d p(random.uniform(-9.5, 9.5), random.uniform(-9.5, 9.5));
    columns.push_back({p.cast<float>(), static_cast<float>(random.uniform())});
  }
  const StructureGrid grid(columns, {.reach = 10.0}, 5);
  for (int level = 1; level < 5; ++level) {
    for (int k = 0; k < 500; ++k) {
      const int x = static_cast<int>(random.uniform(-45, 25)), y = static_cast<int>(random.uniform(-45, 25));
      float largest = 0.0F;
      for (int dx = 0; dx < 1 << level; ++dx) {
        for (int dy = 0; dy < 1 << level; ++dy) largest = std::max(largest, grid.bound(0, x + dx, y + dy));
      }
      EXPECT_EQ(grid.bound(level, x, y), largest);
    }
  }
}

}  // namespace
}  // namespace mmlins::registration

// SPDX-License-Identifier: MIT
#include "mmlins/mapping/consistency.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::mapping {
namespace {

using math::SE3;

constexpr double kDeg = M_PI / 180.0;

Placement placement(const math::Vector3d& t, double yaw_deg, double weight = 1.0) {
  Placement one;
  one.T_into_world = {math::so3_exp({0.0, 0.0, yaw_deg * kDeg}), t};
  one.weight = weight;
  return one;
}

TEST(Agreement, AllowsForAFixedDifferenceAndSomeForEachMetreOfWay) {
  const MergeConfig config{.agree_within = 0.1, .agree_within_per_m = 0.01};
  Placement a = placement({0, 0, 0}, 0), b = placement({0.15, 0, 0}, 0);
  EXPECT_FALSE(agree(a, b, config));
  // 2 m and 4 m of way allow for 6 cm more.
  a.source_way = 10.0;
  b.source_way = 12.0;
  a.target_way = 7.0;
  b.target_way = 3.0;
  EXPECT_TRUE(agree(a, b, config));
  EXPECT_TRUE(agree(b, a, config));
  b.T_into_world.t.x() = 0.17;
  EXPECT_FALSE(agree(a, b, config));
}

TEST(Agreement, ComparesWhereThePlaceItselfIsPutNotTheOrigin) {
  // Turned by 0.4 degrees about a place 100 m from the origin: the same there, 0.7 m apart at the origin.
  const math::Vector3d p(100.0, 0.0, 0.0);
  Placement a = placement({0, 0, 0}, 0), b = placement({0, 0, 0}, 0.4);
  b.T_into_world.t = p - b.T_into_world.R * p;
  a.p_world = b.p_world = p;
  EXPECT_TRUE(agree(a, b, {}));
  a.p_world = b.p_world = math::Vector3d::Zero();
  EXPECT_FALSE(agree(a, b, {}));
}

TEST(Agreement, RefusesAnotherHeading) {
  const MergeConfig config{.agree_within_deg = 0.5, .agree_within_deg_per_m = 0.0};
  EXPECT_TRUE(agree(placement({0, 0, 0}, 0), placement({0, 0, 0}, 0.49), config));
  EXPECT_FALSE(agree(placement({0, 0, 0}, 0), placement({0, 0, 0}, 0.51), config));
}

/// The heaviest set of which all agree with all, by trying all sets.
double heaviest(const std::vector<Placement>& placements, const MergeConfig& config) {
  double best = 0.0;
  for (unsigned set = 0; set < 1U << placements.size(); ++set) {
    double weight = 0.0;
    bool all_agree = true;
    for (std::size_t i = 0; i < placements.size(); ++i) {
      if ((set >> i & 1U) == 0) continue;
      weight += placements[i].weight;
      for (std::size_t j = 0; j < i; ++j) {
        all_agree = all_agree && ((set >> j & 1U) == 0 || agree(placements[i], placements[j], config));
      }
    }
    if (all_agree) best = std::max(best, weight);
  }
  return best;
}

TEST(LargestAgreement, IsTheHeaviestSetThatTryingAllSetsFinds) {
  math::Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Placement> placements;
    for (int i = 0; i < 10; ++i) {
      placements.push_back(placement({random.uniform(0.0, 0.3), random.uniform(0.0, 0.3), 0.0}, 0.0,
                                     random.uniform(0.3, 1.0)));
    }
    const std::vector<std::size_t> members = largest_agreement(placements, {});
    double weight = 0.0;
    for (const std::size_t i : members) {
      weight += placements[i].weight;
      for (const std::size_t j : members) EXPECT_TRUE(i == j || agree(placements[i], placements[j], {}));
    }
    EXPECT_NEAR(weight, heaviest(placements, {}), 1e-12);
  }
}

TEST(LargestAgreement, BelievesManyTrueOnesAmongLonersAndAPairOfLiars) {
  std::vector<Placement> placements{placement({9, 0, 0}, 20),     placement({5, 5, 0}, 0),
                                    placement({5, 0, 1}, 90),     placement({5.02, 0, 1}, 90),
                                    placement({5.01, 5, 0}, 0.1), placement({5, 5.03, 0}, 0)};
  EXPECT_EQ(largest_agreement(placements, {}), (std::vector<std::size_t>{1, 4, 5}));
}

TEST(LargestAgreement, OfNothingIsNothing) { EXPECT_TRUE(largest_agreement({}, {}).empty()); }

TEST(LargestAgreement, LooksAtTheLatestThirty) {
  std::vector<Placement> placements(40, placement({0, 0, 0}, 0));
  const std::vector<std::size_t> members = largest_agreement(placements, {});
  ASSERT_EQ(members.size(), 30U);
  EXPECT_EQ(members.front(), 10U);
  EXPECT_EQ(members.back(), 39U);
}

}  // namespace
}  // namespace mmlins::mapping

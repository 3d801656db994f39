// SPDX-License-Identifier: MIT
#include "mmlins/odometry/return_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mmlins::odometry {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Attempt ended_at(double x, double explained) {
  Attempt attempt;
  attempt.state.p_odom = Vector3d(x, 0.0, 0.0);
  attempt.explained = explained;
  return attempt;
}

TEST(PlacesToTry, BeginWithThePredictionItself) {
  const auto places = places_to_try(0.5 * Matrix3d::Identity());
  ASSERT_FALSE(places.empty());
  EXPECT_EQ(places.front(), Vector3d::Zero());
}

TEST(PlacesToTry, ReachTwoDoubledStandardDeviationsAlongTheEllipseAndNowhereElse) {
  // One metre along a diagonal, 0.1 m across it.
  const Vector3d along = Vector3d(1.0, 1.0, 0.0).normalized();
  const Matrix3d P = 0.01 * Matrix3d::Identity() + (1.0 - 0.01) * along * along.transpose();
  const auto places = places_to_try(P);
  double farthest = 0.0;
  for (const Vector3d& place : places) {
    EXPECT_NEAR((place - along * along.dot(place)).norm(), 0.0, 1e-9);
    farthest = std::max(farthest, place.norm());
  }
  EXPECT_NEAR(farthest, 4.0, 1e-9);
  EXPECT_EQ(places.size(), 5U);
}

TEST(PlacesToTry, AreNoneWhereTheDoubtIsWiderThanASearch) {
  EXPECT_EQ(places_to_try(Matrix3d::Identity()).size(), 21U);
  EXPECT_TRUE(places_to_try(2.0 * Matrix3d::Identity()).empty());
}

TEST(Choose, StaysWithThePredictionUnlessAnotherPlaceExplainsClearlyMore) {
  EXPECT_EQ(choose({ended_at(0.0, 0.50), ended_at(2.0, 0.52)})->start.p_odom.x(), 0.0);
  EXPECT_EQ(choose({ended_at(0.0, 0.40), ended_at(2.0, 0.80)})->start.p_odom.x(), 2.0);
}

TEST(Choose, NamesRivalsElsewhereThatExplainNearlyAsMuch) {
  EXPECT_EQ(choose({ended_at(0.0, 0.8), ended_at(0.1, 0.8), ended_at(2.0, 0.4)})->rivals.size(), 0U);
  const auto found = choose({ended_at(0.0, 0.8), ended_at(3.0, 0.78)});
  ASSERT_EQ(found->rivals.size(), 1U);
  EXPECT_EQ(found->rivals[0].x(), 3.0);
}

TEST(Choose, FindsNothingWhereNothingMatched) {
  EXPECT_FALSE(choose({}));
  EXPECT_FALSE(choose({ended_at(0.0, 0.0), ended_at(1.0, 0.0)}));
}

}  // namespace
}  // namespace mmlins::odometry

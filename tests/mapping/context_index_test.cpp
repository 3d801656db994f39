// SPDX-License-Identifier: MIT
#include "mmlins/mapping/context_index.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/math/random.hpp"
#include "mmlins/math/so3.hpp"

namespace mmlins::mapping {
namespace {

using Points = std::vector<Eigen::Vector3f>;

constexpr auto kAll = [](int) { return true; };
/// Of one sector [rad].
const double kSector = 2.0 * M_PI / place::ScanContextConfig{}.num_sectors;

/// Poles of random height.
Points place_of(std::uint64_t seed) {
  math::Random random(seed);
  Points points;
  for (int i = 0; i < 150; ++i) {
    const double bearing = random.uniform(-M_PI, M_PI), range = random.uniform(3.0, 70.0);
    points.emplace_back(range * std::cos(bearing), range * std::sin(bearing), random.uniform(0.0, 10.0));
  }
  return points;
}

Points turned(const Points& points, double yaw) {
  Points out;
  for (const auto& p : points) out.push_back((math::so3_exp({0, 0, yaw}) * p.cast<double>()).cast<float>());
  return out;
}

struct TenPlaces {
  ContextIndex index{place::ScanContextConfig{}};
  TenPlaces() {
    for (int i = 0; i < 10; ++i) index.add(100 + i, index.describe(place_of(static_cast<std::uint64_t>(i))));
  }
};

TEST(ContextIndex, FindsThePlaceHoweverOneIsTurned) {
  const TenPlaces places;
  for (const int steps : {-23, -5, 0, 7, 29}) {
    // Who has turned to the left sees everything farther to the right.
    const auto context = places.index.describe(turned(place_of(4), -steps * kSector));
    const auto hit = places.index.find(context, 0.4, kAll);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->keyframe, 104);
    EXPECT_NEAR(hit->yaw, steps * kSector, 0.5 * kSector);
    // Poles at the edges of sectors change over to the next by rounding.
    EXPECT_LT(hit->distance, 0.1);
  }
}

TEST(ContextIndex, LeavesOutWhoIsNotEligible) {
  const TenPlaces places;
  const auto context = places.index.describe(place_of(4));
  const auto hit = places.index.find(context, 1.0, [](int keyframe) { return keyframe != 104; });
  ASSERT_TRUE(hit);
  EXPECT_NE(hit->keyframe, 104);
  EXPECT_FALSE(places.index.find(context, 1.0, [](int) { return false; }));
}

TEST(ContextIndex, FindsNothingThatIsNotNearEnough) {
  const TenPlaces places;
  const auto context = places.index.describe(place_of(77));
  const auto nearest = places.index.find(context, 2.0, kAll);
  ASSERT_TRUE(nearest);
  EXPECT_FALSE(places.index.find(context, nearest->distance, kAll));
}

}  // namespace
}  // namespace mmlins::mapping

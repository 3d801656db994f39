// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/submap_cutter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::keyframe {
namespace {

/// A drive with steps of uneven length that sometimes turns on the spot.
Keyframes uneven_drive(int count, std::uint64_t seed) {
  math::Random random(seed);
  Keyframes keyframes;
  math::SE3 T_map_imu;
  for (int i = 0; i < count; ++i) {
    Keyframe kf;
    kf.id = i;
    kf.T_map_imu = T_map_imu;
    keyframes.push_back(std::make_shared<const Keyframe>(std::move(kf)));
    const bool turns = random.chance(0.3);
    const math::SE3 step{math::so3_exp({0.0, 0.0, turns ? random.uniform(0.1, 1.5) : 0.0}),
                         {turns ? 0.0 : random.uniform(0.2, 2.0), 0.0, 0.0}};
    T_map_imu = T_map_imu * step;
  }
  return keyframes;
}

/// First and last id of every submap.
using Cuts = std::vector<std::pair<int, int>>;

Cuts cuts_as_it_grows(const Keyframes& keyframes, const SubmapConfig& config) {
  SubmapCutter cutter(config);
  Cuts cuts;
  for (const auto& kf : keyframes) {
    if (const auto complete = cutter.add(kf)) cuts.emplace_back(complete->front()->id, complete->back()->id);
  }
  if (const auto rest = cutter.finish()) cuts.emplace_back(rest->front()->id, rest->back()->id);
  return cuts;
}

Cuts cuts_of_all(const Keyframes& keyframes, const SubmapConfig& config) {
  Cuts cuts;
  for (const KeyframeRange& range : split_by_travel(keyframes, config)) {
    cuts.emplace_back(keyframes[range.first]->id, keyframes[range.last - 1]->id);
  }
  return cuts;
}

TEST(SubmapCutter, CutsAsOneWouldWhoKnowsTheWholeDrive) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const Keyframes keyframes = uneven_drive(10 + 3 * static_cast<int>(seed), seed);
    const SubmapConfig config{.travel = 10.0, .max_turn_deg = 270.0};
    EXPECT_EQ(cuts_as_it_grows(keyframes, config), cuts_of_all(keyframes, config)) << "seed " << seed;
  }
}

TEST(SubmapCutter, HasEveryKeyframeInSomeSubmap) {
  const Keyframes keyframes = uneven_drive(120, 7);
  std::vector<bool> covered(keyframes.size(), false);
  for (const auto& [first, last] : cuts_as_it_grows(keyframes, {.travel = 10.0})) {
    for (int id = first; id <= last; ++id) covered[static_cast<std::size_t>(id)] = true;
  }
  EXPECT_EQ(std::count(covered.begin(), covered.end(), false), 0);
}

TEST(SubmapCutter, BeginsANewMapAfresh) {
  SubmapCutter cutter({.travel = 10.0});
  const Keyframes keyframes = uneven_drive(8, 1);
  for (const auto& kf : keyframes) EXPECT_FALSE(cutter.add(kf));
  const auto rest = cutter.finish();
  ASSERT_TRUE(rest);
  EXPECT_EQ(rest->size(), keyframes.size());
  EXPECT_TRUE(cutter.pending().empty());
  EXPECT_FALSE(cutter.finish());
}

}  // namespace
}  // namespace mmlins::keyframe

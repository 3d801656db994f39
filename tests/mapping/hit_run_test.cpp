// SPDX-License-Identifier: MIT
#include "mmlins/mapping/hit_run.hpp"

#include <gtest/gtest.h>

namespace mmlins::mapping {
namespace {

HitRun run_of(const std::vector<double>& distances) {
  HitRun run;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    run = extend(std::move(run), SimilarPair{.source = static_cast<int>(i), .distance = distances[i]});
  }
  return run;
}

TEST(HitRun, MustBeLongerThanTheThreshold) {
  EXPECT_FALSE(is_consistent({}, 0));
  EXPECT_TRUE(is_consistent(run_of({0.1}), 0));
  EXPECT_FALSE(is_consistent(run_of({0.1, 0.1, 0.1}), 3));
  EXPECT_TRUE(is_consistent(run_of({0.1, 0.1, 0.1, 0.1}), 3));
}

TEST(HitRun, BeginsAnewAfterAMiss) {
  HitRun run = extend(run_of({0.1, 0.1, 0.1}), std::nullopt);
  EXPECT_TRUE(run.empty());
  run = extend(std::move(run), SimilarPair{.source = 7});
  ASSERT_EQ(run.size(), 1U);
  EXPECT_EQ(run.front().source, 7);
}

TEST(HitRun, GivesTheLatestPairsWithTheMostSimilarFirst) {
  const HitRun pairs = latest_pairs(run_of({0.05, 0.3, 0.2, 0.1, 0.4}), 4);
  ASSERT_EQ(pairs.size(), 4U);
  EXPECT_EQ(pairs[0].source, 3);  // the most similar of all, 0, is too old
  EXPECT_EQ(pairs[1].source, 1);  // the others keep their order
  EXPECT_EQ(pairs[2].source, 2);
  EXPECT_EQ(pairs[3].source, 4);
}

TEST(HitRun, GivesAllPairsIfThereAreFewer) {
  EXPECT_EQ(latest_pairs(run_of({0.2, 0.1}), 5).size(), 2U);
  EXPECT_TRUE(latest_pairs({}, 5).empty());
}

}  // namespace
}  // namespace mmlins::mapping

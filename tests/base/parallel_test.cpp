// SPDX-License-Identifier: MIT
#include "mmlins/base/parallel.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace mmlins::parallel {
namespace {

/// Restores the limit, so that one test does not decide about the next.
struct ThreadsGuard {
  ~ThreadsGuard() { set_num_threads(0); }
};

/// A sum whose bits depend on the order of its terms.
double delicate_sum(std::size_t size, std::size_t grain) {
  return ordered_sum(size, grain, 0.0, [](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i)
      sum += std::sin(1e3 * static_cast<double>(i)) * std::exp(0.001 * (i % 7919));
    return sum;
  });
}

TEST(Parallel, SumsHaveTheSameBitsForEveryNumberOfThreads) {
  const ThreadsGuard guard;
  set_num_threads(1);
  const double expected = delicate_sum(100'003, 64);
  for (const int threads : {1, 2, 4, 0}) {
    set_num_threads(threads);
    for (int repetition = 0; repetition < 5; ++repetition) {
      const double sum = delicate_sum(100'003, 64);
      EXPECT_EQ(std::memcmp(&sum, &expected, sizeof sum), 0) << threads << " threads";
    }
  }
}

TEST(Parallel, TheSumOfTheTestDependsOnTheOrder) {
  EXPECT_NE(delicate_sum(100'003, 64),
            delicate_sum(100'003, 100'003));  // or the test above would prove nothing
}

TEST(Parallel, RangesCoverEveryElementOnce) {
  const ThreadsGuard guard;
  for (const int threads : {1, 3}) {
    set_num_threads(threads);
    for (const std::size_t size : {0UL, 1UL, 63UL, 64UL, 65UL, 1000UL}) {
      std::vector<int> visits(size, 0);
      for_ranges(size, 64, [&](std::size_t begin, std::size_t end) {
        EXPECT_LE(end - begin, 64U);
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), 0), static_cast<int>(size));
      EXPECT_EQ(std::count(visits.begin(), visits.end(), 1), static_cast<std::ptrdiff_t>(size));
    }
  }
}

TEST(Parallel, TheSumOfNothingIsZero) {
  EXPECT_EQ(ordered_sum(0, 16, 7, [](std::size_t, std::size_t) { return 1; }), 7);
}

TEST(Parallel, NoLimitMeansAllCores) {
  const ThreadsGuard guard;
  set_num_threads(3);
  EXPECT_EQ(num_threads(), 3);
  set_num_threads(0);
  EXPECT_GE(num_threads(), 1);
}

}  // namespace
}  // namespace mmlins::parallel

// SPDX-License-Identifier: MIT
#include "mmlins/base/time.hpp"

#include <gtest/gtest.h>

#include <type_traits>

namespace mmlins {
namespace {

template <typename T>
concept Addable = requires(T a, T b) {
  a + b;
};

TEST(Time, KeepsEveryNanosecondOfAnEpoch) {
  const std::int64_t ns = 1'700'000'000'123'456'789;
  EXPECT_EQ(to_ns(time_from_ns(ns)), ns);
  EXPECT_EQ(to_ns(time_from_ns(ns) + Duration(1)) - ns, 1);
}

TEST(Time, SecondsAreForDifferencesAndRoundToTheNearestNanosecond) {
  EXPECT_EQ(from_seconds(0.1).count(), 100'000'000);
  EXPECT_EQ(from_seconds(-1.5e-9 - 1e-12).count(), -2);
  EXPECT_EQ(from_seconds(0.4e-9).count(), 0);
  EXPECT_DOUBLE_EQ(to_seconds(time_from_ns(2'500'000'000) - time_from_ns(1'000'000'000)), 1.5);
}

TEST(Time, TwoPointsInTimeCannotBeAdded) {
  EXPECT_FALSE(Addable<Time>);
  EXPECT_TRUE(Addable<Duration>);
}

}  // namespace
}  // namespace mmlins

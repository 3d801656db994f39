// SPDX-License-Identifier: MIT
#include "mmlins/base/result.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace mmlins {
namespace {

Result<int> half_of(int number) {
  if (number % 2 != 0) return make_error(ErrorCode::kInvalid, "{} is odd", number);
  return number / 2;
}

TEST(Result, HoldsAValueOrAnErrorWithItsMessage) {
  EXPECT_TRUE(half_of(4).ok());
  EXPECT_EQ(*half_of(4), 2);
  EXPECT_FALSE(half_of(3));
  EXPECT_EQ(half_of(3).error().message, "3 is odd");
  EXPECT_EQ(half_of(3).error().code, ErrorCode::kInvalid);
}

TEST(Result, ValuesThatCannotBeCopiedAreMovedOut) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 5);
}

TEST(Result, AStatusIsGoodUnlessItHasAnError) {
  EXPECT_TRUE(Status{}.ok());
  EXPECT_FALSE(Status{make_error(ErrorCode::kIo, "disk full")}.ok());
}

TEST(ResultDeathTest, ReadingWhatIsNotThereStopsTheProgram) {
  EXPECT_DEATH(static_cast<void>(half_of(3).value()), "check failed");
  EXPECT_DEATH(static_cast<void>(half_of(4).error()), "check failed");
}

}  // namespace
}  // namespace mmlins

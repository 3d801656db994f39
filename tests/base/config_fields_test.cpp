// SPDX-License-Identifier: MIT
#include "mmlins/base/config_fields.hpp"

#include <gtest/gtest.h>

namespace mmlins {
namespace {

enum class Shape { kRound, kSquare };

struct Inner {
  int count = 3;
  Fields fields() { return {field("count", count, "", {0.0, 9.0}, "how many")}; }
};

struct Outer {
  double size = 1.5;
  Shape shape = Shape::kRound;
  std::array<double, 2> place{1.0, 2.0};
  Inner inner;
  Fields fields() {
    return {field("size", size, "m", {0.0, 2.0}, "how large"),
            field("shape", shape, {"round", "square"}, "which form"), field("place", place, "m", {}, "where"),
            group("inner", inner, "the rest")};
  }
};

TEST(ConfigFields, FieldsPointAtTheMembers) {
  Outer outer;
  const Fields fields = outer.fields();
  *std::get<double*>(fields[0].value) = 0.5;
  std::get<EnumAccess>(fields[1].value).set(1);
  std::get<NumbersAccess>(fields[2].value).data[1] = -2.0;
  *std::get<int*>(std::get<Fields>(fields[3].value)[0].value) = 7;
  EXPECT_EQ(outer.size, 0.5);
  EXPECT_EQ(outer.shape, Shape::kSquare);
  EXPECT_EQ(outer.place[1], -2.0);
  EXPECT_EQ(outer.inner.count, 7);
}

TEST(ConfigFields, FieldsKnowNameUnitRangeAndLength) {
  Outer outer;
  const Fields fields = outer.fields();
  EXPECT_EQ(fields[0].name, "size");
  EXPECT_EQ(fields[0].unit, "m");
  EXPECT_EQ(fields[0].range.max, 2.0);
  EXPECT_EQ(std::get<EnumAccess>(fields[1].value).get(), 0);
  EXPECT_EQ(std::get<NumbersAccess>(fields[2].value).size, 2);
}

}  // namespace
}  // namespace mmlins

// SPDX-License-Identifier: MIT
#include "mmlins/io/point_time.hpp"

#include <gtest/gtest.h>

#include "mmlins/io/point_cloud2_decode.hpp"
#include "mmlins/io/to_scan.hpp"
#include "tests/io/message_builder.hpp"

namespace mmlins::io {
namespace {

using sensor::Rig;
using sensor::StampReference;
using sensor::TimeReference;
using sensor::TimeUnit;

constexpr TimeUnit kUnits[] = {TimeUnit::kSeconds, TimeUnit::kMilliseconds, TimeUnit::kMicroseconds,
                               TimeUnit::kNanoseconds};
constexpr std::int64_t kEpoch = 1'700'000'000'000'000'000;  // [ns]

/// A sensor as a test wants it: scans of `span` every `period`, their stamp `stamp_after_start` later than
/// their start, and times that count from `zero` (or from the stamp).
struct Timing {
  double period = 0.1;             // [s]
  double span = 0.099;             // [s]
  double stamp_after_start = 0.0;  // [s]
  bool is_absolute = false;
  std::int64_t first_stamp = kEpoch;  // [ns]
  double zero = 0.0;                  // [s] of absolute times, after the epoch
};

std::vector<TimeFieldRange> ranges_of(const Timing& timing, TimeUnit unit, int num_scans = 10) {
  std::vector<TimeFieldRange> ranges;
  const double per_second = 1e9 / static_cast<double>(nanoseconds_per(unit));
  for (int i = 0; i < num_scans; ++i) {
    const Time stamp = time_from_ns(timing.first_stamp) + from_seconds(timing.period * i);
    double start = -timing.stamp_after_start;
    if (timing.is_absolute) start += 1e-9 * static_cast<double>(to_ns(stamp)) - timing.zero;
    ranges.push_back({stamp, start * per_second, (start + timing.span) * per_second});
  }
  return ranges;
}

PointTimeModel found(const Timing& timing, TimeUnit unit, const Rig& rig = {}, int num_scans = 10) {
  return find_time_model("time", FieldType::kFloat64, ranges_of(timing, unit, num_scans), rig);
}

TEST(PointTime, EveryUnitIsFoundForRelativeAndAbsoluteTimes) {
  for (const TimeUnit unit : kUnits) {
    for (const bool is_absolute : {false, true}) {
      for (const double period : {0.02, 0.05, 0.1, 0.2}) {
        Timing timing{.period = period, .span = 0.97 * period, .is_absolute = is_absolute};
        const PointTimeModel model = found(timing, unit);
        EXPECT_EQ(model.unit, unit) << period;
        EXPECT_EQ(model.origin, is_absolute ? TimeOrigin::kEpoch : TimeOrigin::kStamp) << period;
        EXPECT_EQ(model.stamp, StampReference::kStart);
        EXPECT_FALSE(model.instantaneous);
        EXPECT_EQ(model.shift, Duration(0));
        // A double of this size resolves 0.24 us at the epoch.
        EXPECT_NEAR(to_seconds(model.span), timing.span, 1e-6);
      }
    }
  }
}

TEST(PointTime, StampAtTheEndIsFound) {
  for (const TimeUnit unit : kUnits) {
    for (const bool is_absolute : {false, true}) {
      const PointTimeModel model = found({.stamp_after_start = 0.099, .is_absolute = is_absolute}, unit);
      EXPECT_EQ(model.unit, unit);
      EXPECT_EQ(model.origin, is_absolute ? TimeOrigin::kEpoch : TimeOrigin::kStamp);
      EXPECT_EQ(model.stamp, StampReference::kEnd);
      EXPECT_EQ(model.shift, Duration(0));
    }
  }
}

TEST(PointTime, KeyframesFarApartDoNotChangeTheUnit) {
  for (const TimeUnit unit : kUnits) {
    EXPECT_EQ(found({.period = 0.4}, unit).unit, unit);
    EXPECT_EQ(found({.period = 30.0}, unit).unit, unit);
    EXPECT_EQ(found({}, unit, {}, 1).unit, unit);  // a single scan
  }
}

TEST(PointTime, AbsoluteTimesAreToldFromRelativeOnesWhenTheClockStartsAtZero) {
  const Timing absolute{.is_absolute = true, .first_stamp = 0};
  const Timing relative{.is_absolute = false, .first_stamp = 0};
  EXPECT_EQ(found(absolute, TimeUnit::kSeconds).origin, TimeOrigin::kEpoch);
  EXPECT_EQ(found(relative, TimeUnit::kSeconds).origin, TimeOrigin::kStamp);
}

TEST(PointTime, TimesOnAClockOfTheirOwnAreRecognised) {
  for (const TimeUnit unit : kUnits) {
    const PointTimeModel model = found({.is_absolute = true, .zero = 1'699'990'000.0}, unit);
    EXPECT_EQ(model.unit, unit);
    EXPECT_EQ(model.origin, TimeOrigin::kOwnClock);
  }
}

TEST(PointTime, EqualTimesMeanAnInstantaneousScan) {
  const PointTimeModel zero = found({.span = 0.0}, TimeUnit::kSeconds);
  EXPECT_TRUE(zero.instantaneous);
  EXPECT_EQ(zero.origin, TimeOrigin::kStamp);
  for (const TimeUnit unit : kUnits) {
    const PointTimeModel stamps = found({.span = 0.0, .is_absolute = true}, unit);
    EXPECT_TRUE(stamps.instantaneous);
    EXPECT_EQ(stamps.unit, unit);
    EXPECT_EQ(stamps.origin, TimeOrigin::kEpoch);
  }
}

TEST(PointTime, AScanWithAStrayTimeDoesNotChangeTheVerdict) {
  auto ranges = ranges_of({.is_absolute = true}, TimeUnit::kSeconds);
  ranges[2].min = 0.0;
  const PointTimeModel model = find_time_model("timestamp", FieldType::kFloat64, ranges, {});
  EXPECT_EQ(model.unit, TimeUnit::kSeconds);
  EXPECT_EQ(model.origin, TimeOrigin::kEpoch);
}

TEST(PointTime, TheRigIsBelieved) {
  Rig rig;
  rig.time_unit = TimeUnit::kMicroseconds;
  rig.time_reference = TimeReference::kAbsolute;
  const PointTimeModel model = found({}, TimeUnit::kSeconds, rig);
  EXPECT_EQ(model.unit, TimeUnit::kMicroseconds);
  EXPECT_EQ(model.origin, TimeOrigin::kEpoch);
}

TEST(PointTime, AStampThatTheRigPutsAtTheEndMovesThePoints) {
  Rig rig;
  rig.stamp_reference = StampReference::kEnd;
  const PointTimeModel moved = found({}, TimeUnit::kMilliseconds, rig);
  EXPECT_EQ(moved.stamp, StampReference::kEnd);
  EXPECT_EQ(moved.shift, -Duration(99'000'000));
  EXPECT_EQ(found({.stamp_after_start = 0.099}, TimeUnit::kMilliseconds, rig).shift, Duration(0));
  rig.stamp_reference = StampReference::kStart;
  EXPECT_EQ(found({.stamp_after_start = 0.099}, TimeUnit::kMilliseconds, rig).shift, Duration(99'000'000));
}

TEST(PointTime, TheUsualNamesOfTheFieldAreKnown) {
  for (const char* name : {"t", "time", "timestamp", "timestamps", "offset_time", "time_stamp"}) {
    const auto field = find_time_field({{"x"}, {"y"}, {name}}, {});
    ASSERT_TRUE(field.ok());
    EXPECT_EQ(*field, name);
  }
  EXPECT_EQ(*find_time_field({{"x"}, {"tag"}}, {}), "");
}

TEST(PointTime, AFieldOfTheRigThatIsNotThereIsAnError) {
  Rig rig;
  rig.time_field = "when";
  EXPECT_EQ(*find_time_field({{"t"}, {"when"}}, rig), "when");
  const auto field = find_time_field({{"x"}, {"t"}}, rig);
  ASSERT_FALSE(field.ok());
  EXPECT_NE(field.error().message.find("when (fields: x, t)"), std::string::npos) << field.error().message;
}

// ---- from the times of a message to those of a scan ----------------------------------------------

LidarCloud cloud_with(std::vector<std::int64_t> times) {
  LidarCloud cloud;
  cloud.stamp = time_from_ns(kEpoch);
  cloud.points.assign(times.size(), Eigen::Vector3f::Ones());
  cloud.times = std::move(times);
  return cloud;
}

TEST(ToScan, RelativeTimesCountFromTheStamp) {
  const auto scan = to_scan(cloud_with({20'000'000, -10'000'000, 0}), {.field = "t"}, Duration(0));
  EXPECT_EQ(to_ns(scan.start_time), kEpoch - 10'000'000);
  EXPECT_EQ(to_ns(scan.end_time), kEpoch + 20'000'000);
  EXPECT_EQ(scan.offsets, (std::vector<float>{0.03F, 0.0F, 0.01F}));
}

TEST(ToScan, AbsoluteTimesDoNotDependOnTheStamp) {
  const PointTimeModel model{.field = "t", .origin = TimeOrigin::kEpoch};
  const auto scan = to_scan(cloud_with({kEpoch + 5, kEpoch + 3}), model, Duration(0));
  EXPECT_EQ(to_ns(scan.start_time), kEpoch + 3);
  EXPECT_EQ(to_ns(scan.end_time), kEpoch + 5);
}

TEST(ToScan, TimesOfAnOwnClockAreMovedToTheStamp) {
  PointTimeModel model{.field = "t", .origin = TimeOrigin::kOwnClock};
  const auto from_start = to_scan(cloud_with({1005, 1003}), model, Duration(0));
  EXPECT_EQ(to_ns(from_start.start_time), kEpoch);
  EXPECT_EQ(to_ns(from_start.end_time), kEpoch + 2);
  model.stamp = StampReference::kEnd;
  EXPECT_EQ(to_ns(to_scan(cloud_with({1005, 1003}), model, Duration(0)).end_time), kEpoch);
}

TEST(ToScan, OffsetOfTheClocksIsAddedOnce) {
  const auto scan = to_scan(cloud_with({0, 10}), {.field = "t"}, Duration(100));
  EXPECT_EQ(to_ns(scan.start_time), kEpoch + 100);
  EXPECT_EQ(to_ns(scan.end_time), kEpoch + 110);
  const auto empty = to_scan(cloud_with({}), {.field = "t"}, Duration(100));
  EXPECT_EQ(to_ns(empty.start_time), kEpoch + 100);
  EXPECT_EQ(to_ns(empty.end_time), kEpoch + 100);
}

TEST(ToScan, EqualTimesMakeAnInstantaneousScan) {
  const auto scan = to_scan(cloud_with({50'000'000, 50'000'000}), {.field = "t"}, Duration(0));
  EXPECT_EQ(to_ns(scan.start_time), kEpoch + 50'000'000);
  EXPECT_EQ(scan.start_time, scan.end_time);
}

TEST(ToScan, PointsWithStrayTimesAreDroppedAndCounted) {
  const PointTimeModel model{.field = "t", .origin = TimeOrigin::kEpoch};
  const auto scan = to_scan(cloud_with({0, kEpoch + 7, kEpoch + 9}), model, Duration(0));
  EXPECT_EQ(scan.num_invalid, 1);
  EXPECT_EQ(scan.size(), 2U);
  EXPECT_EQ(to_ns(scan.start_time), kEpoch + 7);
}

// ---- both together, from the bytes ---------------------------------------------------------------

struct Encoding {
  FieldType type;
  TimeUnit unit;
  bool is_absolute;
  std::int64_t tolerance;  // [ns]: what the type resolves
};

TEST(PointTime, EveryTypeThatCanHoldAUnitGivesTheTrueTimes) {
  const Encoding encodings[] = {
      {FieldType::kFloat32, TimeUnit::kSeconds, false, 4},  // 2^-28 s
      {FieldType::kFloat32, TimeUnit::kMilliseconds, false, 4},
      {FieldType::kFloat32, TimeUnit::kMicroseconds, false, 4},
      {FieldType::kFloat32, TimeUnit::kNanoseconds, false, 4},
      {FieldType::kFloat64, TimeUnit::kSeconds, false, 1},
      {FieldType::kFloat64, TimeUnit::kNanoseconds, false, 1},
      {FieldType::kFloat64, TimeUnit::kSeconds, true, 240},  // half of 2^-21 s
      {FieldType::kFloat64, TimeUnit::kMilliseconds, true, 240},
      {FieldType::kFloat64, TimeUnit::kMicroseconds, true, 250},
      {FieldType::kFloat64, TimeUnit::kNanoseconds, true, 256},
      {FieldType::kUint32, TimeUnit::kMicroseconds, false, 1000},
      {FieldType::kUint32, TimeUnit::kNanoseconds, false, 1},
      {FieldType::kInt32, TimeUnit::kMicroseconds, false, 1000},
      {FieldType::kInt32, TimeUnit::kNanoseconds, false, 1},
      {FieldType::kUint64, TimeUnit::kNanoseconds, false, 1},
      {FieldType::kUint64, TimeUnit::kMicroseconds, true, 1000},
      {FieldType::kUint64, TimeUnit::kNanoseconds, true, 256}};  // written by a double
  for (const Encoding& encoding : encodings) {
    std::vector<TimeFieldRange> ranges;
    Buffer message;
    for (int scan = 0; scan < 10; ++scan) {
      auto builder = CloudBuilder::with_fields({{"time", encoding.type}});
      builder.stamp = time_from_ns(kEpoch + scan * 100'000'000);
      const double origin = encoding.is_absolute ? static_cast<double>(to_ns(builder.stamp)) : 0.0;  // [ns]
      for (int i = 0; i < 100; ++i) {
        builder.add({1, 2, 3, (origin + 1e6 * i) / static_cast<double>(nanoseconds_per(encoding.unit))});
      }
      message = builder.message();
      const auto view = parse_point_cloud2(bytes_of(message));
      ASSERT_TRUE(view.ok());
      const auto extremes = time_extremes(*view, *resolve_layout(builder.fields, builder.point_step, "time"));
      ranges.push_back({builder.stamp, extremes->first, extremes->second});
    }
    const PointTimeModel model = find_time_model("time", encoding.type, ranges, {});
    const auto name = testing::Message()
                      << "type " << static_cast<int>(encoding.type) << " unit "
                      << static_cast<int>(encoding.unit) << " absolute " << encoding.is_absolute;
    EXPECT_EQ(model.unit, encoding.unit) << name;
    EXPECT_EQ(model.origin, encoding.is_absolute ? TimeOrigin::kEpoch : TimeOrigin::kStamp) << name;
    PointCloud2Decoder decoder("time", nanoseconds_per(model.unit));
    auto cloud = decoder.decode(bytes_of(message));
    ASSERT_TRUE(cloud.ok());
    const auto scan = to_scan(std::move(cloud).value(), model, Duration(0));
    EXPECT_LE(std::abs(to_ns(scan.start_time) - (kEpoch + 900'000'000)), encoding.tolerance) << name;
    EXPECT_LE(std::abs(to_ns(scan.end_time) - (kEpoch + 999'000'000)), encoding.tolerance) << name;
    EXPECT_NEAR(static_cast<double>(scan.offsets[50]), 0.05,
                2e-9 * static_cast<double>(encoding.tolerance) + 4e-9)
        << name;
  }
}

}  // namespace
}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include "mmlins/sensor/imu_buffer.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace mmlins::sensor {
namespace {

constexpr double kRounding = 1e-12;

Time at(double ms) { return time_from_ns(1700000000000000000) + from_seconds(1e-3 * ms); }

/// A sample of signals that are linear in time, so that interpolation is exact.
ImuSample sample_of(double ms) { return {at(ms), {ms, 2.0 * ms, -ms}, {1.0, ms, 9.81}}; }

ImuBuffer make_buffer() {
  ImuBuffer buffer;
  for (const double ms : {0.0, 5.0, 10.0, 17.0, 20.0})
    EXPECT_EQ(buffer.add(sample_of(ms)), ImuAdmission::kAccepted);
  return buffer;
}

void expect_samples(const ImuSamples& samples, const std::vector<double>& expected_ms) {
  ASSERT_EQ(samples.size(), expected_ms.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_EQ(samples[i].time, at(expected_ms[i])) << i;
    EXPECT_LT((samples[i].gyro - sample_of(expected_ms[i]).gyro).norm(), kRounding) << i;
    EXPECT_LT((samples[i].accel - sample_of(expected_ms[i]).accel).norm(), kRounding) << i;
  }
}

TEST(ImuBuffer, StretchesBeginAndEndExactlyWhereTheyShould) {
  expect_samples(make_buffer().covering(at(2.0), at(18.5)), {2.0, 5.0, 10.0, 17.0, 18.5});
  expect_samples(make_buffer().covering(at(6.0), at(7.0)), {6.0, 7.0});
}

TEST(ImuBuffer, SamplesOnTheEndsAppearOnce) {
  expect_samples(make_buffer().covering(at(5.0), at(17.0)), {5.0, 10.0, 17.0});
}

TEST(ImuBuffer, AnInstantIsOneSample) {
  expect_samples(make_buffer().covering(at(7.0), at(7.0)), {7.0});
  expect_samples(make_buffer().covering(at(10.0), at(10.0)), {10.0});
}

TEST(ImuBuffer, BeyondItsEndsTheNearestSampleIsHeld) {
  const ImuSamples samples = make_buffer().covering(at(-3.0), at(25.0));
  ASSERT_EQ(samples.size(), 7U);
  EXPECT_EQ(samples.front().time, at(-3.0));
  EXPECT_EQ(samples.front().gyro, sample_of(0.0).gyro);
  EXPECT_EQ(samples.back().time, at(25.0));
  EXPECT_EQ(samples.back().gyro, sample_of(20.0).gyro);
}

TEST(ImuBuffer, SamplesThatAreNotLaterAreRefused) {
  ImuBuffer buffer = make_buffer();
  EXPECT_EQ(buffer.add(sample_of(20.0)), ImuAdmission::kNotLater);
  EXPECT_EQ(buffer.add(sample_of(11.0)), ImuAdmission::kNotLater);
  EXPECT_EQ(buffer.newest(), at(20.0));
  expect_samples(buffer.covering(at(10.0), at(20.0)), {10.0, 17.0, 20.0});
}

TEST(ImuBuffer, ForgettingKeepsWhatLaterStretchesNeed) {
  ImuBuffer buffer = make_buffer();
  buffer.forget_before(at(12.0));
  EXPECT_EQ(buffer.oldest(), at(10.0));
  expect_samples(buffer.covering(at(12.0), at(20.0)), {12.0, 17.0, 20.0});
  buffer.forget_before(at(100.0));
  EXPECT_EQ(buffer.oldest(), at(20.0));
}

TEST(ImuBuffer, TheLongestGapIsThatBetweenSamplesEvenIfTheStretchLiesWithinIt) {
  const auto gap = [](double begin, double end) {
    return 1e3 * to_seconds(make_buffer().longest_gap(at(begin), at(end)));
  };
  EXPECT_DOUBLE_EQ(gap(0.0, 20.0), 7.0);
  EXPECT_DOUBLE_EQ(gap(0.0, 10.0), 5.0);
  EXPECT_DOUBLE_EQ(gap(12.0, 13.0), 7.0);
  EXPECT_DOUBLE_EQ(gap(18.0, 19.0), 3.0);
  EXPECT_DOUBLE_EQ(gap(18.0, 50.0), 30.0);
  EXPECT_DOUBLE_EQ(gap(30.0, 50.0), 30.0);
  EXPECT_DOUBLE_EQ(gap(-9.0, 2.0), 9.0);
  EXPECT_EQ(ImuBuffer().longest_gap(at(0.0), at(3.0)), from_seconds(0.003));
}

TEST(ImuBuffer, AnEmptyBufferCoversNothing) { EXPECT_TRUE(ImuBuffer().covering(at(0.0), at(1.0)).empty()); }

}  // namespace
}  // namespace mmlins::sensor

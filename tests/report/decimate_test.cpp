// SPDX-License-Identifier: MIT
#include "mmlins/report/decimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace mmlins::report {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

std::vector<double> tenths(std::size_t count) {
  std::vector<double> t;
  for (std::size_t i = 0; i < count; ++i) t.push_back(0.1 * static_cast<double>(i));
  return t;
}

TEST(Decimate, AFewSamplesAreReturnedAsTheyAre) {
  const std::vector<double> y{3.0, kNothing, 1.0};
  const Curve curve = decimate(tenths(3), y, 3);
  EXPECT_EQ(curve.t, tenths(3));
  EXPECT_EQ(curve.y[0], 3.0);
  EXPECT_TRUE(std::isnan(curve.y[1]));
  EXPECT_EQ(curve.y[2], 1.0);
}

TEST(Decimate, ASinglePeakAndASingleDipStayAtTheirTimes) {
  std::vector<double> y(36000);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = std::sin(0.01 * static_cast<double>(i));
  y[12345] = 50.0;
  y[23456] = -40.0;
  const std::vector<double> t = tenths(y.size());
  const Curve curve = decimate(t, y, 2000);
  EXPECT_LE(curve.t.size(), 2000U + 2U);  // and the ends
  const auto peak = std::max_element(curve.y.begin(), curve.y.end()) - curve.y.begin();
  const auto dip = std::min_element(curve.y.begin(), curve.y.end()) - curve.y.begin();
  EXPECT_EQ(curve.y[static_cast<std::size_t>(peak)], 50.0);
  EXPECT_EQ(curve.t[static_cast<std::size_t>(peak)], t[12345]);
  EXPECT_EQ(curve.y[static_cast<std::size_t>(dip)], -40.0);
  EXPECT_EQ(curve.t[static_cast<std::size_t>(dip)], t[23456]);
}

TEST(Decimate, KeepsTheOrderTheEndsAndEveryValueWithItsTime) {
  std::vector<double> y(5000);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = static_cast<double>((i * 7919) % 5000);  // each value once
  const std::vector<double> t = tenths(y.size());
  const Curve curve = decimate(t, y, 300);
  EXPECT_TRUE(std::is_sorted(curve.t.begin(), curve.t.end(), std::less_equal<>()));
  EXPECT_EQ(curve.t.front(), t.front());
  EXPECT_EQ(curve.t.back(), t.back());
  for (std::size_t k = 0; k < curve.t.size(); ++k) {
    EXPECT_EQ(curve.y[k], y[static_cast<std::size_t>(std::lround(10.0 * curve.t[k]))]);
  }
}

TEST(Decimate, AGapInterruptsTheLine) {
  std::vector<double> y(10000, 1.0);
  std::fill(y.begin() + 5000, y.begin() + 5002, kNothing);
  const Curve curve = decimate(tenths(y.size()), y, 600);
  const auto gap = std::find_if(curve.y.begin(), curve.y.end(), [](double v) { return std::isnan(v); });
  ASSERT_NE(gap, curve.y.end());
  EXPECT_NEAR(curve.t[static_cast<std::size_t>(gap - curve.y.begin())], 500.0, 1e-9);
}

TEST(Histogram, CountsEveryValueOnce) {
  const Histogram histogram = histogram_of({0.0, 0.5, 1.5, 2.5, 3.9}, 4);
  EXPECT_EQ(histogram.step, 1.0);
  EXPECT_EQ(histogram.counts, (std::vector<int>{2, 1, 1, 1}));
}

TEST(Histogram, TheLastBinHoldsWhatIsLarger) {
  std::vector<double> values(1000, 5.0);
  values.push_back(1e6);
  const Histogram histogram = histogram_of(values, 40);
  EXPECT_LT(histogram.step * static_cast<double>(histogram.counts.size()), 100.0);
  EXPECT_EQ(histogram.counts.back(), 1);
  EXPECT_EQ(std::accumulate(histogram.counts.begin(), histogram.counts.end(), 0), 1001);
}

TEST(Histogram, OfNothingHasNoBins) { EXPECT_TRUE(histogram_of({}, 10).counts.empty()); }

TEST(Histogram, OfZerosIsOneBin) { EXPECT_EQ(histogram_of({0.0, 0.0}, 10).counts, (std::vector<int>{2})); }

}  // namespace
}  // namespace mmlins::report

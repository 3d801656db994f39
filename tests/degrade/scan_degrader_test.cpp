// SPDX-License-Identifier: MIT
#include "mmlins/degrade/scan_degrader.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "mmlins/degrade/effects.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::degrade {
namespace {

constexpr Time kStart = time_from_ns(1'700'000'000'000'000'000);

/// Points all around at ranges of 2 to 12 m, one every 10 us from `begin` on.
struct Sweep {
  Time stamp;
  std::vector<Eigen::Vector3f> points;
  std::vector<Time> times;

  explicit Sweep(double begin, std::size_t size = 10'000) : stamp(kStart + from_seconds(begin)) {
    math::Random random(7);
    for (std::size_t i = 0; i < size; ++i) {
      const Eigen::Vector3d direction = random.normal3().normalized();
      points.push_back((random.uniform(2.0, 12.0) * direction).cast<float>());
      times.push_back(stamp + Duration(10'000 * static_cast<std::int64_t>(i)));
    }
  }
  [[nodiscard]] SweepView view() const { return {stamp, &points, &times}; }
};

DegradedSweep degrade(const Sweep& sweep, EventKind kind, double severity = 0.0,
                      DegradeOptions options = {}) {
  return ScanDegrader({{kind, 10.0, 5.0, severity}}, kStart, options).apply(sweep.view());
}

/// Share of the points that remain, and how far from `expected` it may lie: four deviations of a share.
void expect_share(const DegradedSweep& left, const Sweep& sweep, double expected) {
  const auto n = static_cast<double>(sweep.points.size());
  EXPECT_NEAR(static_cast<double>(left.kept.size()) / n, expected,
              4.0 * std::sqrt(expected * (1.0 - expected) / n));
}

TEST(ScanDegrader, OutsideOfItsTimeNoEventChangesAnything) {
  for (const KindInfo& info : event_kinds()) {
    for (const double begin : {9.0, 9.9, 15.0, 100.0}) {
      const Sweep sweep(begin);  // 0.1 s long: 9.9 ends right before the event
      const DegradedSweep left = degrade(sweep, info.kind);
      EXPECT_FALSE(left.changed || left.lost) << info.word << " " << begin;
      EXPECT_EQ(left.points, sweep.points);
    }
  }
}

TEST(ScanDegrader, EventsBeginAndEndAtTheirTimesToTheNanosecond) {
  for (const bool at_begin : {true, false}) {
    Sweep sweep(at_begin ? 9.95 : 14.95);
    sweep.times[4999] -= Duration{1} - Duration{10'000};  // 1 ns before the change, instead of 10 us
    const DegradedSweep left = degrade(sweep, EventKind::kBlackout);
    std::vector<std::uint32_t> expected;
    for (std::uint32_t i = at_begin ? 0 : 5000; i < (at_begin ? 5000U : 10'000U); ++i) expected.push_back(i);
    EXPECT_EQ(left.kept, expected);
    EXPECT_TRUE(left.changed);
  }
}

TEST(ScanDegrader, SameSeedGivesTheSameAndAnotherSeedOrStampSomethingElse) {
  for (const EventKind kind : {EventKind::kThin, EventKind::kSmoke, EventKind::kBag, EventKind::kThinTo}) {
    const Sweep sweep(12.0);
    const DegradedSweep left = degrade(sweep, kind);
    EXPECT_EQ(degrade(sweep, kind).points, left.points);
    EXPECT_NE(degrade(sweep, kind, 0.0, {2, 0.0}).points, left.points);
    Sweep later = sweep;
    later.stamp += Duration{1};
    EXPECT_NE(degrade(later, kind).points, left.points);
  }
}

TEST(ScanDegrader, BlackoutLeavesAnEmptyCloudAndPacketLossNone) {
  const Sweep sweep(12.0);
  const DegradedSweep dark = degrade(sweep, EventKind::kBlackout);
  EXPECT_TRUE(dark.kept.empty() && !dark.lost);
  const DegradedSweep lost = degrade(sweep, EventKind::kPacketLoss);
  EXPECT_TRUE(lost.kept.empty() && lost.lost);
}

TEST(ScanDegrader, LostPacketsAreMillisecondsAsAWhole) {
  const Sweep sweep(12.0);
  const DegradedSweep left = degrade(sweep, EventKind::kPacketLoss, 0.4);
  EXPECT_FALSE(left.lost);
  std::vector<int> by_millisecond(100);
  for (const std::uint32_t i : left.kept) ++by_millisecond[i / 100];
  int whole = 0;
  for (const int count : by_millisecond) {
    EXPECT_TRUE(count == 0 || count == 100);
    whole += count == 100 ? 1 : 0;
  }
  EXPECT_NEAR(whole, 60, 20);  // four deviations of 100 draws
}

TEST(ScanDegrader, ABagReplacesWhatIsFartherAndKeepsWhatIsNearer) {
  Sweep sweep(12.0);
  sweep.points[17] = {0.1F, 0.0F, 0.0F};  // between the sensor and the membrane
  for (const double distance : {0.15, 0.6, 1.5}) {
    const DegradedSweep left = degrade(sweep, EventKind::kBag, distance);
    ASSERT_EQ(left.kept.size(), sweep.points.size());
    EXPECT_EQ(left.points[17], sweep.points[17]);
    double sum = 0.0;
    for (std::size_t i = 0; i < left.points.size(); ++i) {
      if (i == 17) continue;
      EXPECT_LT(left.points[i].norm(), 1.6F);  // the farthest membrane plus nine deviations of noise
      EXPECT_LT(left.points[i].cross(sweep.points[i]).norm(), 1e-4F) << "the direction stays";
      EXPECT_GT(left.points[i].dot(sweep.points[i]), 0.0F);
      sum += left.points[i].norm();
    }
    // Folds go to both sides, by at most half of the distance.
    EXPECT_NEAR(sum / static_cast<double>(left.points.size()), distance, 0.3 * distance);
  }
}

TEST(ScanDegrader, BelowTheMinimumRangeABagReturnsNothing) {
  const Sweep sweep(12.0);
  EXPECT_TRUE(degrade(sweep, EventKind::kBag, 0.2, {1, 0.5}).kept.empty());
  EXPECT_EQ(degrade(sweep, EventKind::kBag, 1.2, {1, 0.5}).kept.size(), sweep.points.size());
}

TEST(ScanDegrader, TheMembraneMovesButSlowly) {
  const Eigen::Vector3d direction(0.6, 0.0, 0.8);
  double largest = 0.0;
  for (double t = 0.0; t < 4.0; t += 0.01) {
    const double step = membrane_range(direction, t + 0.01, 0.6, 3) - membrane_range(direction, t, 0.6, 3);
    largest = std::max(largest, std::abs(step));
  }
  EXPECT_GT(largest, 1e-3);
  // Half of the distance, at the highest rate of 1.5 Hz, for 0.01 s.
  EXPECT_LT(largest, 0.3 * 2.0 * std::numbers::pi * 1.5 * 0.01);
}

TEST(ScanDegrader, ATornBagLeavesSomeDirectionsOpen) {
  // Few waves make one membrane differ from the next, so that many are looked at.
  double open = 0.0;
  constexpr int kMembranes = 60;
  for (int seed = 0; seed < kMembranes; ++seed) {
    const Sweep sweep(12.0, 1000);
    const DegradedSweep left =
        degrade(sweep, EventKind::kTornBag, 0.6, {static_cast<std::uint64_t>(seed), 0.0});
    ASSERT_EQ(left.points.size(), sweep.points.size());
    for (const Eigen::Vector3f& point : left.points) open += point.norm() > 1.6F ? 1e-3 : 0.0;
  }
  EXPECT_NEAR(open / kMembranes, 0.25, 0.08);  // a membrane deviates by about 0.1, 60 of them by 0.02
}

TEST(ScanDegrader, ASectorCoversItsShareOfTheHorizon) {
  const Sweep sweep(12.0);
  expect_share(degrade(sweep, EventKind::kSector, 0.3), sweep, 0.7);
  EXPECT_TRUE(degrade(sweep, EventKind::kSector, 1.0).kept.empty());
  std::set<int> degrees;
  for (const Eigen::Vector3f& p : degrade(sweep, EventKind::kSector, 0.3).points) {
    degrees.insert(static_cast<int>(std::floor(std::atan2(p.y(), p.x()) * 180.0F / 3.14159265F)));
  }
  EXPECT_NEAR(static_cast<int>(degrees.size()), 252, 4) << "one gap without holes, 27 points to a degree";
}

TEST(ScanDegrader, SmokeSwallowsByRangeAndShinesNearby) {
  Sweep sweep(12.0);
  for (Eigen::Vector3f& point : sweep.points) point *= 10.0F / point.norm();
  const DegradedSweep left = degrade(sweep, EventKind::kSmoke, 0.05);
  std::size_t through = 0;
  for (std::size_t i = 0; i < left.points.size(); ++i) {
    const float range = left.points[i].norm();
    if (left.points[i] == sweep.points[left.kept[i]]) {
      ++through;
    } else {
      EXPECT_GE(range, 0.999F);
      EXPECT_LE(range, 8.001F);
    }
  }
  const double expected = std::exp(-1.0);  // 2 * 0.05 / m * 10 m
  EXPECT_NEAR(static_cast<double>(through) / 1e4, expected, 4.0 * std::sqrt(expected * (1 - expected) / 1e4));
  expect_share(left, sweep, expected + 0.5 * (1.0 - expected));
}

TEST(ScanDegrader, ThinningKeepsTheShareOrTheNumber) {
  const Sweep sweep(12.0);
  expect_share(degrade(sweep, EventKind::kThin, 0.05), sweep, 0.05);
  EXPECT_EQ(degrade(sweep, EventKind::kThinTo, 137.0).kept.size(), 137U);
  EXPECT_EQ(degrade(sweep, EventKind::kThinTo, 1e6).kept.size(), sweep.points.size());
  const Sweep half(9.95);
  EXPECT_EQ(degrade(half, EventKind::kThinTo, 100.0).kept.size(), 5000U + 50U);
}

TEST(ScanDegrader, VoxelsKeepOnePointEach) {
  const Sweep sweep(12.0);
  const DegradedSweep left = degrade(sweep, EventKind::kVoxel, 4.0);
  std::set<std::array<int, 3>> before;
  std::set<std::array<int, 3>> after;
  const auto cell = [](const Eigen::Vector3f& p) {
    return std::array<int, 3>{static_cast<int>(std::floor(p.x() / 4)),
                              static_cast<int>(std::floor(p.y() / 4)),
                              static_cast<int>(std::floor(p.z() / 4))};
  };
  for (const Eigen::Vector3f& point : sweep.points) before.insert(cell(point));
  for (const Eigen::Vector3f& point : left.points) after.insert(cell(point));
  EXPECT_EQ(before, after);
  EXPECT_EQ(left.points.size(), after.size());
}

TEST(ScanDegrader, ARangeCapRemovesWhatIsFarther) {
  const Sweep sweep(12.0);
  const DegradedSweep left = degrade(sweep, EventKind::kRangeCap, 5.0);
  for (const Eigen::Vector3f& point : left.points) EXPECT_LE(point.norm(), 5.0001F);
  expect_share(left, sweep, 0.3);  // ranges are spread evenly over 2 to 12 m
}

TEST(ScanDegrader, BeamsWithoutAnEchoStayUnlessAllIsLost) {
  Sweep sweep(12.0, 100);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t i = 0; i < 100; i += 2)
    sweep.points[i] = Eigen::Vector3f::Constant(i % 4 == 0 ? nan : 0.0F);
  EXPECT_GE(degrade(sweep, EventKind::kThin, 1e-5).kept.size(), 50U);
  EXPECT_EQ(degrade(sweep, EventKind::kBag).kept.size(), 100U);
  EXPECT_FALSE(degrade(sweep, EventKind::kRangeCap, 100.0).changed);
  EXPECT_TRUE(degrade(sweep, EventKind::kBlackout).kept.empty());
}

TEST(ScanDegrader, EventsThatOverlapActOneAfterTheOther) {
  const Sweep sweep(12.0);
  const ScanDegrader both({{EventKind::kBag, 10.0, 5.0, 1.0}, {EventKind::kRangeCap, 11.0, 5.0, 2.0}}, kStart,
                          {});
  EXPECT_EQ(both.apply(sweep.view()).kept.size(), sweep.points.size());
  const ScanDegrader other({{EventKind::kRangeCap, 11.0, 5.0, 1.9}, {EventKind::kBag, 10.0, 5.0, 1.0}},
                           kStart, {});
  EXPECT_TRUE(other.apply(sweep.view()).kept.empty());
}

TEST(ScanDegrader, AScanKeepsTheTimesAndColumnsOfItsPoints) {
  sensor::LidarScan scan;
  scan.start_time = kStart + from_seconds(9.95);
  scan.end_time = scan.start_time + from_seconds(0.099);
  for (int i = 0; i < 100; ++i) {
    scan.points.emplace_back(static_cast<float>(3 + i), 1.0F, 0.0F);
    scan.offsets.push_back(0.001F * static_cast<float>(i));
    scan.intensities.push_back(static_cast<float>(i));
    scan.rings.push_back(static_cast<std::uint16_t>(i));
  }
  const std::vector<Time> times = point_times(scan);
  const ScanDegrader degrader({{EventKind::kBlackout, 9.0, 0.97, 0.0}}, kStart, {});
  const sensor::LidarScan left = degraded(scan, degrader.apply({scan.start_time, &scan.points, &times}));
  ASSERT_EQ(left.size(), 80U);  // from 9.97 s on
  EXPECT_EQ(left.rings.front(), 20);
  EXPECT_EQ(left.intensities.back(), 99.0F);
  const std::vector<Time> left_times = point_times(left);
  for (std::size_t i = 0; i < left.size(); ++i) {
    // Times are kept as float seconds within a scan: 0.1 s to 7 ns.
    EXPECT_NEAR(to_seconds(left_times[i] - times[i + 20]), 0.0, 2e-8);
  }
  EXPECT_NEAR(to_seconds(left.end_time - scan.end_time), 0.0, 2e-8);
}

}  // namespace
}  // namespace mmlins::degrade

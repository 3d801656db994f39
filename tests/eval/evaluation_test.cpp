// SPDX-License-Identifier: MIT
// Estimates whose errors are known in closed form.
#include "mmlins/eval/evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace mmlins::eval {
namespace {

using math::SE3;
using math::Trajectory;
using math::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kRounding = 1e-9;  // sums of a few thousand terms of up to 1e3

Time at(double seconds) { return time_from_ns(1700000000000000000) + from_seconds(seconds); }

/// A drive of constant speed along a circle that also climbs and rolls; `period` [s], `duration` [s].
Trajectory make_drive(double duration, double period, double speed = 5.0) {
  Trajectory drive;
  for (int i = 0; i * period <= duration + 1e-9; ++i) {
    const double t = i * period;
    const double yaw = speed * t / 20.0;
    const SE3 pose{math::so3_exp({0.0, 0.0, yaw}) * math::so3_exp({0.1 * std::sin(t), 0.0, 0.0}),
                   {20.0 * std::cos(yaw), 20.0 * std::sin(yaw), std::sin(0.3 * t)}};
    drive.push_back({at(t), pose});
  }
  return drive;
}

Trajectory transformed(const SE3& T, Trajectory trajectory) {
  for (auto& stamped : trajectory) stamped.pose = T * stamped.pose;
  return trajectory;
}

Evaluation evaluated(const Trajectory& truth, const Trajectory& estimate, Alignment alignment) {
  const Result<Evaluation> evaluation = evaluate(truth, estimate, alignment);
  EXPECT_TRUE(evaluation.ok()) << (evaluation.ok() ? "" : evaluation.error().message);
  return evaluation.ok() ? *evaluation : Evaluation{};
}

TEST(Evaluation, StatisticsMatchHandCalculation) {
  const Statistics s = statistics_of({4.0, 1.0, 3.0, 2.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.5);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.max, 4.0);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(7.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(1.25));
  EXPECT_DOUBLE_EQ(statistics_of({5.0, 9.0, 1.0}).median, 5.0);
  EXPECT_EQ(statistics_of({}).count, 0);
}

TEST(Evaluation, TheTruthItselfHasNoError) {
  const Trajectory truth = make_drive(60.0, 0.1);
  for (const Alignment alignment : {Alignment::kSe3, Alignment::kYaw, Alignment::kNone}) {
    const Evaluation e = evaluated(truth, truth, alignment);
    EXPECT_LT(e.absolute.translation.max, kRounding);
    EXPECT_LT(e.absolute.rotation.max, 1e-5);  // the angle of a rotation next to identity: root of rounding
    EXPECT_LT(e.per_second->translation.max, kRounding);
    EXPECT_LT(e.per_100m->translation.max, kRounding);
    EXPECT_LT(e.end_to_end.translation, kRounding);
    EXPECT_DOUBLE_EQ(e.coverage.share, 1.0);
    EXPECT_EQ(e.num_matched, 601);
  }
}

TEST(Evaluation, AnotherFrameIsNoErrorAfterAlignment) {
  const Trajectory truth = make_drive(60.0, 0.1);
  const SE3 T{math::so3_exp({0.3, -1.2, 2.5}), {100.0, -50.0, 7.0}};
  const Evaluation e = evaluated(truth, transformed(T, truth), Alignment::kSe3);
  EXPECT_LT(e.absolute.translation.max, kRounding);
  EXPECT_TRUE((e.T_truth_estimate * T).R.isIdentity(1e-10));
}

TEST(Evaluation, AlignmentOfHeadingRemovesHeadingButNotTilt) {
  const Trajectory truth = make_drive(60.0, 0.1);
  const SE3 heading{math::so3_exp({0.0, 0.0, -2.0}), {3.0, 4.0, 5.0}};
  EXPECT_LT(evaluated(truth, transformed(heading, truth), Alignment::kYaw).absolute.translation.max,
            kRounding);
  const SE3 tilt{math::so3_exp({2.0 * kDegree, 0.0, 0.0}), Vector3d::Zero()};
  const Evaluation e = evaluated(truth, transformed(tilt, truth), Alignment::kYaw);
  EXPECT_NEAR(e.absolute.rotation.median, 2.0, 0.05);  // the heading found is a little off
  EXPECT_GT(e.absolute.translation.rmse, 0.3);         // 20 m * 2 deg / sqrt(2) = 0.49 m
}

TEST(Evaluation, WithoutAlignmentAnOffsetIsTheError) {
  const Trajectory truth = make_drive(60.0, 0.1);
  const Evaluation e =
      evaluated(truth, transformed({math::Matrix3d::Identity(), {3.0, 4.0, 0.0}}, truth), Alignment::kNone);
  EXPECT_NEAR(e.absolute.translation.mean, 5.0, kRounding);
  EXPECT_NEAR(e.absolute.translation.std, 0.0, 1e-6);  // root of rounding
  EXPECT_LT(e.end_to_end.translation, kRounding);
}

TEST(Evaluation, TheTruthIsInterpolatedAtTheEstimatesStamps) {
  // On a straight line with constant speed interpolation is exact.
  Trajectory truth;
  for (int i = 0; i <= 100; ++i)
    truth.push_back({at(0.1 * i), {math::so3_exp({0, 0, 0.01 * i}), {0.5 * i, 0, 0}}});
  Trajectory estimate;
  for (int i = 0; i < 70; ++i) {
    const double steps = 1.3 * i + 0.7;
    estimate.push_back({at(0.1 * steps), {math::so3_exp({0, 0, 0.01 * steps}), {0.5 * steps, 0, 0}}});
  }
  const Evaluation e = evaluated(truth, estimate, Alignment::kNone);
  EXPECT_LT(e.absolute.translation.max, 1e-7);  // stamps are whole nanoseconds, 5 m/s
  EXPECT_EQ(e.num_matched, 70);
}

TEST(Evaluation, ScaleErrorShowsAsPercentPer100Metres) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i <= 500; ++i) {
    truth.push_back({at(0.1 * i), {math::Matrix3d::Identity(), {1.0 * i, 0.0, 0.0}}});
    estimate.push_back({at(0.1 * i), {math::Matrix3d::Identity(), {1.02 * i, 0.0, 0.0}}});
  }
  const Evaluation e = evaluated(truth, estimate, Alignment::kNone);
  ASSERT_TRUE(e.per_100m.has_value());
  EXPECT_EQ(e.per_100m->translation.count, 401);
  EXPECT_NEAR(e.per_100m->translation.rmse, 2.0, kRounding);
  EXPECT_NEAR(e.per_second->translation.mean, 0.2, kRounding);  // 10 m/s, 2 %
  EXPECT_NEAR(e.end_to_end.translation, 10.0, kRounding);
}

TEST(Evaluation, HeadingDriftShowsPerSecondAndPer100Metres) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i <= 500; ++i) {
    truth.push_back({at(0.1 * i), {math::Matrix3d::Identity(), {1.0 * i, 0.0, 0.0}}});
    estimate.push_back({at(0.1 * i), {math::so3_exp({0.0, 0.0, 0.01 * kDegree * i}), {1.0 * i, 0.0, 0.0}}});
  }
  const Evaluation e = evaluated(truth, estimate, Alignment::kNone);
  EXPECT_NEAR(e.per_second->rotation.median, 0.1, kRounding);
  EXPECT_NEAR(e.per_100m->rotation.median, 1.0, kRounding);
  EXPECT_NEAR(e.end_to_end.rotation_deg, 5.0, kRounding);
  EXPECT_NEAR(e.absolute.rotation.max, 5.0, kRounding);
}

TEST(Evaluation, AShortPathHasNoFigurePer100Metres) {
  const Evaluation e = evaluated(make_drive(10.0, 0.1), make_drive(10.0, 0.1), Alignment::kSe3);
  EXPECT_FALSE(e.per_100m.has_value());
  EXPECT_TRUE(e.per_second.has_value());
}

TEST(Evaluation, CoverageCountsMissingEndsAndGaps) {
  const Trajectory truth = make_drive(100.0, 0.1);
  Trajectory estimate;
  for (const auto& stamped : truth) {
    const double t = to_seconds(stamped.time - truth.front().time);
    if (t > 4.95 && t < 90.05 && !(t > 40.05 && t < 49.95)) estimate.push_back(stamped);
  }
  const Evaluation e = evaluated(truth, estimate, Alignment::kSe3);
  EXPECT_NEAR(e.coverage.share, 0.75, kRounding);  // 5 to 40 and 50 to 90 of 100 s
  EXPECT_NEAR(e.coverage.longest_gap, 10.0, kRounding);
  EXPECT_NEAR(e.coverage.late_start, 5.0, kRounding);
  EXPECT_NEAR(e.coverage.early_end, 10.0, kRounding);
}

TEST(Evaluation, HolesOfTheTruthAreNotInterpolated) {
  Trajectory truth = make_drive(60.0, 0.1);
  truth.erase(truth.begin() + 200, truth.begin() + 400);
  const Trajectory estimate = make_drive(60.0, 0.1);
  EXPECT_EQ(evaluated(truth, estimate, Alignment::kSe3).num_matched, 401);
}

TEST(Evaluation, TrajectoriesWithoutCommonTimeAreRefusedWithBothRanges) {
  Trajectory late = make_drive(10.0, 0.1);
  for (auto& stamped : late) stamped.time += std::chrono::seconds(100);
  const auto evaluation = evaluate(make_drive(10.0, 0.1), late, Alignment::kSe3);
  ASSERT_FALSE(evaluation.ok());
  EXPECT_EQ(evaluation.error().message,
            "no common time: the truth covers 1700000000.000000000 to 1700000010.000000000 s, the estimate "
            "1700000100.000000000 to 1700000110.000000000 s; are both of one run?");
}

TEST(Evaluation, FewerThanThreeCommonPosesAreRefused) {
  Trajectory few = make_drive(10.0, 0.1);
  few.resize(2);
  const auto evaluation = evaluate(make_drive(10.0, 0.1), few, Alignment::kSe3);
  ASSERT_FALSE(evaluation.ok());
  EXPECT_EQ(evaluation.error().message.find("only 2 common poses, at least 3 are needed"), 0U);
}

TEST(Evaluation, APathThatDoesNotDetermineTheAlignmentIsRefused) {
  Trajectory line;
  Trajectory place;
  for (int i = 0; i < 50; ++i) {
    line.push_back({at(0.1 * i), {math::Matrix3d::Identity(), {1.0 * i, 0.0, 0.0}}});
    place.push_back({at(0.1 * i), SE3{}});
  }
  EXPECT_FALSE(evaluate(line, line, Alignment::kSe3).ok());
  EXPECT_TRUE(evaluate(line, line, Alignment::kYaw).ok());
  EXPECT_FALSE(evaluate(place, place, Alignment::kYaw).ok());
  EXPECT_TRUE(evaluate(place, place, Alignment::kNone).ok());
}

TEST(Evaluation, AlignmentIsARotationAlsoWhereAMirrorImageWouldFitBetter) {
  std::vector<Vector3d> points;
  std::vector<Vector3d> mirrored;
  for (int i = 0; i < 20; ++i) {
    points.emplace_back(std::cos(i), std::sin(2.0 * i), std::cos(3.0 * i));
    mirrored.push_back(-points.back());
  }
  const auto T = align_positions(points, mirrored, Alignment::kSe3);
  ASSERT_TRUE(T.has_value());
  EXPECT_NEAR(T->R.determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace mmlins::eval

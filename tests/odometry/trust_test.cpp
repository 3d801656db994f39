// SPDX-License-Identifier: MIT
#include "mmlins/odometry/trust.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mmlins::odometry {
namespace {

const Time kStart = time_from_ns(1700000000000000000);
constexpr double kPeriod = 0.1;  // of the scans [s]

Time at(double seconds) { return kStart + from_seconds(seconds); }

/// A scan of a sensor that usually sees 10000 points, half of them within 8 m, of which the map explains 0.6.
Evidence usual_scan(double seconds) {
  Evidence evidence;
  evidence.time = at(seconds);
  evidence.num_points = 10000;
  evidence.median_range = 8.0;
  evidence.matched = true;
  evidence.explained = 0.6;
  evidence.residual_rms = 0.015;
  evidence.return_chi2 = 6.0;
  return evidence;
}

/// A judge who has believed scans up to `seconds`, and knows what is usual.
TrustJudge experienced(double seconds = 3.0, const TrustConfig& config = {}) {
  TrustJudge judge(config);
  for (int i = 0; i * kPeriod < seconds + 0.5 * kPeriod; ++i)
    EXPECT_TRUE(judge.judge(usual_scan(i * kPeriod)).trusted);
  EXPECT_TRUE(judge.knows_the_usual());
  return judge;
}

Evidence explained_by(double share, double seconds) {
  Evidence evidence = usual_scan(seconds);
  evidence.explained = share;
  return evidence;
}

void expect_refused(TrustJudge judge, const Evidence& evidence, Cause cause) {
  const Verdict verdict = judge.judge(evidence);
  EXPECT_FALSE(verdict.trusted);
  EXPECT_EQ(verdict.cause, cause) << to_string(verdict.cause);
}

void expect_believed(TrustJudge judge, const Evidence& evidence) {
  const Verdict verdict = judge.judge(evidence);
  EXPECT_TRUE(verdict.trusted) << to_string(verdict.cause);
  EXPECT_EQ(verdict.cause, Cause::kNone);
}

TEST(TrustJudge, RefusesAReturnThatFitsAtSeveralPlaces) {
  Evidence evidence = usual_scan(10.0);
  evidence.drift = 1.0;
  expect_believed(experienced(), evidence);
  evidence.ambiguous = true;
  expect_refused(experienced(), evidence, Cause::kAmbiguous);
}

TEST(TrustJudge, AProvisionalBeliefEndsNoAbsenceAndIsNoMeasureOfWhatIsUsual) {
  const TrustConfig config;
  TrustJudge judge = experienced();
  for (int i = 1; i <= 100; ++i) {
    Evidence half = explained_by(0.3, 10.0 + 0.1 * i);
    half.drift = 1.0;
    half.provisional = true;
    EXPECT_TRUE(judge.judge(half).trusted);
  }
  // The usual is 0.6 still, and who has been absent is asked where the IMU can have gone.
  expect_refused(judge, explained_by(0.9 * config.min_explained * 0.6, 20.1), Cause::kTooFewMatches);
  Evidence far = usual_scan(20.1);
  far.return_chi2 = 2.0 * config.max_return_chi2;
  expect_refused(judge, far, Cause::kImuDisagrees);
}

TEST(RunningMedian, SaysNothingBeforeTenValuesAndThenTheMiddleOne) {
  RunningMedian median;
  for (int i = 0; i < 9; ++i) {
    median.push(at(i), (i * 7) % 11, from_seconds(100.0));
    EXPECT_FALSE(median.median());
  }
  median.push(at(9.0), (9 * 7) % 11, from_seconds(100.0));
  ASSERT_TRUE(median.median());
  median.push(at(10.0), (10 * 7) % 11, from_seconds(100.0));
  EXPECT_EQ(*median.median(), 5.0);  // multiples of 7 modulo 11 are 0 to 10 in some order
}

TEST(RunningMedian, ForgetsWhatIsOlderThanTheWindow) {
  RunningMedian median;
  for (int i = 0; i < 40; ++i) median.push(at(i), i, from_seconds(20.0));
  // Seconds 19 to 39 are left.
  EXPECT_EQ(*median.median(), 29.0);
}

TEST(TrustJudge, BelievesAnyMatchBeforeItKnowsWhatIsUsual) {
  TrustJudge judge({});
  EXPECT_FALSE(judge.knows_the_usual());
  for (int i = 0; i < 9; ++i)
    EXPECT_TRUE(judge.judge(explained_by(i % 2 == 0 ? 0.9 : 0.02, i * kPeriod)).trusted);
  EXPECT_FALSE(judge.knows_the_usual());
}

TEST(TrustJudge, TellsEmptyScansFromScansThatTheMapDoesNotExplain) {
  Evidence evidence = usual_scan(3.1);
  evidence.matched = false;
  expect_refused(experienced(), evidence, Cause::kTooFewMatches);
  evidence.num_points = 0;
  expect_refused(experienced(), evidence, Cause::kNoPoints);
}

TEST(TrustJudge, RefusesWhatIsExplainedByFarLessThanUsual) {
  const TrustConfig config;
  const double limit = 0.6 * config.min_explained;
  expect_refused(experienced(), explained_by(0.99 * limit, 3.1), Cause::kTooFewMatches);
  expect_believed(experienced(), explained_by(1.01 * limit, 3.1));
}

TEST(TrustJudge, MeasuresByWhatIsUsualHereAndNotByANumber) {
  // In a wood the map never explains more than a tenth.
  TrustJudge judge({});
  for (int i = 0; i < 30; ++i) EXPECT_TRUE(judge.judge(explained_by(0.1, i * kPeriod)).trusted);
  expect_believed(judge, explained_by(0.05, 3.0));
  expect_refused(judge, explained_by(0.02, 3.0), Cause::kTooFewMatches);
}

TEST(TrustJudge, CallsAnUnexplainedScanBlockedIfItHasShrunk) {
  const TrustConfig config;
  Evidence near = explained_by(0.0, 3.1);
  near.median_range = 0.99 * config.collapsed_range * 8.0;
  expect_refused(experienced(), near, Cause::kBlocked);
  near.median_range = 1.01 * config.collapsed_range * 8.0;
  expect_refused(experienced(), near, Cause::kTooFewMatches);
  Evidence few = explained_by(0.0, 3.1);
  few.num_points = static_cast<int>(0.99 * config.collapsed_count * 10000);
  expect_refused(experienced(), few, Cause::kBlocked);
  few.matched = false;
  expect_refused(experienced(), few, Cause::kBlocked);
  few.num_points = static_cast<int>(1.01 * config.collapsed_count * 10000);
  expect_refused(experienced(), few, Cause::kTooFewMatches);
}

TEST(TrustJudge, BelievesAShrunkenScanThatTheMapExplains) {
  // Into a narrow corridor, or a sensor thinned to a twentieth.
  Evidence evidence = usual_scan(3.1);
  evidence.median_range = 1.0;
  evidence.num_points = 500;
  expect_believed(experienced(), evidence);
}

TEST(TrustJudge, RefusesAReturnWhoseResidualsAreFarLargerThanUsual) {
  const TrustConfig config;
  Evidence rough = usual_scan(10.0);
  rough.residual_rms = 0.015 * 0.9 * config.max_return_residual;
  expect_believed(experienced(), rough);
  rough.residual_rms = 0.015 * 1.1 * config.max_return_residual;
  expect_refused(experienced(), rough, Cause::kTooFewMatches);
  // Who drives from a hall into a wood is not absent.
  rough.time = at(3.1);
  expect_believed(experienced(), rough);
}

TEST(TrustJudge, AsksForMoreAfterAContradictionByTheImu) {
  const TrustConfig config;
  const Evidence between = explained_by(0.6 * 0.5 * (config.min_explained + config.min_explained_again), 3.2);
  expect_believed(experienced(3.0), between);
  TrustJudge contradicted = experienced(3.0);
  Evidence disagreeing = usual_scan(3.1);
  disagreeing.imu_disagrees = true;
  EXPECT_FALSE(contradicted.judge(disagreeing).trusted);
  expect_refused(contradicted, between, Cause::kTooFewMatches);
  expect_believed(contradicted, explained_by(1.01 * 0.6 * config.min_explained_again, 3.2));
}

TEST(TrustJudge, DoesNotReturnOnAScanThatHasShrunkWhileThePoseIsInDoubt) {
  // Under a cover a few planes fit the map by chance; before the pose is in doubt they may be believed.
  Evidence shrunken = usual_scan(9.0);
  shrunken.num_points = 400;
  shrunken.drift = 0.1;
  expect_believed(experienced(), shrunken);
  shrunken.drift = 0.5;
  expect_refused(experienced(), shrunken, Cause::kBlocked);
}

TEST(TrustJudge, RefusesAReturnToWhereTheImuCannotHaveGone) {
  const TrustConfig config;
  Evidence evidence = usual_scan(3.0 + 1.1 * config.short_absence);
  evidence.return_chi2 = 1.01 * config.max_return_chi2;
  expect_refused(experienced(3.0), evidence, Cause::kImuDisagrees);
  evidence.return_chi2 = 0.99 * config.max_return_chi2;
  expect_believed(experienced(3.0), evidence);
  // Without an absence the filter has settled that: its own model of the IMU is not perfect.
  evidence = usual_scan(3.1);
  evidence.return_chi2 = 100.0 * config.max_return_chi2;
  expect_believed(experienced(3.0), evidence);
}

TEST(TrustJudge, OneScanBelievedEndsTheAbsence) {
  const TrustConfig config;
  TrustJudge judge = experienced(3.0);
  EXPECT_TRUE(judge.judge(usual_scan(5.0)).trusted);
  expect_believed(judge, explained_by(1.01 * 0.6 * config.min_explained, 5.1));
}

TEST(TrustJudge, RefusesAPerfectMatchThatTheImuContradicts) {
  Evidence evidence = explained_by(1.0, 3.1);
  evidence.imu_disagrees = true;
  expect_refused(experienced(), evidence, Cause::kImuDisagrees);
}

// A lift: the doors are still shut, and its walls match as well as ever.
TEST(TrustJudge, AsksWhoWasContradictedForAReturnToWhereTheImuIs) {
  const TrustConfig config;
  TrustJudge judge = experienced(3.0);
  Evidence evidence = usual_scan(3.1);
  evidence.imu_disagrees = true;
  EXPECT_FALSE(judge.judge(evidence).trusted);
  evidence = usual_scan(3.2);
  evidence.return_chi2 = 1.01 * config.max_return_chi2;
  expect_refused(judge, evidence, Cause::kImuDisagrees);
  EXPECT_FALSE(judge.judge(evidence).trusted);
  evidence = usual_scan(3.3);
  evidence.return_chi2 = 1.01 * config.max_return_chi2;
  expect_refused(judge, evidence, Cause::kImuDisagrees);
  evidence.return_chi2 = 0.99 * config.max_return_chi2;
  EXPECT_TRUE(judge.judge(evidence).trusted);
  evidence = usual_scan(3.4);
  evidence.return_chi2 = 1.01 * config.max_return_chi2;
  expect_believed(judge, evidence);
}

// Longer away than what is usual is remembered: better an old yardstick than none.
TEST(TrustJudge, KnowsWhatWasUsualAfterALongAbsence) {
  TrustConfig config;
  config.usual_window = 5.0;
  TrustJudge judge = experienced(3.0, config);
  EXPECT_TRUE(judge.judge(usual_scan(60.0)).trusted);
  expect_refused(judge, explained_by(0.01, 60.1), Cause::kTooFewMatches);
}

TEST(TrustJudge, DoesNotGetUsedToWhatItRefuses) {
  TrustJudge judge = experienced(3.0);
  Evidence covered = explained_by(0.01, 0.0);
  covered.median_range = 0.6;
  for (int i = 31; i < 1000; ++i) {
    covered.time = at(i * kPeriod);
    const Verdict verdict = judge.judge(covered);
    ASSERT_FALSE(verdict.trusted) << i;
    ASSERT_EQ(verdict.cause, Cause::kBlocked) << i;
  }
  EXPECT_TRUE(judge.has_collapsed(covered));
  EXPECT_FALSE(judge.has_collapsed(usual_scan(100.0)));
  expect_believed(judge, usual_scan(100.0));
}

TEST(TrustJudge, GetsUsedToWhatItBelieves) {
  TrustConfig config;
  config.usual_window = 5.0;
  TrustJudge judge = experienced(3.0, config);
  expect_refused(judge, explained_by(0.1, 3.1), Cause::kTooFewMatches);
  // Out of the hall into a wood, by and by.
  for (int i = 31; i < 300; ++i) {
    ASSERT_TRUE(judge.judge(explained_by(0.1 + 0.5 * std::exp(-0.02 * (i - 31)), i * kPeriod)).trusted) << i;
  }
  expect_believed(judge, explained_by(0.1, 30.0));
}

}  // namespace
}  // namespace mmlins::odometry

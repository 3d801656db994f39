// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/reference_detectors.hpp"

#include <gtest/gtest.h>

namespace mmlins::degeneracy {
namespace {

math::Matrix6d covariance(double rotation, double translation) {
  math::Vector6d diagonal;
  diagonal << rotation, rotation, rotation, translation, translation, translation;
  return diagonal.asDiagonal();
}

TEST(PaperDetector, NeedsBothBlocksAboveTheMajorThreshold) {
  EXPECT_TRUE(paper_detector(covariance(0.0007, 0.006), 0, {}).over_degenerate);
  EXPECT_FALSE(paper_detector(covariance(0.0007, 0.001), 0, {}).over_degenerate);
  EXPECT_FALSE(paper_detector(covariance(0.0001, 0.006), 0, {}).over_degenerate);
}

TEST(PaperDetector, CountsConsecutiveScansBetweenTheThresholds) {
  int count = 0;
  for (int scan = 1; scan <= 10; ++scan) {
    const auto step = paper_detector(covariance(0.0001, 0.003), count, {});
    EXPECT_FALSE(step.over_degenerate) << "scan " << scan;
    count = step.num_minor_scans;
  }
  EXPECT_TRUE(paper_detector(covariance(0.0001, 0.003), count, {}).over_degenerate);
  EXPECT_EQ(paper_detector(covariance(0.0001, 0.001), count, {}).num_minor_scans, 0);
}

TEST(PaperDetector, SeesADirectionBetweenTheAxes) {
  math::Matrix6d P = covariance(0.0007, 0.0);
  const math::Vector3d oblique = math::Vector3d(1, 1, 1).normalized();
  P.bottomRightCorner<3, 3>() = 0.006 * oblique * oblique.transpose();
  EXPECT_NEAR(paper_detector(P, 0, {}).largest_translation, 0.006, 1e-12);
  EXPECT_TRUE(paper_detector(P, 0, {}).over_degenerate);
}

TEST(PublishedRule, SplitsAtTheSecondDegradedScanHoweverFarApart) {
  auto step = published_rule(covariance(0.0, 0.001), 0);
  EXPECT_FALSE(step.over_degenerate);
  for (int scan = 0; scan < 1000; ++scan) step = published_rule(covariance(0.0, 1e-5), step.num_degraded_scans);
  EXPECT_FALSE(step.over_degenerate);
  EXPECT_TRUE(published_rule(covariance(0.0, 0.001), step.num_degraded_scans).over_degenerate);
}

TEST(DegeneracyFactor, IsTheSmallestEigenvalue) {
  EXPECT_NEAR(degeneracy_factor(covariance(300.0, 40.0)), 40.0, 1e-9);
}

}  // namespace
}  // namespace mmlins::degeneracy

// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/reference_detectors.hpp"

#include <Eigen/Eigenvalues>

namespace mmlins::degeneracy {
namespace {

double largest_eigenvalue(const math::Matrix3d& M) {
  return Eigen::SelfAdjointEigenSolver<math::Matrix3d>(M, Eigen::EigenvaluesOnly).eigenvalues()(2);
}

bool between(double value, double low, double high) { return low < value && value < high; }

}  // namespace

PaperDetectorStep paper_detector(const math::Matrix6d& P, int num_minor_scans, const PaperDetectorConfig& config) {
  PaperDetectorStep step;
  // Eq. (1) and the decomposition after it: the blocks are judged apart.
  step.largest_rotation = largest_eigenvalue(P.topLeftCorner<3, 3>());
  step.largest_translation = largest_eigenvalue(P.bottomRightCorner<3, 3>());
  const bool minor =
      between(step.largest_rotation, config.minor_share * config.major_rotation, config.major_rotation) ||
      between(step.largest_translation, config.minor_share * config.major_translation, config.major_translation);
  step.num_minor_scans = minor ? num_minor_scans + 1 : 0;
  // Eq. (2): both blocks above the major threshold, or too long between the thresholds.
  const bool major =
      step.largest_rotation > config.major_rotation && step.largest_translation > config.major_translation;
  step.over_degenerate = major || step.num_minor_scans > config.max_minor_scans;
  return step;
}

PublishedRuleStep published_rule(const math::Matrix6d& P, int num_degraded_scans) {
  const bool degraded = P(3, 3) > 6e-4 || P(4, 4) > 6e-4 || P(5, 5) > 5e-4;
  PublishedRuleStep step;
  step.num_degraded_scans = num_degraded_scans + (degraded ? 1 : 0);
  step.over_degenerate = step.num_degraded_scans > 1;
  return step;
}

double degeneracy_factor(const math::Matrix6d& unweighted_information) {
  return Eigen::SelfAdjointEigenSolver<math::Matrix6d>(unweighted_information, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

}  // namespace mmlins::degeneracy

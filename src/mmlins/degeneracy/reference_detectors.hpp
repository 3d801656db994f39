// SPDX-License-Identifier: MIT
#pragma once
// The detectors of over-degeneracy that ours is compared with: the paper's (Eqs. (1) and (2) of MM-LINS), the
// rule of its published code, and the degeneracy factor that the paper takes as its own baseline.
// Each is a pure step from one scan to the next.

#include "mmlins/math/se3.hpp"

namespace mmlins::degeneracy {

/// The thresholds of the paper; they belong to the filter it was tuned on and depend on the sensor.
struct PaperDetectorConfig {
  double major_rotation = 0.0006;    ///< [rad^2]
  double major_translation = 0.005;  ///< [m^2]
  double minor_share = 0.5;          ///< minor threshold as a share of the major one; the paper does not state it
  int max_minor_scans = 10;          ///< N_kappa; not stated either
};

struct PaperDetectorStep {
  bool over_degenerate = false;      ///< I of Eq. (2)
  double largest_rotation = 0.0;     ///< largest eigenvalue of P_rr [rad^2]
  double largest_translation = 0.0;  ///< largest eigenvalue of P_tt [m^2]
  int num_minor_scans = 0;           ///< Gamma: consecutive scans between the thresholds, for the next step
};

/// @param P                 pose covariance after the update, [rotation; translation]
/// @param num_minor_scans   of the step before; 0 at the start of a map
[[nodiscard]] PaperDetectorStep paper_detector(const math::Matrix6d& P, int num_minor_scans,
                                               const PaperDetectorConfig& config);

struct PublishedRuleStep {
  bool over_degenerate = false;
  int num_degraded_scans = 0;  ///< never goes down within a map: that is the rule
};

/// The published code: a variance of position above 6e-4, 6e-4 or 5e-4 m^2 along the axes, twice in a map.
[[nodiscard]] PublishedRuleStep published_rule(const math::Matrix6d& P, int num_degraded_scans);

/// Degeneracy factor (Zhang, Kaess, Singh 2016): smallest eigenvalue of J^T J, all residuals of weight one.
[[nodiscard]] double degeneracy_factor(const math::Matrix6d& unweighted_information);

}  // namespace mmlins::degeneracy

// SPDX-License-Identifier: MIT
#pragma once
// Is this really the same place? A closure is believed only if everything speaks for it, and the answer says
// in one line what it was. docs/math/registration.md.

#include <optional>
#include <span>
#include <string>

#include "mmlins/registration/register_submaps.hpp"

namespace mmlins::registration {

struct VerificationConfig {
  RegistrationConfig registration;
  double min_overlap = 0.4;
  double min_standing_overlap = 0.5;
  double max_residual = 0.12;
  double max_tilt_deg = 2.0;
  double max_crossing_share = 0.03;
  double perturbation = 1.5;
  double perturbation_deg = 7.0;
  double agree_within = 0.1;
  double agree_within_deg = 0.5;
  double rival_overlap = 0.9;
  double max_prior_chi2 = 22.5;

  [[nodiscard]] Fields fields();
};

/// What is known about the pose without looking: odometry between two submaps of one map, or the gap between
/// two maps.
struct PosePrior {
  math::SE3 T_target_source;
  math::Matrix6d covariance = math::Matrix6d::Identity();  ///< of T [+] xi, [rotation; translation]
};

struct Verification {
  bool accepted = false;
  std::string reason;  ///< one line with the figures
  /// The edge: T_target_source and its information, which is next to nothing along what is undetermined.
  Registration registration;
  bool refused_by_prior = false;  ///< it fits, but not where it should be; nothing else was examined then
  double crossing_share = 0.0;  ///< of rays through surfaces of the other
};

/// Tries to register from each of the starts and examines the best result.
///
/// Where the surroundings leave a direction open (a corridor), the result is accepted only with a prior, as
/// an edge that says nothing about that direction: without one, any two corridors would fit. Two places that
/// are the same in everything that both submaps show cannot be told apart by looking; the prior must do
/// it.
///
/// @param starts  guesses of T_target_source, from recognition or search_around()
[[nodiscard]] Verification verify(const PreparedSubmap& source, const PreparedSubmap& target,
                                  std::span<const math::SE3> starts, const std::optional<PosePrior>& prior,
                                  const VerificationConfig& config);

}  // namespace mmlins::registration

// SPDX-License-Identifier: MIT
#include "mmlins/registration/verify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/registration/edge_information.hpp"
#include "mmlins/registration/free_space.hpp"

namespace mmlins::registration {

namespace {

using math::SE3;
using math::Vector3d;
using math::Vector6d;

constexpr double kDeg = 180.0 / std::numbers::pi;
constexpr double kRivalDistance = 0.5;  // from the best result, beyond which another one is a rival [m]

Vector6d difference(const SE3& T_a, const SE3& T_b) { return math::se3_log(T_a.inverse() * T_b); }

double tilt_deg(const SE3& T) { return kDeg * std::acos(std::clamp(T.R(2, 2), -1.0, 1.0)); }

/// Mahalanobis distance of the result from the prior, with the uncertainty of both.
double prior_chi2(const Registration& result, const PosePrior& prior) {
  const Vector6d apart = difference(result.T_target_source, prior.T_target_source);
  return apart.dot(compared_information(result.information, prior.covariance) * apart);
}

struct Attempts {
  Registration best;
  double rival_overlap = 0.0;  // of the best result elsewhere
};

/// All results; of those that a prior allows, if there are any, only these.
std::vector<Registration> register_all(const PreparedSubmap& source, const PreparedSubmap& target,
                                       std::span<const SE3> starts, const std::optional<PosePrior>& prior,
                                       const VerificationConfig& config) {
  // Of several starts even one that fits badly may take part in what is decided.
  LeastOverlap least;
  if (starts.size() == 1) least = {config.min_overlap, config.min_standing_overlap};
  std::vector<Registration> results, possible;
  for (const SE3& start : starts) {
    results.push_back(register_submaps(source, target, start, config.registration, least));
    if (prior && prior_chi2(results.back(), *prior) <= config.max_prior_chi2)
      possible.push_back(results.back());
  }
  return possible.empty() ? results : possible;
}

Attempts best_of(const std::vector<Registration>& results) {
  Attempts attempts;
  for (const Registration& result : results) {
    if (result.overlap > attempts.best.overlap) attempts.best = result;
  }
  for (const Registration& result : results) {
    const SE3 T = attempts.best.T_target_source.inverse() * result.T_target_source;
    if (T.t.norm() > kRivalDistance)
      attempts.rival_overlap = std::max(attempts.rival_overlap, result.overlap);
  }
  return attempts;
}

/// How far results from perturbed starts stray, along what is determined; those that the prior rules out do
/// not count.
struct Spread {
  double position = 0.0;  // [m]
  double rotation_deg = 0.0;
};

Spread spread_of(const PreparedSubmap& source, const PreparedSubmap& target, const Registration& best,
                 const std::optional<PosePrior>& prior, const VerificationConfig& config) {
  Spread spread;
  for (const double sign : {1.0, -1.0}) {
    const double yaw = sign * config.perturbation_deg / kDeg;
    const Vector3d shift = config.perturbation * Vector3d(sign * 0.8, 0.6, 0.0);
    const SE3 start = best.T_target_source * SE3{math::so3_exp(Vector3d(0, 0, yaw)), shift};
    const Registration again = register_submaps(source, target, start, config.registration);
    if (prior && prior_chi2(again, *prior) > config.max_prior_chi2) continue;
    const Vector6d apart = observed_part(difference(best.T_target_source, again.T_target_source),
                                         best.information, best.observability);
    spread.position = std::max(spread.position, apart.tail<3>().norm());
    spread.rotation_deg = std::max(spread.rotation_deg, kDeg * apart.head<3>().norm());
  }
  return spread;
}

Verification rejected(Verification verification, std::string why) {
  verification.accepted = false;
  verification.reason = "rejected: " + std::move(why);
  return verification;
}

std::optional<std::string> fault_of_fit(const Registration& result, const VerificationConfig& config) {
  if (result.status == RegistrationStatus::kTooFewMatches) return "fewer than 100 points meet a surface";
  if (result.status == RegistrationStatus::kHopeless)
    return fmt::format("overlap {:.2f} ({:.2f} of what stands) even within {:.1f} m is below {:.2f} ({:.2f})",
                       result.overlap, result.standing_overlap,
                       kHopelessDistance * config.registration.overlap_distance, config.min_overlap,
                       config.min_standing_overlap);
  if (result.overlap < config.min_overlap)
    return fmt::format("overlap {:.2f} is below {:.2f}", result.overlap, config.min_overlap);
  if (result.standing_overlap < config.min_standing_overlap)
    return fmt::format("overlap {:.2f} of what stands is below {:.2f}", result.standing_overlap,
                       config.min_standing_overlap);
  if (result.status == RegistrationStatus::kNotConverged)
    return fmt::format("no convergence in {} iterations", result.iterations);
  if (result.residual_rms > config.max_residual)
    return fmt::format("residual {:.3f} m exceeds {:.3f} m", result.residual_rms, config.max_residual);
  const double tilt = tilt_deg(result.T_target_source);
  if (tilt > config.max_tilt_deg)
    return fmt::format("tilt of {:.2f} deg between level submaps exceeds {:.2f} deg", tilt,
                       config.max_tilt_deg);
  return std::nullopt;
}

std::optional<std::string> fault_of_prior(const Registration& result, const std::optional<PosePrior>& prior,
                                          const VerificationConfig& config) {
  const int num_weak = result.observability.num_weak();
  if (!prior) {
    if (num_weak == 0) return std::nullopt;
    return fmt::format("{} of 6 directions undetermined and nothing else is known about the place", num_weak);
  }
  const double chi2 = prior_chi2(result, *prior);
  if (chi2 <= config.max_prior_chi2) return std::nullopt;
  const double apart = (prior->T_target_source.t - result.T_target_source.t).norm();
  return fmt::format("{:.2f} m from where it should be: chi2 {:.1f} exceeds {:.1f}", apart, chi2,
                     config.max_prior_chi2);
}

}  // namespace

Fields VerificationConfig::fields() {
  return {
      group("registration", registration, "how submaps are registered"),
      field("min_overlap", min_overlap, "", {0.0, 1.0},
            "share of the points that must lie on surfaces of the other"),
      field("min_standing_overlap", min_standing_overlap, "", {0.0, 1.0},
            "the same of the points that are no floor or ceiling"),
      field("max_residual", max_residual, "m", {0.001, 2.0}, "of those points, root mean square"),
      field("max_tilt_deg", max_tilt_deg, "deg", {0.0, 90.0}, "between two submaps that are both level"),
      field("max_crossing_share", max_crossing_share, "", {0.0, 1.0},
            "of rays that pass through surfaces of the other"),
      field("perturbation", perturbation, "m", {0.0, 10.0},
            "of the starts from which the result must be found again"),
      field("perturbation_deg", perturbation_deg, "deg", {0.0, 45.0}, "the same of their yaw"),
      field("agree_within", agree_within, "m", {0.0, 5.0},
            "distance of the results from those starts, at most"),
      field("agree_within_deg", agree_within_deg, "deg", {0.0, 45.0}, "the same of their rotation"),
      field("rival_overlap", rival_overlap, "", {0.0, 1.0},
            "a result elsewhere with more than this share of the best one's overlap makes it ambiguous"),
      field("max_prior_chi2", max_prior_chi2, "", {1.0, 1e6}, "squared normalised distance from the prior"),
  };
}

Verification verify(const PreparedSubmap& source, const PreparedSubmap& target, std::span<const SE3> starts,
                    const std::optional<PosePrior>& prior, const VerificationConfig& config) {
  const Attempts attempts = best_of(register_all(source, target, starts, prior, config));
  Verification result;
  result.registration = attempts.best;
  const Registration& best = result.registration;
  if (const auto fault = fault_of_fit(best, config)) return rejected(result, *fault);
  if (const auto fault = fault_of_prior(best, prior, config)) {
    result.refused_by_prior = prior.has_value();
    return rejected(result, *fault);
  }
  if (attempts.rival_overlap > config.rival_overlap * best.overlap && best.observability.num_weak() == 0) {
    return rejected(result, fmt::format("ambiguous: overlap {:.2f} here and {:.2f} elsewhere", best.overlap,
                                        attempts.rival_overlap));
  }
  result.crossing_share = crossing_share(source, target, best.T_target_source);
  if (result.crossing_share > config.max_crossing_share) {
    return rejected(result, fmt::format("{:.1f} % of rays pass through surfaces of the other, over {:.1f} %",
                                        100 * result.crossing_share, 100 * config.max_crossing_share));
  }
  const Spread spread = spread_of(source, target, best, prior, config);
  if (spread.position > config.agree_within || spread.rotation_deg > config.agree_within_deg) {
    return rejected(result, fmt::format("starts nearby end {:.2f} m and {:.2f} deg apart", spread.position,
                                        spread.rotation_deg));
  }
  result.accepted = true;
  result.reason = fmt::format(
      "accepted: overlap {:.2f} ({:.2f} of what stands), residual {:.3f} m, {:.1f} % of rays cross, starts "
      "agree within {:.3f} m and "
      "{:.2f} deg, "
      "{} of 6 directions undetermined",
      best.overlap, best.standing_overlap, best.residual_rms, 100 * result.crossing_share, spread.position,
      spread.rotation_deg, best.observability.num_weak());
  return result;
}

}  // namespace mmlins::registration

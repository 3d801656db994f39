// SPDX-License-Identifier: MIT
#include "mmlins/initialization/acceptance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mmlins/base/result.hpp"

namespace mmlins::initialization {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

template <typename... Args>
Acceptance refused(Verdict verdict, fmt::format_string<Args...> format, Args&&... args) {
  return {verdict, fmt::format(format, std::forward<Args>(args)...)};
}

/// What can be said before looking at the solution.
Acceptance judge_window(const MapSolution& solution, bool carried, const InitializationConfig& config) {
  const SolutionFigures& f = solution.figures;
  const double shortest = carried ? config.window.carried_min : config.window.cold_min;
  if (solution.status == SolveStatus::kTooFewPoses || f.num_poses < config.window.min_poses) {
    return refused(Verdict::kTooFewPoses, "{} poses, at least {} are needed", f.num_poses,
                   config.window.min_poses);
  }
  if (f.duration < shortest) {
    return refused(Verdict::kWindowTooShort, "poses over {:.2f} s, at least {:.2f} s are needed", f.duration,
                   shortest);
  }
  if (solution.status == SolveStatus::kNoImu) return refused(Verdict::kImuGap, "no IMU samples");
  if (f.longest_imu_step > config.acceptance.max_imu_gap) {
    return refused(Verdict::kImuGap, "{:.2f} s without an IMU sample, at most {:.2f} s are allowed",
                   f.longest_imu_step, config.acceptance.max_imu_gap);
  }
  if (solution.status == SolveStatus::kSingular) {
    return refused(Verdict::kNotDetermined, "poses, IMU and prior together do not determine the state");
  }
  if (solution.status == SolveStatus::kNotConverged) {
    return refused(Verdict::kNotConverged, "the estimate had not settled after {} iterations", f.iterations);
  }
  return {Verdict::kAccepted, ""};
}

/// Whether poses, IMU and prior agree with each other.
Acceptance judge_agreement(const SolutionFigures& f, const AcceptanceConfig& limits) {
  const double allowed = std::max(limits.gravity_error, limits.gravity_sigmas * f.sigma_gravity);
  if (f.chi2_per_dof > limits.max_chi2) {
    return refused(Verdict::kPosesDisagree,
                   "poses and IMU disagree: chi2/dof {:.2f}, at most {:.2f} is believed", f.chi2_per_dof,
                   limits.max_chi2);
  }
  if (f.chi2_per_dof < limits.min_chi2) {
    return refused(
        Verdict::kPosesNotMeasured,
        "poses agree too well with the IMU to be measured: chi2/dof {:.4f}, at least {:.4f} is believed",
        f.chi2_per_dof, limits.min_chi2);
  }
  if (f.gravity_error > allowed) {
    return refused(Verdict::kGravityMagnitude,
                   "gravity misses its magnitude by {:.2f} m/s^2, {:.2f} m/s^2 are allowed", f.gravity_error,
                   allowed);
  }
  const double sigmas = std::max(f.gyro_bias_sigmas, f.accel_bias_sigmas);
  if (sigmas > limits.max_bias_sigmas) {
    return refused(Verdict::kBias, "the {} bias moved by {:.1f} sigmas, {:.1f} are allowed",
                   f.gyro_bias_sigmas >= f.accel_bias_sigmas ? "gyro" : "accelerometer", sigmas,
                   limits.max_bias_sigmas);
  }
  return {Verdict::kAccepted, ""};
}

/// Whether what came out is known well enough.
Acceptance judge_precision(const SolutionFigures& f, const AcceptanceConfig& limits) {
  const double tilt_deg = f.sigma_tilt * kDegrees;
  // What the accelerometer's unknown bias hides cannot be asked for, only admitted.
  const double allowed_deg = std::hypot(limits.max_tilt_deg, f.inseparable_tilt * kDegrees);
  if (!(tilt_deg <= allowed_deg)) {
    return refused(Verdict::kTilt, "direction of gravity known to {:.2f} deg, {:.2f} deg are needed",
                   tilt_deg, allowed_deg);
  }
  if (!(f.sigma_speed <= limits.max_speed_deviation)) {
    return refused(Verdict::kSpeed, "velocity known to {:.3f} m/s, {:.3f} m/s are needed", f.sigma_speed,
                   limits.max_speed_deviation);
  }
  if (f.sigma_speed_unaided * limits.min_speed_support > limits.max_speed_deviation) {
    return refused(Verdict::kSpeedUnsupported,
                   "without its prior the velocity is known to {:.3f} m/s, {:.3f} m/s are needed",
                   f.sigma_speed_unaided, limits.max_speed_deviation / limits.min_speed_support);
  }
  return {
      Verdict::kAccepted,
      fmt::format("{} poses over {:.2f} s: gravity to {:.2f} deg, velocity to {:.3f} m/s, chi2/dof {:.2f}",
                  f.num_poses, f.duration, tilt_deg, f.sigma_speed, f.chi2_per_dof)};
}

}  // namespace

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAccepted:
      return "accepted";
    case Verdict::kTooFewPoses:
      return "too few poses";
    case Verdict::kWindowTooShort:
      return "window too short";
    case Verdict::kImuGap:
      return "IMU gap";
    case Verdict::kNotDetermined:
      return "not determined";
    case Verdict::kNotConverged:
      return "not converged";
    case Verdict::kGravityMagnitude:
      return "gravity magnitude";
    case Verdict::kPosesDisagree:
      return "poses disagree with the IMU";
    case Verdict::kPosesNotMeasured:
      return "poses not measured";
    case Verdict::kBias:
      return "bias";
    case Verdict::kTilt:
      return "gravity direction uncertain";
    case Verdict::kSpeed:
      return "velocity uncertain";
    case Verdict::kSpeedUnsupported:
      return "velocity from the prior alone";
  }
  return "unknown";
}

Acceptance judge(const MapSolution& solution, bool carried, const InitializationConfig& config) {
  Acceptance result = judge_window(solution, carried, config);
  if (result.accepted()) result = judge_agreement(solution.figures, config.acceptance);
  if (result.accepted()) result = judge_precision(solution.figures, config.acceptance);
  return result;
}

Initialization initialize(const Window& window, const StatePrior& prior, const InitializationConfig& config) {
  Initialization result{solve_map(window, prior, config.max_iterations), {}};
  result.acceptance = judge(result.solution, prior.knows_gravity(), config);
  return result;
}

}  // namespace mmlins::initialization

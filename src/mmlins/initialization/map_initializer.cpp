// SPDX-License-Identifier: MIT
#include "mmlins/initialization/map_initializer.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "mmlins/initialization/window_problem.hpp"

namespace mmlins::initialization {
namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A step that would lessen the sum of squares by less is a hundredth of a standard deviation.
constexpr double kConverged = 1e-4;
constexpr int kVelocityInPrior = 0;
constexpr int kGravityInPrior = imu::kGravityDirection - imu::kVelocity;

double decrement(const ArrowSolution& step, const ArrowSystem& system) {
  double sum = step.shared.dot(system.b_shared);
  for (std::size_t k = 0; k < step.nodes.size(); ++k) sum += step.nodes[k].dot(system.b[k]);
  return sum;
}

void move(States& states, const ArrowSolution& step) {
  for (std::size_t k = 0; k < states.size(); ++k) {
    imu::ErrorVector error = imu::ErrorVector::Zero();
    error.head<kNodeSize>() = step.nodes[k];
    error.segment<6>(imu::kGyroBias) = step.shared.head<6>();
    const bool directed = step.shared.size() == kDirectedGravity;
    if (directed) error.tail<2>() = step.shared.tail<2>();
    states[k] = imu::plus(states[k], error);
    if (!directed) states[k].gravity_odom += step.shared.tail<3>();
  }
}

struct Minimum {
  SolveStatus status = SolveStatus::kNotConverged;
  States states;
  Eigen::MatrixXd last_covariance;
  double cost = 0.0;
  int iterations = 0;
};

/// Goes down until the sum of squares has settled; covariance and cost are those of the last linearisation.
template <typename Linearise>
Minimum minimise(States states, int max_iterations, const Linearise& linearise) {
  Minimum result;
  for (result.iterations = 1; result.iterations <= max_iterations; ++result.iterations) {
    const Linearised here = linearise(states);
    const ArrowSolution step = solve(here.system);
    if (!step.ok) {
      result.status = SolveStatus::kSingular;
      break;
    }
    const double gain = decrement(step, here.system);
    move(states, step);
    result.last_covariance = step.last_covariance;
    result.cost = here.cost - gain;
    if (std::abs(gain) < kConverged) {
      result.status = SolveStatus::kSolved;
      break;
    }
  }
  result.states = std::move(states);
  return result;
}

double largest_deviation(const Eigen::MatrixXd& P) {
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(P).eigenvalues().maxCoeff()));
}

/// Gravity without knowing how long it is, and without any prior but that of the biases. Eq. (13).
Minimum solve_freely(const WindowProblem& problem, const StatePrior& prior, int max_iterations) {
  const PriorMatrix biases =
      marginalised(marginalised(prior.information, kVelocityInPrior, 3), kGravityInPrior, 2);
  return minimise(problem.guess(), max_iterations, [&](const States& states) {
    return problem.linearise_free(states, biases.block<6, 6>(3, 3));
  });
}

void note_free_gravity(const Minimum& free, SolutionFigures& figures) {
  figures.sigma_gravity = kInfinity;
  if (free.status != SolveStatus::kSolved) return;
  const Vector3d& gravity = free.states[0].gravity_odom;
  const Vector3d down = gravity.normalized();
  figures.gravity_error = std::abs(gravity.norm() - imu::kGravity);
  figures.sigma_gravity = std::sqrt(down.dot(free.last_covariance.bottomRightCorner<3, 3>() * down));
}

double bias_sigmas(const StatePrior& prior, int first, const Vector3d& change) {
  PriorMatrix rest = prior.information;
  for (int other = 0; other < kPriorSize; other += 3) {
    if (other != first) rest = marginalised(rest, other, std::min(3, kPriorSize - other));
  }
  return std::sqrt(std::max(0.0, change.dot(rest.block<3, 3>(first, first) * change)));
}

double unaided_speed_deviation(const WindowProblem& problem, const StatePrior& prior, const States& states) {
  const PriorMatrix without = marginalised(prior.information, kVelocityInPrior, 3);
  const ArrowSolution solution = solve(problem.linearise(states, without).system);
  if (!solution.ok) return kInfinity;
  return largest_deviation(solution.last_covariance.block<3, 3>(imu::kVelocity, imu::kVelocity));
}

/// Without turning, a bias across gravity looks like a tilt by bias / G.
double inseparable_tilt(const StatePrior& prior) {
  if (prior.knows_gravity()) return 0.0;
  const double weakest = prior.information.diagonal().segment<3>(6).minCoeff();
  return 1.0 / (std::sqrt(weakest) * imu::kGravity);
}

void note_figures(const WindowProblem& problem, const StatePrior& prior, const Minimum& best,
                  MapSolution& result) {
  SolutionFigures& figures = result.figures;
  const imu::NavState& last = result.estimate.state;
  figures.iterations += best.iterations;
  figures.degrees_of_freedom = problem.degrees_of_freedom(prior.information);
  figures.chi2_per_dof = figures.degrees_of_freedom > 0 ? best.cost / figures.degrees_of_freedom : 0.0;
  figures.sigma_tilt = imu::tilt_deviation(result.estimate);
  figures.inseparable_tilt = inseparable_tilt(prior);
  figures.sigma_speed = largest_deviation(result.estimate.P.block<3, 3>(imu::kVelocity, imu::kVelocity));
  figures.sigma_speed_unaided = unaided_speed_deviation(problem, prior, best.states);
  figures.gyro_bias_sigmas = bias_sigmas(prior, 3, last.gyro_bias - prior.state.gyro_bias);
  figures.accel_bias_sigmas = bias_sigmas(prior, 6, last.accel_bias - prior.state.accel_bias);
}

/// The biases were taken to stand still over the window; they may have walked.
void add_bias_walk(imu::ErrorMatrix& P, const imu::ImuNoise& noise, double seconds) {
  P.diagonal().segment<3>(imu::kGyroBias).array() += noise.gyro_bias_walk * noise.gyro_bias_walk * seconds;
  P.diagonal().segment<3>(imu::kAccelBias).array() += noise.accel_bias_walk * noise.accel_bias_walk * seconds;
}

}  // namespace

MapSolution solve_map(const Window& window, const StatePrior& prior, int max_iterations) {
  MapSolution result;
  result.figures.num_poses = static_cast<int>(window.poses.size());
  if (window.poses.size() < 2) return result;
  result.figures.duration = to_seconds(window.poses.back().time - window.poses.front().time);
  result.status = SolveStatus::kNoImu;
  if (window.samples.empty()) return result;

  const WindowProblem problem(window, prior);
  result.figures.longest_imu_step = problem.longest_imu_step();
  const Minimum free = solve_freely(problem, prior, max_iterations);
  note_free_gravity(free, result.figures);
  result.figures.iterations = free.iterations;
  States start = problem.guess();
  if (!prior.knows_gravity() && free.status == SolveStatus::kSolved &&
      free.states[0].gravity_odom.norm() > 0.0) {
    start = free.states;
    for (auto& state : start) state.gravity_odom = imu::kGravity * state.gravity_odom.normalized();
  }
  const Minimum best = minimise(std::move(start), max_iterations, [&](const States& states) {
    return problem.linearise(states, prior.information);
  });
  result.status = best.status;
  result.states = best.states;
  if (best.status == SolveStatus::kSingular || best.last_covariance.size() == 0) return result;
  result.estimate = {best.states.back(), best.last_covariance};
  note_figures(problem, prior, best, result);
  add_bias_walk(result.estimate.P, window.noise, result.figures.duration);
  return result;
}

}  // namespace mmlins::initialization

// SPDX-License-Identifier: MIT
#include "mmlins/odometry/return_search.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace mmlins::odometry {
namespace {

constexpr int kSteps = 2;              // of one standard deviation, to each side
constexpr double kDoubt = 2.0;         // times the standard deviation that the IMU's noise model gives
constexpr double kFarthestStep = 2.2;  // what matches bridge, from both sides [m]
constexpr double kNearestStep = 0.25;  // what it bridges anyway [m]
constexpr double kClearlyMore = 1.15;
constexpr double kNearlyAsMuch = 0.85;
constexpr std::size_t kStride = 6;  // every so many keypoints will do for a search
constexpr double kElsewhere = 0.5;  // [m]

}  // namespace

std::vector<Eigen::Vector3d> places_to_try(const Eigen::Matrix3d& P_position) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(P_position.topLeftCorner<2, 2>());
  const auto step_of = [&](int axis) { return kDoubt * std::sqrt(std::max(0.0, solver.eigenvalues()(axis))); };
  if (step_of(1) > kFarthestStep) return {};
  std::vector<Eigen::Vector3d> places{Eigen::Vector3d::Zero()};
  const auto reach_of = [&](int axis) { return step_of(axis) < kNearestStep ? 0 : kSteps; };
  for (int i = -reach_of(0); i <= reach_of(0); ++i) {
    for (int j = -reach_of(1); j <= reach_of(1); ++j) {
      // Corners lie beyond two standard deviations.
      if ((i == 0 && j == 0) || i * i + j * j > kSteps * kSteps + 1) continue;
      const Eigen::Vector2d place =
          i * step_of(0) * solver.eigenvectors().col(0) + j * step_of(1) * solver.eigenvectors().col(1);
      places.emplace_back(place.x(), place.y(), 0.0);
    }
  }
  return places;
}

std::optional<Return> choose(const std::vector<Attempt>& attempts) {
  if (attempts.empty()) return std::nullopt;
  const auto best =
      std::max_element(attempts.begin(), attempts.end(),
                       [](const Attempt& a, const Attempt& b) { return a.explained < b.explained; });
  if (best->explained <= 0.0) return std::nullopt;
  const bool stays = best->explained < kClearlyMore * attempts.front().explained;
  const Attempt& chosen = stays ? attempts.front() : *best;
  Return result{chosen.state, {}, true};
  for (const Attempt& other : attempts) {
    const bool elsewhere = (other.state.p_odom - chosen.state.p_odom).norm() > kElsewhere;
    if (elsewhere && other.explained > kNearlyAsMuch * chosen.explained)
      result.rivals.push_back(other.state.p_odom);
  }
  return result;
}

std::optional<Return> search_return(const lidar::Cloud& keypoints, const imu::Estimate& prior,
                                    const PlacedMap& map, const MatchingConfig& config,
                                    const BeamNoise& noise) {
  std::vector<Eigen::Vector3f> some;
  for (std::size_t i = 0; i < keypoints.size(); i += kStride) some.push_back(keypoints.points[i]);
  if (some.empty()) return std::nullopt;
  const filter::UpdateLimits limits{
      .max_iterations = kPatienceFromAfar * config.max_iterations,
      .min_residuals = std::max(1, config.min_matches / static_cast<int>(kStride))};
  const auto places = places_to_try(prior.P.block<3, 3>(imu::kPosition, imu::kPosition));
  if (places.empty()) return Return{prior.state, {}, false};
  std::vector<Attempt> attempts;
  for (const Eigen::Vector3d& displacement : places) {
    LidarMeasurement measurement(some, map, config, noise);
    imu::NavState start = prior.state;
    start.p_odom += displacement;
    const auto update = filter::iterated_update(
        prior,
        [&](const imu::NavState& state, const imu::ErrorMatrix& P) {
          return measurement.linearise(state, P);
        },
        limits, &start);
    const bool matched = update.status != filter::UpdateStatus::kTooFewResiduals;
    const double share = update.information.num_residuals / static_cast<double>(some.size());
    attempts.push_back({update.estimate.state, matched ? share : 0.0});
  }
  return choose(attempts);
}

bool fits_elsewhere(const math::Vector3d& place, const std::vector<math::Vector3d>& rivals,
                    const degeneracy::Observability& observability) {
  return std::any_of(rivals.begin(), rivals.end(), [&](const math::Vector3d& rival) {
    math::Vector3d apart = rival - place;
    for (const degeneracy::Direction& direction : observability.translation) {
      if (direction.weak) apart -= direction.axis * direction.axis.dot(apart);
    }
    return apart.norm() > kElsewhere;
  });
}

}  // namespace mmlins::odometry

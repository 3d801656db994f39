// SPDX-License-Identifier: MIT
#include "mmlins/odometry/rebuilt_map.hpp"

#include <algorithm>
#include <numbers>

#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"

namespace mmlins::odometry {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr int kMaxIterations = 20;
/// So many of the recent keyframes say together where the known surroundings are: one alone has noise of its
/// own.
constexpr std::size_t kNumAligning = 5;
constexpr std::size_t kMaxAligningPoints = 6000;
/// Share of what is seen that must be known: less would be laid by chance.
constexpr double kMinKnown = 0.3;

/// Points of the latest keyframes as seen from the last of them.
std::vector<Eigen::Vector3f> seen_from_the_last(std::span<const PlacedPoints> recent) {
  const std::span<const PlacedPoints> latest = recent.last(std::min(kNumAligning, recent.size()));
  std::size_t num_points = 0;
  for (const PlacedPoints& one : latest) num_points += one.points_imu->size();
  const std::size_t stride = num_points / kMaxAligningPoints + 1;
  std::vector<Eigen::Vector3f> points;
  for (const PlacedPoints& one : latest) {
    const math::SE3 T_last_imu = recent.back().T_map_imu.inverse() * one.T_map_imu;
    for (std::size_t i = 0; i < one.points_imu->size(); i += stride) {
      points.push_back((T_last_imu * (*one.points_imu)[i].cast<double>()).cast<float>());
    }
  }
  return points;
}

struct Fit {
  double explained = 0.0;     ///< share of the points that match
  double residual_rms = 0.0;  ///< of those that do [m]
};

BeamNoise noise_of(const sensor::Rig& rig) {
  return {rig.bearing_noise_deg * kRadiansPerDegree, rig.T_imu_lidar().t};
}

Fit fit_of(const LocalMapInPlace& local, const PlacedView& view, const OdometryConfig& config,
           const sensor::Rig& rig) {
  LidarMeasurement measurement(view.points_imu, PlacedMap(*local.map, local.T_map_cells.inverse()),
                               config.matching, noise_of(rig));
  imu::NavState state;
  state.R_odom_imu = view.T_map_imu.R;
  state.p_odom = view.T_map_imu.t;
  const int num_matches = measurement.linearise(state, view.P).num_residuals;
  return {num_matches / std::max(1.0, static_cast<double>(view.points_imu.size())),
          measurement.residual_rms()};
}

}  // namespace

std::unique_ptr<spatial::LocalMap> make_local_map(const LocalMapConfig& config, double range_noise) {
  if (config.kind == MapKind::kKnn) return std::make_unique<spatial::KnnMap>(config.knn, range_noise);
  return std::make_unique<spatial::PlaneMap>(config.planes, range_noise);
}

void LocalMapInPlace::insert(std::span<const Eigen::Vector3f> points_imu, const math::SE3& T_map_imu) {
  const math::SE3 T_cells_imu = T_map_cells.inverse() * T_map_imu;
  std::vector<Eigen::Vector3d> points;
  points.reserve(points_imu.size());
  for (const Eigen::Vector3f& p_imu : points_imu) points.push_back(T_cells_imu * p_imu.cast<double>());
  map->insert(points, T_cells_imu.t);
}

bool align(LocalMapInPlace& local, const std::vector<Eigen::Vector3f>& points_imu, const math::SE3& T_map_imu,
           const OdometryConfig& config, const sensor::Rig& rig) {
  const RebuiltMapConfig& limits = config.rebuilt;
  LidarMeasurement measurement(points_imu, PlacedMap(*local.map, local.T_map_cells.inverse()),
                               config.matching, noise_of(rig));
  imu::Estimate prior;
  prior.state.R_odom_imu = T_map_imu.R;
  prior.state.p_odom = T_map_imu.t;
  const double rotation = limits.deviation_deg * kRadiansPerDegree;
  prior.P.setZero();
  prior.P.diagonal().segment<3>(imu::kRotation).setConstant(rotation * rotation);
  prior.P.diagonal().segment<3>(imu::kPosition).setConstant(limits.deviation * limits.deviation);
  const int least = std::max(config.matching.min_matches,
                             static_cast<int>(kMinKnown * static_cast<double>(points_imu.size())));
  const auto update = filter::iterated_update(
      prior,
      [&](const imu::NavState& state, const imu::ErrorMatrix& P) { return measurement.linearise(state, P); },
      {.max_iterations = kMaxIterations, .min_residuals = least});
  if (update.status != filter::UpdateStatus::kConverged) return false;
  const math::SE3 T_shown_imu = update.estimate.state.T_odom_imu();
  const math::SE3 apart = T_map_imu.inverse() * T_shown_imu;
  constexpr double kMostDeviations = 3.0;
  const double shift = apart.t.norm(), turn = math::so3_log(apart.R).norm();
  if (shift > kMostDeviations * limits.deviation || turn > kMostDeviations * rotation) return false;
  // What one scan cannot tell is left to the next ones. Moved by it each time, the map would wander.
  if (shift <= limits.settle && turn <= limits.settle_deg * kRadiansPerDegree) return true;
  local.T_map_cells = T_map_imu * T_shown_imu.inverse() * local.T_map_cells;
  return true;
}

std::optional<RebuiltMap> rebuild_map(std::span<const PlacedPoints> known,
                                      std::span<const PlacedPoints> recent, const OdometryConfig& config,
                                      const sensor::Rig& rig) {
  if (recent.empty()) return std::nullopt;
  RebuiltMap rebuilt{{make_local_map(config.map, rig.range_noise), {}}, {}};
  for (const PlacedPoints& one : known) rebuilt.local.insert(*one.points_imu, one.T_map_imu);
  if (!known.empty() &&
      !align(rebuilt.local, seen_from_the_last(recent), recent.back().T_map_imu, config, rig)) {
    return std::nullopt;
  }
  for (const PlacedPoints& one : recent) rebuilt.local.insert(*one.points_imu, one.T_map_imu);
  return rebuilt;
}

MapOffer::Answer MapOffer::consider(LocalMapInPlace& current, const PlacedView& view,
                                    const OdometryConfig& config, const sensor::Rig& rig) {
  if (!rebuilt_.to_come.empty()) {
    // One at a time: no scan shall have to wait for all of them.
    const PlacedPoints next = std::move(rebuilt_.to_come.front());
    rebuilt_.to_come.pop_front();
    insert(*next.points_imu, next.T_map_imu);
    return Answer::kNotYet;
  }
  const Fit now = fit_of(current, view, config, rig);
  if (align(rebuilt_.local, view.points_imu, view.T_map_imu, config, rig)) {
    const Fit then = fit_of(rebuilt_.local, view, config, rig);
    if (then.explained >= config.rebuilt.min_explained * now.explained &&
        then.residual_rms <= config.rebuilt.max_residual * now.residual_rms) {
      current = std::move(rebuilt_.local);
      return Answer::kTaken;
    }
  }
  return ++num_refusals_ < config.rebuilt.patience ? Answer::kNotYet : Answer::kRefused;
}

}  // namespace mmlins::odometry

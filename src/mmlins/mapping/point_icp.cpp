// SPDX-License-Identifier: MIT
#include "mmlins/mapping/point_icp.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace mmlins::mapping {
namespace {

using math::Matrix3d;
using math::SE3;
using math::Vector3d;

/// Ranges this short are looked through.
constexpr std::size_t kLeaf = 8;
/// A step shorter than this (rotation vector and translation in one) ends it [rad, m].
constexpr double kSmallStep = 1e-5;
constexpr int kFewestPairs = 10;

/// Sums over pairs of which the best motion follows.
struct Pairs {
  int count = 0;
  Vector3d sum_source = Vector3d::Zero();
  Vector3d sum_target = Vector3d::Zero();
  Matrix3d sum_products = Matrix3d::Zero();  ///< of target and source

  void add(const Vector3d& source, const Vector3d& target) {
    ++count;
    sum_source += source;
    sum_target += target;
    sum_products += target * source.transpose();
  }

  /// The rigid motion of the source points that brings them nearest to the targets (Arun et al., PAMI 1987).
  [[nodiscard]] SE3 motion() const {
    const Vector3d mean_source = sum_source / count, mean_target = sum_target / count;
    const Matrix3d covariance = sum_products / count - mean_target * mean_source.transpose();
    SE3 T;
    T.R = math::nearest_rotation(covariance);
    T.t = mean_target - T.R * mean_source;
    return T;
  }
};

}  // namespace

NearestPoint::NearestPoint(std::vector<Eigen::Vector3f> points)
    : points_(std::move(points)), axes_(points_.size(), 0) {
  split(0, points_.size());
}

void NearestPoint::split(std::size_t first, std::size_t last) {
  if (last - first <= kLeaf) return;
  Eigen::Vector3f low = points_[first], high = low;
  for (std::size_t i = first; i < last; ++i) {
    low = low.cwiseMin(points_[i]);
    high = high.cwiseMax(points_[i]);
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t middle = first + (last - first) / 2;
  const auto begin = points_.begin();
  std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                   begin + static_cast<std::ptrdiff_t>(last),
                   [axis](const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a(axis) < b(axis); });
  axes_[middle] = static_cast<std::uint8_t>(axis);
  split(first, middle);
  split(middle + 1, last);
}

void NearestPoint::search(std::size_t first, std::size_t last, const Eigen::Vector3f& query,
                          Found& best) const {
  const auto look_at = [&](std::size_t i) {
    const float distance2 = (points_[i] - query).squaredNorm();
    if (distance2 < best.distance2) best = {points_[i], distance2};
  };
  if (last - first <= kLeaf) {
    for (std::size_t i = first; i < last; ++i) look_at(i);
    return;
  }
  const std::size_t middle = first + (last - first) / 2;
  look_at(middle);
  const float beyond = query(axes_[middle]) - points_[middle](axes_[middle]);
  const bool low_first = beyond < 0.0F;
  low_first ? search(first, middle, query, best) : search(middle + 1, last, query, best);
  if (beyond * beyond >= best.distance2) return;
  low_first ? search(middle + 1, last, query, best) : search(first, middle, query, best);
}

NearestPoint::Found NearestPoint::find(const Eigen::Vector3f& query) const {
  Found best{Eigen::Vector3f::Zero(), std::numeric_limits<float>::infinity()};
  search(0, points_.size(), query, best);
  return best;
}

IcpResult register_points(std::span<const Eigen::Vector3f> source, const NearestPoint& target,
                          const SE3& T_target_source, const IcpConfig& config) {
  IcpResult result{.T_target_source = T_target_source};
  const auto reach2 = static_cast<float>(config.reach * config.reach);
  while (result.iterations < config.max_iterations && !result.converged) {
    Pairs pairs;
    for (const Eigen::Vector3f& p : source) {
      const Vector3d p_target = result.T_target_source * p.cast<double>();
      const NearestPoint::Found nearest = target.find(p_target.cast<float>());
      if (nearest.distance2 <= reach2) pairs.add(p_target, nearest.point.cast<double>());
    }
    if (pairs.count < kFewestPairs) break;
    const SE3 step = pairs.motion();
    result.T_target_source = step * result.T_target_source;
    ++result.iterations;
    result.converged = math::se3_log(step).norm() < kSmallStep;
  }
  double sum = 0.0;
  for (const Eigen::Vector3f& p : source) {
    const Vector3d p_target = result.T_target_source * p.cast<double>();
    sum += static_cast<double>(target.find(p_target.cast<float>()).distance2);
  }
  result.fitness =
      source.empty() ? std::numeric_limits<double>::infinity() : sum / static_cast<double>(source.size());
  return result;
}

}  // namespace mmlins::mapping

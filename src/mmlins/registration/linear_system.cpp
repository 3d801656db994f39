// SPDX-License-Identifier: MIT
#include "mmlins/registration/linear_system.hpp"

#include "mmlins/base/parallel.hpp"

namespace mmlins::registration {

namespace {

using math::Vector3d;
using math::Vector6d;

constexpr std::size_t kGrain = 512;
constexpr double kGateInKernels = 3.0;  // beyond, a residual has less than a hundredth of its weight

/// d (n . T Exp(xi) p) / d xi.
Vector6d row(const Vector3d& p_source, const Vector3d& direction_source) {
  Vector6d J;
  J << p_source.cross(direction_source), direction_source;
  return J;
}

}  // namespace

std::optional<SurfaceMatch> find_surface(const Vector3d& p_target, const Matching& matching) {
  const double gate = kGateInKernels * matching.kernel;
  auto match = matching.map->match(p_target, gate, matching.reach);
  if (!match && matching.fallback != nullptr)
    match = matching.fallback->match(p_target, gate, matching.reach);
  return match;
}

LinearSystem& LinearSystem::operator+=(const LinearSystem& other) {
  H += other.H;
  b += other.b;
  num_matched += other.num_matched;
  return *this;
}

std::optional<Residual> residual_of(const Vector3d& p_source, const math::SE3& T_target_source,
                                    const Matching& matching) {
  const Vector3d p_target = T_target_source * p_source;
  const auto match = find_surface(p_target, matching);
  if (!match) return std::nullopt;
  Residual residual;
  residual.cell = match->cell;
  residual.num_rows = match->cell->num_thin;
  for (int i = 0; i < residual.num_rows; ++i) {
    const Vector3d axis = match->cell->axes.col(i);
    residual.error(i) = axis.dot(p_target - match->cell->mean);
    residual.variance(i) = match->cell->variances(i) + matching.point_variance;
    residual.J.row(i) = row(p_source, T_target_source.R.transpose() * axis).transpose();
  }
  const double kernel2 = matching.kernel * matching.kernel;
  const double share = kernel2 / (kernel2 + match->distance * match->distance);
  residual.weight = share * share;
  return residual;
}

LinearSystem linearise(std::span<const Vector3d> samples, const math::SE3& T_target_source,
                       const Matching& matching) {
  return parallel::ordered_sum(samples.size(), kGrain, LinearSystem{},
                               [&](std::size_t begin, std::size_t end) {
                                 LinearSystem sum;
                                 for (std::size_t i = begin; i < end; ++i) {
                                   const auto residual = residual_of(samples[i], T_target_source, matching);
                                   if (!residual) continue;
                                   ++sum.num_matched;
                                   for (int k = 0; k < residual->num_rows; ++k) {
                                     const double weight = residual->weight / residual->variance(k);
                                     const Vector6d J = residual->J.row(k).transpose(), weighted = weight * J;
                                     sum.H.noalias() += weighted * J.transpose();
                                     sum.b -= residual->error(k) * weighted;
                                   }
                                 }
                                 return sum;
                               });
}

math::Matrix6d spurious_information(const Residual& residual, const Vector3d& p_source,
                                    const math::SE3& T_target_source) {
  math::Matrix6d sum = math::Matrix6d::Zero();
  const SurfaceCell& cell = *residual.cell;
  for (int k = 0; k < residual.num_rows; ++k) {
    for (int along = residual.num_rows; along < 3; ++along) {
      const double tilt_variance = residual.variance(k) / (cell.num_points * cell.variances(along));
      const Vector6d J = row(p_source, T_target_source.R.transpose() * cell.axes.col(along));
      sum += residual.weight * tilt_variance / residual.variance(k) * J * J.transpose();
    }
  }
  return sum;
}

}  // namespace mmlins::registration

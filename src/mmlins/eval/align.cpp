// SPDX-License-Identifier: MIT
#include "mmlins/eval/align.hpp"

#include <Eigen/SVD>
#include <cmath>

#include "mmlins/base/check.hpp"

namespace mmlins::eval {
namespace {

using math::Matrix3d;
using math::SE3;
using math::Vector3d;

// Below this share of the spread, what is left is rounding, not shape.
constexpr double kDegenerate = 1e-12;

Vector3d mean_of(const std::vector<Vector3d>& points) {
  Vector3d sum = Vector3d::Zero();
  for (const Vector3d& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

std::optional<Matrix3d> best_rotation(const Matrix3d& covariance) {
  const Eigen::JacobiSVD<Matrix3d> svd(covariance);
  const Vector3d spread = svd.singularValues();
  if (!(spread(1) > kDegenerate * spread(0))) return std::nullopt;
  return math::nearest_rotation(covariance);
}

/// Maximises trace(Rz(yaw)^T covariance).
std::optional<Matrix3d> best_heading(const Matrix3d& covariance) {
  const double sine = covariance(1, 0) - covariance(0, 1);
  const double cosine = covariance(0, 0) + covariance(1, 1);
  if (!(std::hypot(sine, cosine) > kDegenerate * covariance.norm())) return std::nullopt;
  return math::so3_exp({0.0, 0.0, std::atan2(sine, cosine)});
}

}  // namespace

std::optional<SE3> align_positions(const std::vector<Vector3d>& p_truth,
                                   const std::vector<Vector3d>& p_estimate, Alignment alignment) {
  MMLINS_CHECK(p_truth.size() == p_estimate.size());
  if (alignment == Alignment::kNone) return SE3{};
  if (p_truth.empty()) return std::nullopt;
  const Vector3d mean_truth = mean_of(p_truth);
  const Vector3d mean_estimate = mean_of(p_estimate);
  Matrix3d covariance = Matrix3d::Zero();
  for (std::size_t i = 0; i < p_truth.size(); ++i) {
    covariance += (p_truth[i] - mean_truth) * (p_estimate[i] - mean_estimate).transpose();
  }
  const auto R = alignment == Alignment::kYaw ? best_heading(covariance) : best_rotation(covariance);
  if (!R) return std::nullopt;
  return SE3{*R, mean_truth - *R * mean_estimate};
}

}  // namespace mmlins::eval

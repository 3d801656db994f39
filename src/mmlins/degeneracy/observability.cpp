// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/observability.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace mmlins::degeneracy {
namespace {

using math::Matrix3d;
using math::Vector3d;

/// Inverse of a symmetric positive semi-definite matrix on the space where it is not zero.
Matrix3d pseudo_inverse(const Matrix3d& M) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(M);
  const double floor = 1e-9 * std::max(solver.eigenvalues()(2), 0.0);
  Matrix3d inverse = Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) {
    if (solver.eigenvalues()(i) <= floor) continue;
    inverse += solver.eigenvectors().col(i) * solver.eigenvectors().col(i).transpose() / solver.eigenvalues()(i);
  }
  return inverse;
}

/// Where the two blocks begin: the one that is judged, and the other one, which is free.
struct Blocks {
  int judged;
  int free;
};

std::array<Direction, 3> principal_directions(const ScanInformation& information, const Blocks& blocks, double weak_std,
                                              double weak_noise_share) {
  const Matrix3d H_free_inverse = pseudo_inverse(information.H.block<3, 3>(blocks.free, blocks.free));
  const Matrix3d H_free_judged = information.H.block<3, 3>(blocks.free, blocks.judged);
  const Matrix3d marginal =
      information.H.block<3, 3>(blocks.judged, blocks.judged) - H_free_judged.transpose() * H_free_inverse * H_free_judged;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(0.5 * (marginal + marginal.transpose()));
  std::array<Direction, 3> directions;
  for (int i = 0; i < 3; ++i) {
    Direction& direction = directions[static_cast<std::size_t>(i)];
    direction.axis = solver.eigenvectors().col(i);
    // The motion of all six that this direction stands for: the free block follows as it likes best.
    math::Vector6d lifted;
    lifted.segment<3>(blocks.judged) = direction.axis;
    lifted.segment<3>(blocks.free) = -H_free_inverse * H_free_judged * direction.axis;
    const double seen = std::max(0.0, solver.eigenvalues()(i));
    const double feigned = lifted.dot(information.spurious * lifted);
    direction.noise_share = seen > 0.0 ? std::min(1.0, feigned / seen) : 1.0;
    const double real = seen - feigned;
    direction.std = real > 0.0 ? 1.0 / std::sqrt(real) : std::numeric_limits<double>::infinity();
    direction.weak = direction.std > weak_std || direction.noise_share > weak_noise_share;
  }
  return directions;
}

}  // namespace

Fields ObservabilityConfig::fields() {
  return {
      field("weak_position", weak_position, "m", {1e-4, 10.0},
            "a direction that one scan determines no better than this is weak"),
      field("weak_rotation_deg", weak_rotation_deg, "deg", {1e-3, 90.0}, "the same for rotations"),
      field("weak_noise_share", weak_noise_share, "", {0.0, 1.0},
            "a direction of whose information noisy normals feign more than this share is weak"),
  };
}

ScanInformation& ScanInformation::operator+=(const ScanInformation& other) {
  H += other.H;
  spurious += other.spurious;
  return *this;
}

int Observability::num_weak() const {
  const auto weak = [](const Direction& direction) { return direction.weak; };
  return static_cast<int>(std::count_if(rotation.begin(), rotation.end(), weak) +
                          std::count_if(translation.begin(), translation.end(), weak));
}

Observability analyse_observability(const ScanInformation& information, const ObservabilityConfig& config) {
  const double weak_rotation = config.weak_rotation_deg * std::numbers::pi / 180.0;
  return {principal_directions(information, {.judged = 0, .free = 3}, weak_rotation, config.weak_noise_share),
          principal_directions(information, {.judged = 3, .free = 0}, config.weak_position, config.weak_noise_share)};
}

}  // namespace mmlins::degeneracy

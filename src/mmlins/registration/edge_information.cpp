// SPDX-License-Identifier: MIT
#include "mmlins/registration/edge_information.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace mmlins::registration {

namespace {

using math::Matrix3d;
using math::Matrix6d;
using math::Vector6d;

constexpr double kNextToNothing = 1e-4;

Vector6d lift(const Matrix6d& H, const math::Vector3d& axis, int judged) {
  const int free = 3 - judged;
  const Matrix3d H_free = H.block<3, 3>(free, free);
  const Matrix3d ridge = 1e-9 * H_free.trace() * Matrix3d::Identity();
  Vector6d motion;
  motion.segment<3>(judged) = axis;
  motion.segment<3>(free) = -(H_free + ridge).ldlt().solve(H.block<3, 3>(free, judged) * axis);
  return motion;
}

}  // namespace

std::vector<JudgedDirection> judge_directions(const Matrix6d& H,
                                              const degeneracy::Observability& observability,
                                              double weak_noise_share) {
  std::vector<JudgedDirection> judged;
  const auto add = [&](const degeneracy::Direction& direction, int block) {
    const bool feigned = direction.noise_share > weak_noise_share;
    judged.push_back(
        {lift(H, direction.axis, block), feigned ? kNextToNothing : 1.0 - direction.noise_share});
  };
  for (const auto& direction : observability.rotation) add(direction, 0);
  for (const auto& direction : observability.translation) add(direction, 3);
  return judged;
}

Matrix6d reduce_information(const Matrix6d& information, const JudgedDirection& direction) {
  const Vector6d pull = information * direction.motion;
  const double amount = direction.motion.dot(pull);
  if (amount <= 0.0) return information;
  return information - (1.0 - direction.share_kept) / amount * pull * pull.transpose();
}

Vector6d observed_part(const Vector6d& motion, const Matrix6d& H,
                       const degeneracy::Observability& observability) {
  Vector6d rest = motion;
  const auto remove = [&](const degeneracy::Direction& direction, int block) {
    if (!direction.weak) return;
    const Vector6d lifted = lift(H, direction.axis, block);
    const double amount = lifted.dot(H * lifted);
    if (amount > 0.0) rest -= lifted.dot(H * rest) / amount * lifted;
  };
  for (const auto& direction : observability.translation) remove(direction, 3);
  for (const auto& direction : observability.rotation) remove(direction, 0);
  return rest;
}

Matrix6d compared_information(const Matrix6d& information, const Matrix6d& covariance) {
  // (C + L^-1)^-1 = L - L (L + C^-1)^-1 L
  const Matrix6d P = covariance.ldlt().solve(Matrix6d::Identity());
  const Matrix6d out = information - information * (information + P).ldlt().solve(information);
  return 0.5 * (out + out.transpose());
}

}  // namespace mmlins::registration

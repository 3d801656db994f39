// SPDX-License-Identifier: MIT
#include "mmlins/imu/hindsight.hpp"

#include <Eigen/Cholesky>

#include "mmlins/base/check.hpp"
#include "mmlins/imu/frame_change.hpp"

namespace mmlins::imu {
namespace {

/// What is left of the error once the pose is taken for granted: velocity, biases, direction of gravity.
constexpr int kSeen = kErrorSize - kVelocity;
using SeenVector = Eigen::Matrix<double, kSeen, 1>;
using SeenMatrix = Eigen::Matrix<double, kSeen, kSeen>;
/// 99.9 % of eleven squared normal errors stay below.
constexpr double kMaxChi2 = 31.3;

SeenMatrix seen_part(const ErrorMatrix& P) { return P.bottomRightCorner<kSeen, kSeen>(); }

}  // namespace

std::optional<Estimate> in_hindsight(const Estimate& carried, const Estimate& found) {
  MMLINS_CHECK(carried.state.time == found.state.time);
  const math::SE3 T_odom_found = carried.state.T_odom_imu() * found.state.T_odom_imu().inverse();
  const Estimate seen = with_pose_taken_for_granted(transformed(T_odom_found, found));
  const SeenVector surprise = minus(seen.state, carried.state).tail<kSeen>();

  const Eigen::Matrix<double, kSeen, kErrorSize> A =
      jacobian_of_granted_pose(carried.state).bottomRows<kSeen>();
  const SeenMatrix before = A * carried.P * A.transpose();
  // Metres per second and radians: in their own deviations the system is better conditioned.
  const SeenVector scale = before.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<SeenMatrix> normalised((scale.asDiagonal() * before * scale.asDiagonal()).eval());
  if (normalised.info() != Eigen::Success || !normalised.isPositive()) return std::nullopt;
  const SeenVector normal_surprise = scale.cwiseProduct(surprise);
  if (normal_surprise.dot(normalised.solve(normal_surprise)) > kMaxChi2) return std::nullopt;

  const Eigen::Matrix<double, kErrorSize, kSeen> K =
      normalised.solve(scale.asDiagonal() * A * carried.P).transpose() * scale.asDiagonal();
  Estimate result{plus(carried.state, K * surprise), carried.P - K * (before - seen_part(seen.P)) * K.transpose()};
  result.P = (0.5 * (result.P + result.P.transpose())).eval();
  return result;
}

}  // namespace mmlins::imu

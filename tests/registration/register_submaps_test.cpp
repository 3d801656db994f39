// SPDX-License-Identifier: MIT
#include "mmlins/registration/register_submaps.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/base/parallel.hpp"
#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/registration/edge_information.hpp"
#include "mmlins/registration/linear_system.hpp"
#include "tests/registration/drawn_submaps.hpp"

namespace mmlins::registration {
namespace {

using math::Matrix6d;
using math::SE3;
using math::Vector3d;
using math::Vector6d;

constexpr double kDeg = M_PI / 180.0;

Vector6d error_of(const Registration& result, const SE3& truth) {
  return math::se3_log(result.T_target_source.inverse() * truth);
}

TEST(RegisterSubmaps, FindsTheTruePoseFromTwoMetresAndTenDegreesOff) {
  const SE3 T_world_target = level_pose(1, 0.5, 0, 20), T_world_source = level_pose(-1, -0.5, 0.2, 75);
  const SE3 truth = T_world_target.inverse() * T_world_source;
  const PreparedSubmap target = prepare(drawn_submap(drawn_room(), T_world_target, 0.01, 1), {});
  const PreparedSubmap source = prepare(drawn_submap(drawn_room(), T_world_source, 0.01, 2), {});
  for (int k = 0; k < 8; ++k) {
    const SE3 guess = level_pose(2 * std::cos(k), 2 * std::sin(k), 0.2, 0.0);
    const SE3 off{truth.R * math::so3_exp({0, 0, (k % 2 == 0 ? 10 : -10) * kDeg}), truth.t + guess.t};
    const Registration result = register_submaps(source, target, off, {});
    EXPECT_EQ(result.status, RegistrationStatus::kConverged) << k;
    // Thousands of points with 1 cm noise; the mean of each surface is known to a millimetre or two.
    EXPECT_LT(error_of(result, truth).tail<3>().norm(), 0.01) << k;
    EXPECT_LT(error_of(result, truth).head<3>().norm(), 0.05 * kDeg) << k;
    EXPECT_GT(result.overlap, 0.9);
    EXPECT_EQ(result.observability.num_weak(), 0);
  }
}

TEST(RegisterSubmaps, RightsASubmapThatIsNotQuiteLevel) {
  const SE3 truth{math::so3_exp({0.8 * kDeg, -0.6 * kDeg, 0.3}), {1.0, 0.4, 0.1}};
  const Registration result =
      register_submaps(drawn_submap(drawn_room(), truth, 0.01, 2), drawn_submap(drawn_room(), {}, 0.01, 1),
                       level_pose(0.5, 0, 0, 14), {});
  EXPECT_LT(error_of(result, truth).head<3>().norm(), 0.05 * kDeg);
  EXPECT_LT(error_of(result, truth).tail<3>().norm(), 0.01);
}

TEST(RegisterSubmaps, NeverClaimsToKnowWhereInABareCorridorItIs) {
  const PreparedSubmap target = prepare(drawn_submap(drawn_corridor(), {}, 0.02, 1), {});
  const PreparedSubmap source = prepare(drawn_submap(drawn_corridor(), {}, 0.02, 2), {});
  const Registration result = register_submaps(source, target, level_pose(1.0, 0.3, 0.1, 3), {});
  EXPECT_EQ(result.observability.num_weak(), 1);
  EXPECT_NEAR(std::abs(result.observability.translation[0].axis.x()), 1.0, 1e-3);
  // Across and up it is known to centimetres; along, a metre off must cost next to nothing.
  const Matrix6d covariance = result.information.inverse();
  EXPECT_GT(covariance(3, 3), 1.0);
  EXPECT_LT(covariance(4, 4), 1e-3);
  EXPECT_LT(covariance(5, 5), 1e-3);
  EXPECT_LT(std::abs(error_of(result, {})(4)), 0.02);
}

TEST(RegisterSubmaps, FewPointsInCommonAreSaidSo) {
  const Registration result =
      register_submaps(drawn_submap(drawn_room(), {}, 0.01, 1), drawn_submap(drawn_room(), {}, 0.01, 2),
                       level_pose(200, 0, 0, 0), {});
  EXPECT_EQ(result.status, RegistrationStatus::kTooFewMatches);
}

TEST(RegisterSubmaps, GivesUpWhatCannotOverlapEnoughAndNothingElse) {
  const LeastOverlap least{0.4, 0.5};
  const PreparedSubmap room = prepare(drawn_submap(drawn_room(), {}, 0.02, 1), {});
  const PreparedSubmap again = prepare(drawn_submap(drawn_room(), level_pose(1, 0, 0, 9), 0.02, 2), {});
  const Registration carried = register_submaps(again, room, {}, {}, least),
                     whole = register_submaps(again, room, {}, {});
  EXPECT_EQ(carried.status, RegistrationStatus::kConverged);
  EXPECT_EQ(carried.T_target_source.t, whole.T_target_source.t);
  EXPECT_EQ(carried.information, whole.information);

  const PreparedSubmap corridor = prepare(drawn_submap(drawn_corridor(), {}, 0.02, 3), {});
  const Registration given_up = register_submaps(room, corridor, {}, {}, least),
                     to_its_end = register_submaps(room, corridor, {}, {});
  EXPECT_EQ(given_up.status, RegistrationStatus::kHopeless);
  EXPECT_LT(given_up.iterations, to_its_end.iterations);
  // What made it hopeless is more than what would have come out.
  EXPECT_LE(to_its_end.overlap, given_up.overlap);
  EXPECT_LE(to_its_end.standing_overlap, given_up.standing_overlap);
}

// 24 pairs that differ in their noise alone: the sum of 24 times 6 squared normalised errors has a mean of
// 144 if the information is right; min_correlation makes it smaller than right for noise that is independent.
TEST(RegisterSubmaps, ErrorsAreNoLargerThanTheInformationSays) {
  double sum = 0.0;
  for (std::uint64_t seed = 0; seed < 24; ++seed) {
    const Registration result =
        register_submaps(drawn_submap(drawn_room(), level_pose(0.5, 0, 0, 5), 0.03, 2 * seed),
                         drawn_submap(drawn_room(), {}, 0.03, 2 * seed + 1), {}, {});
    const Vector6d error = error_of(result, level_pose(0.5, 0, 0, 5));
    sum += error.dot(result.information * error);
  }
  EXPECT_LT(sum, 200.0);  // a chi-square variable of 144 exceeds it once in a thousand
  EXPECT_GT(sum, 1.0);    // and it may not claim to know nothing
}

TEST(RegisterSubmaps, GivesTheSameBitsWithAnyNumberOfThreads) {
  const PreparedSubmap target = prepare(drawn_submap(drawn_room(), {}, 0.02, 1), {});
  const PreparedSubmap source = prepare(drawn_submap(drawn_room(), level_pose(1, 0, 0, 9), 0.02, 2), {});
  const int before = parallel::num_threads();
  parallel::set_num_threads(1);
  const Registration one = register_submaps(source, target, {}, {});
  parallel::set_num_threads(3);
  const Registration three = register_submaps(source, target, {}, {});
  parallel::set_num_threads(before);
  EXPECT_EQ(one.T_target_source.t, three.T_target_source.t);
  EXPECT_EQ(one.T_target_source.R, three.T_target_source.R);
  EXPECT_EQ(one.information, three.information);
}

TEST(LinearSystem, JacobianIsTheDerivativeOfTheDistance) {
  const keyframe::Submap room = drawn_submap(drawn_room(), {}, 0.01, 1);
  const GaussianMap map(room.points, 1.0, {});
  const Matching matching{&map, nullptr, 0.5, 1.0, 1e-3};
  const SE3 T{math::so3_exp({0.02, -0.03, 0.4}), {0.2, 0.1, 0.05}};
  int checked = 0;
  for (const Vector3d& p_target :
       {Vector3d(-2.0, 3.05, 0.5), Vector3d(6, -7.9, 0.4), Vector3d(0.2, 0.3, -0.95)}) {
    const Vector3d p = T.inverse() * p_target;
    const auto residual = residual_of(p, T, matching);
    ASSERT_TRUE(residual.has_value());
    const auto distance = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      const SE3 moved = T * math::se3_exp(Vector6d(x));
      return residual->cell->axes.leftCols(residual->num_rows).transpose() *
             (moved * p - residual->cell->mean);
    };
    const Eigen::MatrixXd J = math::numerical_jacobian(distance, Vector6d::Zero());
    EXPECT_LT((J - residual->J.topRows(residual->num_rows)).norm(), 1e-7);
    checked += residual->num_rows;
  }
  EXPECT_EQ(checked, 4);  // two planes and a pole
}

TEST(EdgeInformation, ReducingOneDirectionLeavesTheShareAskedForAndAllElse) {
  math::Random random(5);
  Matrix6d A;
  for (int i = 0; i < 6; ++i) A.col(i) << random.normal3(), random.normal3();
  const Matrix6d information = A * A.transpose() + Matrix6d::Identity();
  Vector6d motion, other;
  motion << random.normal3(), random.normal3();
  other << random.normal3(), random.normal3();
  const Matrix6d reduced = reduce_information(information, {motion, 0.25});
  EXPECT_NEAR(motion.dot(reduced * motion), 0.25 * motion.dot(information * motion), 1e-9);
  other -= motion *
           (motion.dot(information * other) / motion.dot(information * motion));  // what is independent of it
  EXPECT_NEAR(other.dot(reduced * other), other.dot(information * other), 1e-9);
}

}  // namespace
}  // namespace mmlins::registration

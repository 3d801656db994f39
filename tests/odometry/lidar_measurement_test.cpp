// SPDX-License-Identifier: MIT
#include "mmlins/odometry/lidar_measurement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mmlins/base/parallel.hpp"
#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/spatial/plane_map.hpp"

namespace mmlins::odometry {
namespace {

using imu::ErrorMatrix;
using imu::ErrorVector;
using imu::NavState;
using math::Matrix6d;
using math::Vector3d;
using math::Vector6d;

const Vector3d kHalfRoom(4.0, 3.0, 1.5);  // [m]

/// Six perfect walls whose variances are given, so that every number has a closed form.
class RoomMap final : public spatial::LocalMap {
 public:
  double surface_variance = 4e-4;
  double plane_variance = 1e-4;

  void insert(std::span<const Vector3d>, const Vector3d&) override {}
  void evict_beyond(const Vector3d&, double) override {}
  [[nodiscard]] std::size_t num_cells() const override { return 6; }
  [[nodiscard]] spatial::PlaneMatch match(const Vector3d& point, double gate) const override {
    spatial::PlaneMatch best;
    for (std::uint32_t wall = 0; wall < 6; ++wall) {
      const int axis = static_cast<int>(wall) % 3;
      const double side = wall < 3 ? 1.0 : -1.0;
      const double distance = side * point(axis) - kHalfRoom(axis);
      if (std::abs(distance) > gate || (best.found && std::abs(distance) >= std::abs(best.distance)))
        continue;
      best.found = true;
      best.plane_id = wall;
      best.normal = side * Vector3d::Unit(axis);
      best.distance = distance;
      best.surface_variance = surface_variance;
      best.plane_variance = plane_variance;
    }
    return best;
  }
};

NavState true_state() {
  NavState state;
  state.R_odom_imu = math::so3_exp({0.1, -0.2, 2.0});
  state.p_odom = {0.5, -0.8, 0.2};
  return state;
}

/// Points well inside the walls (0.4 m from the edges), as seen from the IMU.
std::vector<Eigen::Vector3f> points_of_room(const NavState& state, int count) {
  sim::Random random(1);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    Vector3d p;
    for (int axis = 0; axis < 3; ++axis) p(axis) = random.uniform(-1.0, 1.0) * (kHalfRoom(axis) - 0.4);
    p(i % 3) = (i % 2 == 0 ? 1.0 : -1.0) * kHalfRoom(i % 3);
    points.push_back((state.T_odom_imu().inverse() * p).cast<float>());
  }
  return points;
}

NavState moved(const NavState& state, const Vector6d& d) {
  ErrorVector error = ErrorVector::Zero();
  error.head<6>() = d;
  return imu::plus(state, error);
}

/// Neither gate nor robust weight has a say.
MatchingConfig trusting() {
  MatchingConfig config;
  config.gate_sigmas = 1e6;
  config.huber_sigmas = 1e6;
  return config;
}

const Vector6d kOff = (Vector6d() << 0.01, -0.02, 0.015, 0.03, 0.02, -0.04).finished();

TEST(LidarMeasurement, GradientIsTheDerivativeOfHalfTheCost) {
  const RoomMap map;
  const auto points = points_of_room(true_state(), 500);
  LidarMeasurement measurement(points, map, trusting(), {});
  const NavState state = moved(true_state(), kOff);
  const filter::PoseInformation linear = measurement.linearise(state, ErrorMatrix::Identity());
  EXPECT_EQ(linear.num_residuals, 500);
  const auto half_cost = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(
        1, 0.5 * measurement.linearise(moved(state, d), ErrorMatrix::Identity()).cost);
  };
  const Eigen::VectorXd numerical =
      math::numerical_jacobian(half_cost, Eigen::VectorXd::Zero(6)).row(0).transpose();
  // Step 1e-6: rounding 1e-16 / 1e-6 of the cost.
  EXPECT_LT((linear.b - numerical).norm(), 1e-8 * numerical.norm());
}

TEST(LidarMeasurement, InformationIsTheCurvatureOfHalfTheCostWhereItVanishes) {
  const RoomMap map;
  const auto points = points_of_room(true_state(), 500);
  LidarMeasurement measurement(points, map, trusting(), {});
  const NavState state = true_state();
  const Matrix6d H = measurement.linearise(state, ErrorMatrix::Identity()).H;
  const auto gradient = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return measurement.linearise(moved(state, d), ErrorMatrix::Identity()).b;
  };
  // Points in single precision leave residuals of 1e-7 m; their curvature is lost.
  const Eigen::MatrixXd numerical = math::numerical_jacobian(gradient, Eigen::VectorXd::Zero(6), 1e-5);
  EXPECT_LT((H - numerical).norm(), 1e-5 * H.norm());
  EXPECT_LT((H - H.transpose()).norm(), 1e-12 * H.norm());
}

TEST(LidarMeasurement, GradientHoldsOnAMapOfPlanesLearntFromPoints) {
  spatial::PlaneMapConfig config;
  config.finest_cell = 0.5;
  config.num_levels = 2;
  spatial::PlaneMap map(config, 0.02);
  NavState origin;
  std::vector<Vector3d> walls;
  for (const auto& p : points_of_room(origin, 60000)) walls.push_back(p.cast<double>());
  map.insert(walls, Vector3d::Zero());
  const auto points = points_of_room(true_state(), 500);
  LidarMeasurement measurement(points, map, trusting(), {});
  const NavState state = moved(true_state(), 0.2 * kOff);
  const ErrorMatrix P = ErrorMatrix::Identity();
  const filter::PoseInformation linear = measurement.linearise(state, P);
  ASSERT_GT(linear.num_residuals, 400);
  const auto half_cost = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, 0.5 * measurement.linearise(moved(state, d), P).cost);
  };
  const Eigen::VectorXd numerical =
      math::numerical_jacobian(half_cost, Eigen::VectorXd::Zero(6), 1e-7).row(0).transpose();
  // What the linearisation leaves out: weights change with the place in a cell, by some per cent per
  // centimetre, times residuals of a centimetre; points change cells only if within 1e-7 m of a face.
  EXPECT_LT((linear.b - numerical).norm(), 0.02 * numerical.norm());
}

TEST(LidarMeasurement, NewtonStepsLeadToTheTruePose) {
  const RoomMap map;
  const auto points = points_of_room(true_state(), 500);
  LidarMeasurement measurement(points, map, trusting(), {});
  NavState state = moved(true_state(), 3.0 * kOff);
  for (int i = 0; i < 5; ++i) {
    const auto linear = measurement.linearise(state, ErrorMatrix::Identity());
    state = moved(state, -linear.H.ldlt().solve(linear.b));
  }
  // Points in single precision.
  EXPECT_LT((state.p_odom - true_state().p_odom).norm(), 1e-6);
  EXPECT_LT((state.R_odom_imu - true_state().R_odom_imu).norm(), 1e-6);
  EXPECT_LT(measurement.residual_rms(), 1e-6);
}

/// Points of the wall x = 4 alone, seen from the origin.
std::vector<Eigen::Vector3f> points_of_wall(int count) {
  sim::Random random(2);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(4.0F, static_cast<float>(random.uniform(-2.5, 2.5)),
                        static_cast<float>(random.uniform(-1.0, 1.0)));
  }
  return points;
}

TEST(LidarMeasurement, ManyPointsOfOnePlaneCannotBeatThePlanesOwnVariance) {
  const RoomMap map;
  NavState state;
  for (const int count : {1, 10, 100, 10000}) {
    const auto points = points_of_wall(count);
    LidarMeasurement measurement(points, map, trusting(), {});
    const double information = measurement.linearise(state, ErrorMatrix::Identity()).H(3, 3);
    // n readings with variance s each of one plane with variance v: their mean has variance s / n + v.
    const double variance = map.surface_variance / count + map.plane_variance;
    EXPECT_NEAR(information * variance, 1.0, 1e-9) << count;
  }
}

TEST(LidarMeasurement, GateIsAsWideAsNoiseMapAndStateAllow) {
  const RoomMap map;
  MatchingConfig config = trusting();
  config.gate_sigmas = 3.0;
  const std::vector<Eigen::Vector3f> points = points_of_wall(1);
  const double range2 = points[0].cast<double>().squaredNorm();
  for (const double deviation : {0.0, 0.003, 0.03}) {
    ErrorMatrix P = ErrorMatrix::Zero();
    P.topLeftCorner<6, 6>().diagonal().setConstant(deviation * deviation);
    const double state_variance = 3.0 * deviation * deviation * (1.0 + range2);
    const double gate = 3.0 * std::sqrt(map.surface_variance + map.plane_variance + state_variance);
    for (const double share : {0.99, 1.01}) {
      NavState state;
      state.p_odom.x() = share * gate;
      LidarMeasurement measurement(points, map, config, {});
      EXPECT_EQ(measurement.linearise(state, P).num_residuals, share < 1.0 ? 1 : 0) << deviation;
    }
  }
}

TEST(LidarMeasurement, LargeResidualsPullWithAConstantForce) {
  RoomMap map;
  map.plane_variance = 0.0;
  MatchingConfig config = trusting();
  config.huber_sigmas = 2.0;
  const auto points = points_of_wall(1);
  const double sigma = std::sqrt(map.surface_variance);
  const auto pull = [&](double sigmas) {
    NavState state;
    state.p_odom.x() = sigmas * sigma;
    LidarMeasurement measurement(points, map, config, {});
    return measurement.linearise(state, ErrorMatrix::Identity()).b(3);
  };
  EXPECT_NEAR(pull(1.0), 1.0 / sigma, 1e-4 / sigma);  // points in single precision
  EXPECT_NEAR(pull(4.0), 2.0 / sigma, 1e-4 / sigma);
  EXPECT_NEAR(pull(10.0), 2.0 / sigma, 1e-4 / sigma);
}

TEST(LidarMeasurement, BeamsAlongASurfaceAreLessCertainThanBeamsOntoIt) {
  RoomMap map;
  map.plane_variance = 0.0;
  const double bearing = 0.01;  // [rad]
  const BeamNoise noise{bearing, Vector3d(0.5, 0.0, 0.0)};
  const NavState state;
  const std::vector<Eigen::Vector3f> onto{{4.0F, 0.0F, 0.0F}};
  const std::vector<Eigen::Vector3f> slanting{{4.0F, 2.5F, 0.0F}};
  LidarMeasurement straight(onto, map, trusting(), noise);
  LidarMeasurement oblique(slanting, map, trusting(), noise);
  EXPECT_NEAR(straight.linearise(state, ErrorMatrix::Identity()).H(3, 3) * map.surface_variance, 1.0,
              1e-9);
  // A beam that turns by an angle moves its point by range times angle, of which the part across the wall
  // is what the beam covers along the wall: here 2.5 m, wherever the sensor sits in front.
  const double variance = map.surface_variance + bearing * bearing * 2.5 * 2.5;
  EXPECT_NEAR(oblique.linearise(state, ErrorMatrix::Identity()).H(3, 3) * variance, 1.0, 1e-9);
}

TEST(LidarMeasurement, GivesTheSameBitsWhateverTheNumberOfThreads) {
  const RoomMap map;
  const auto points = points_of_room(true_state(), 5000);
  const NavState state = moved(true_state(), kOff);
  const auto linearise = [&](int threads) {
    parallel::set_num_threads(threads);
    LidarMeasurement measurement(points, map, trusting(), {});
    const auto result = measurement.linearise(state, ErrorMatrix::Identity());
    parallel::set_num_threads(0);
    return result;
  };
  const auto one = linearise(1);
  const auto four = linearise(4);
  EXPECT_EQ(one.H, four.H);
  EXPECT_EQ(one.b, four.b);
  EXPECT_EQ(one.cost, four.cost);
}

TEST(LidarMeasurement, WithoutPointsThereIsNothing) {
  const RoomMap map;
  const std::vector<Eigen::Vector3f> none;
  LidarMeasurement measurement(none, map, trusting(), {});
  const auto linear = measurement.linearise(NavState(), ErrorMatrix::Identity());
  EXPECT_EQ(linear.num_residuals, 0);
  EXPECT_TRUE(linear.H.isZero());
  EXPECT_EQ(measurement.residual_rms(), 0.0);
}

}  // namespace
}  // namespace mmlins::odometry

// SPDX-License-Identifier: MIT
#pragma once
// What Ceres must know: how poses are stored and moved, the cost functions, and a loss whose weight can be
// changed between two solutions. Internal to graph/.

#include <ceres/ceres.h>

#include <array>
#include <utility>

#include "mmlins/graph/residuals.hpp"

namespace mmlins::graph {

/// A pose as Ceres holds it: qx qy qz qw x y z.
using PoseBlock = std::array<double, 7>;
[[nodiscard]] PoseBlock to_block(const SE3& T);
[[nodiscard]] SE3 from_block(const double* block);

/// T [+] [w; u]. The derivative of Plus is given as [I; 0]: in return the cost functions put their
/// derivatives with respect to the six steps into the first six columns. docs/math/pose_graph.md, "Ceres".
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

/// Only turns about the world's two horizontal axes, about the node itself. Same convention.
class TiltManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 2; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override;
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool Minus(const double* y, const double* x, double* y_minus_x) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

class EdgeCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  EdgeCost(const SE3& T_from_to, Matrix6d S) : T_from_to_(T_from_to), S_(std::move(S)) {}
  bool Evaluate(const double* const* blocks, double* residuals, double** jacobians) const override;

 private:
  SE3 T_from_to_;
  Matrix6d S_;
};

class GravityCost final : public ceres::SizedCostFunction<3, 7> {
 public:
  GravityCost(const Vector3d& up_node, double sigma) : up_node_(up_node), sigma_(sigma) {}
  bool Evaluate(const double* const* blocks, double* residuals, double** jacobians) const override;

 private:
  Vector3d up_node_;
  double sigma_;
};

/// Multiplies the squared error by a weight that may change between two solutions.
class WeightLoss final : public ceres::LossFunction {
 public:
  void set_weight(double weight) { weight_ = weight; }
  void Evaluate(double squared, double out[3]) const override {
    out[0] = weight_ * squared;
    out[1] = weight_;
    out[2] = 0.0;
  }

 private:
  double weight_ = 1.0;
};

}  // namespace mmlins::graph

// SPDX-License-Identifier: MIT
#pragma once
// The referee of the tests: Jacobians by central differences.

#include <Eigen/Core>

namespace mmlins::math {

/// d f(x) / d x at `x` for a vector-valued `f` of a dynamic vector.
template <typename Function>
[[nodiscard]] Eigen::MatrixXd numerical_jacobian(const Function& f, const Eigen::VectorXd& x, double step = 1e-6) {
  Eigen::MatrixXd J(f(x).size(), x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    Eigen::VectorXd forward = x;
    Eigen::VectorXd backward = x;
    forward(i) += step;
    backward(i) -= step;
    J.col(i) = (f(forward) - f(backward)) / (2.0 * step);
  }
  return J;
}

}  // namespace mmlins::math

// SPDX-License-Identifier: MIT
#pragma once
// Information matrices of g2o files: errors [translation; vector part of the quaternion] instead of
// [rotation vector; translation]. Near zero the vector part is half the rotation vector. Internal to graph/.

#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::graph {

/// docs/math/pose_graph.md, Eq. (11).
[[nodiscard]] inline Matrix6d from_g2o_information(const Matrix6d& g2o) {
  Matrix6d information;
  information << 0.25 * g2o.bottomRightCorner<3, 3>(), 0.5 * g2o.bottomLeftCorner<3, 3>(),
      0.5 * g2o.topRightCorner<3, 3>(), g2o.topLeftCorner<3, 3>();
  return information;
}

[[nodiscard]] inline Matrix6d to_g2o_information(const Matrix6d& information) {
  Matrix6d g2o;
  g2o << information.bottomRightCorner<3, 3>(), 2.0 * information.bottomLeftCorner<3, 3>(),
      2.0 * information.topRightCorner<3, 3>(), 4.0 * information.topLeftCorner<3, 3>();
  return g2o;
}

}  // namespace mmlins::graph

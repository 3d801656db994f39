// SPDX-License-Identifier: MIT
#pragma once
// A world made from any point cloud, so that a failure can be rehearsed inside a map of one's own site:
// one flat disc for every small cube in which there are points, turned as the points around it lie.

#include <span>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/sim/embree_world.hpp"

namespace mmlins::sim {

struct CloudDiscs {
  double spacing = 0.2;  ///< edge of the cubes [m]
  double radius = 0.0;   ///< of the discs [m]; 0: just enough to leave no holes
};

/// Points that are not finite, and cubes with too few neighbours to tell a surface, are left out.
[[nodiscard]] std::vector<Disc> discs_of(std::span<const Eigen::Vector3f> points, const CloudDiscs& config);

/// Reads a .pcd or .ply file.
/// Errors: not readable, neither kind of file, or no surface in it.
[[nodiscard]] Result<std::unique_ptr<World>> load_cloud_world(const std::string& path,
                                                              const CloudDiscs& config);

}  // namespace mmlins::sim

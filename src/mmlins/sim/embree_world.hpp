// SPDX-License-Identifier: MIT
#pragma once
// Worlds for Embree: triangle meshes and clouds of flat discs. What a ray meets first is found in single
// precision; the range to it is then computed in double precision from the surface itself.

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

struct TriangleMesh {
  std::vector<math::Vector3d> vertices;                 ///< [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices
};

struct Disc {
  math::Vector3d center = math::Vector3d::Zero();   ///< [m]
  math::Vector3d normal = math::Vector3d::UnitZ();  ///< unit vector; both sides are visible
  double radius = 0.1;                              ///< [m]
};

/// Surfaces are numbered as the triangles are.
[[nodiscard]] std::unique_ptr<World> make_mesh_world(const TriangleMesh& mesh);
/// Surfaces are numbered as the discs are.
[[nodiscard]] std::unique_ptr<World> make_disc_world(std::vector<Disc> discs);

}  // namespace mmlins::sim

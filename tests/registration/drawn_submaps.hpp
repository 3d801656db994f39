// SPDX-License-Identifier: MIT
#pragma once
// Submaps drawn by hand: walls, floors and poles whose places are known exactly, with noise of a known size.

#include <vector>

#include "mmlins/keyframe/submap.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::registration {

using Points = std::vector<math::Vector3d>;

/// Points every `spacing` on the parallelogram that u and v span from the corner.
inline void add_plane(Points& points, const math::Vector3d& corner, const math::Vector3d& u,
                      const math::Vector3d& v, double spacing = 0.2) {
  const int nu = static_cast<int>(u.norm() / spacing), nv = static_cast<int>(v.norm() / spacing);
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) points.push_back(corner + (i + 0.5) / nu * u + (j + 0.5) / nv * v);
  }
}

inline void add_wall(Points& points, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                     double height = 3.0) {
  add_plane(points, {from.x(), from.y(), -1.0}, {to.x() - from.x(), to.y() - from.y(), 0.0}, {0, 0, height});
}

/// A room of 24 m x 16 m with a niche, two crates and a pole: nothing of it looks the same from elsewhere.
inline Points drawn_room() {
  Points points;
  add_plane(points, {-12, -8, -1.0}, {24, 0, 0}, {0, 16, 0}, 0.3);
  add_wall(points, {-12, -8}, {12, -8});
  add_wall(points, {12, -8}, {12, 8});
  add_wall(points, {12, 8}, {3, 8});
  add_wall(points, {3, 8}, {3, 5});
  add_wall(points, {3, 5}, {-12, 5});
  add_wall(points, {-12, 5}, {-12, -8});
  for (const Eigen::Vector2d& c : {Eigen::Vector2d(-6, -3), Eigen::Vector2d(5, 1)}) {
    add_wall(points, c, c + Eigen::Vector2d(2, 0.7), 1.6);
    add_wall(points, c, c + Eigen::Vector2d(-0.5, 1.5), 1.6);
  }
  for (double z = -1.0; z < 2.0; z += 0.1) points.emplace_back(-2.0, 3.0, z);
  return points;
}

/// Two walls and a floor along x, and nothing else.
inline Points drawn_corridor() {
  Points points;
  add_wall(points, {-30, -1.5}, {30, -1.5});
  add_wall(points, {-30, 1.5}, {30, 1.5});
  add_plane(points, {-30, -1.5, -1.0}, {60, 0, 0}, {0, 3, 0});
  return points;
}

/// The points as they look from `T_world_submap`, with normal noise [m].
inline keyframe::Submap drawn_submap(const Points& points_world, const math::SE3& T_world_submap,
                                     double noise, std::uint64_t seed) {
  math::Random random(seed);
  keyframe::Submap submap;
  submap.T_map_submap = T_world_submap;
  submap.viewpoints.push_back(Eigen::Vector3f::Zero());
  const math::SE3 T_submap_world = T_world_submap.inverse();
  for (const math::Vector3d& p : points_world) {
    submap.points.push_back((T_submap_world * p + noise * random.normal3()).cast<float>());
    submap.views.push_back(0);
  }
  return submap;
}

inline math::SE3 level_pose(double x, double y, double z, double yaw_deg) {
  return {math::so3_exp(math::Vector3d(0, 0, yaw_deg * M_PI / 180.0)), {x, y, z}};
}

}  // namespace mmlins::registration

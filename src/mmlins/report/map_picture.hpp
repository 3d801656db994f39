// SPDX-License-Identifier: MIT
#pragma once
// The map from above, as a picture: how much stands over each spot, and how high.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "mmlins/report/png.hpp"

namespace mmlins::report {

struct MapPicture {
  GrayAlphaImage image;           ///< opacity: amount of structure; brightness: mean height between low and high
  double metres_per_pixel = 1.0;
  double min_x = 0.0;             ///< of the left edge [m]
  double max_y = 0.0;             ///< of the upper edge [m]
  double low = 0.0;               ///< height that is drawn black [m]
  double high = 0.0;              ///< and white [m]
};

struct PictureSize {
  int max_pixels = 1600;               ///< of the longer side
  double min_metres_per_pixel = 0.1;
};

/// Draws the points, x to the right and y up. All of the path is on it and nearly all points are: some that lie far
/// off would leave little room for the others. An empty image if there are neither points nor path.
[[nodiscard]] MapPicture draw_from_above(std::span<const Eigen::Vector3f> points_map, std::span<const Eigen::Vector3d> path_map,
                                         const PictureSize& size);

}  // namespace mmlins::report

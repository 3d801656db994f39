// SPDX-License-Identifier: MIT
#pragma once
// Where in the surroundings of a guess could one submap lie in another? An exhaustive search over x, y and
// yaw on views from above, made quick by branch and bound (after Hess et al., "Real-time loop closure in 2D
// LIDAR SLAM", 2016): this is how a robot gets back into its old map after it saw nothing for a while.

#include <vector>

#include "mmlins/keyframe/bird_view.hpp"

namespace mmlins::registration {

struct SearchConfig {
  keyframe::BirdViewConfig view;
  double yaw_step_deg = 2.0;
  int num_starts = 4;
  double apart = 1.5;
  double apart_deg = 6.0;
  double min_score = 0.15;
  int max_nodes = 2'000'000;

  [[nodiscard]] Fields fields();
};

/// Where to search: an upright ellipse around the guess, and all headings within `yaw` of it.
struct SearchRegion {
  double semi_axis_x = 20.0;  ///< along the target's x [m]
  double semi_axis_y = 20.0;  ///< [m]
  double yaw = 0.26;          ///< to either side [rad]
  double height = 2.5;        ///< up and down; less than a storey, or floors would be confused [m]
};

struct Start {
  math::SE3 T_target_source;  ///< level; its height comes from fit_height()
  double score = 0.0;         ///< share of the source's structure that meets structure of the target
};

/// The best places, best first, no two of them nearer than `apart` and `apart_deg`.
[[nodiscard]] std::vector<Start> search_around(const keyframe::Submap& source, const keyframe::Submap& target,
                                               const math::SE3& T_target_source, const SearchRegion& region,
                                               const SearchConfig& config);

}  // namespace mmlins::registration

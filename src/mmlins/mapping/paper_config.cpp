// SPDX-License-Identifier: MIT
#include "mmlins/mapping/paper_config.hpp"

namespace mmlins::mapping {

Fields IcpConfig::fields() {
  return {
      field("reach", reach, "m", {0.1, 1000.0}, "points farther apart are no pair"),
      field("max_iterations", max_iterations, "", {1.0, 10000.0}, "at most"),
      field("max_fitness", max_fitness, "m^2", {0.0, 1000.0},
            "mean squared distance of nearest points, above which it is refused"),
  };
}

Fields PaperFusionConfig::fields() {
  return {
      group("context", context, "Scan Context of a keyframe"),
      field("max_distance", max_distance, "", {0.0, 1.0}, "of two Scan Contexts that are called similar"),
      field(
          "consecutive_hits", consecutive_hits, "", {0.0, 100.0},
          "paper's Eq. (3): that more keyframes in a row than this must be similar to the same sleeping map"),
      field("num_constraints", num_constraints, "", {1.0, 100.0},
            "paper's Eq. (9): similarity constraints of a fusion; as many hits in a row are waited for"),
      field("optimize", optimize,
            "otherwise maps lie where the initial transform has them, and loops are left open"),
      field("exclude_recent", exclude_recent, "", {1.0, 10000.0},
            "keyframes before the latest that are no loop"),
      field("loop_every", loop_every, "", {1.0, 10000.0},
            "keyframes from one attempt to close a loop to the next, at least"),
      field("num_around", num_around, "", {0.0, 100.0},
            "keyframes before and after one whose points are registered with it"),
      field("voxel", voxel, "m", {0.05, 5.0}, "points are thinned to one in each cube of this edge for ICP"),
      group("initial", initial, "ICP of the initial transform"),
      group("enhanced", enhanced, "ICP of each similarity constraint"),
      group("loop", loop, "ICP of a loop closure"),
      field("odometry_rotation_variance", odometry_rotation_variance, "rad^2", {1e-12, 1.0},
            "of each link between keyframes"),
      field("odometry_position_variance", odometry_position_variance, "m^2", {1e-12, 100.0},
            "of each link between keyframes"),
      field("closure_variance", closure_variance, "", {1e-12, 100.0},
            "of loops and similarity constraints, in rad^2 and m^2 alike"),
  };
}

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#include "mmlins/graph/optimize.hpp"

namespace mmlins::graph {

Fields OptimizerConfig::fields() {
  return {
      field("max_iterations", max_iterations, "", {1.0, 1000.0}, "of the solver, per solution"),
      field("tolerance", tolerance, "", {1e-15, 0.1},
            "ends when chi2 decreases by less than this share of itself"),
      field("robust", robust, "look for false loops and merges, and leave them out"),
      field("outlier_scale", outlier_scale, "", {0.1, 1000.0},
            "an edge is false whose chi2 exceeds the 99.9 % quantile times this"),
      field("gnc_step", gnc_step, "", {1.05, 10.0}, "by which the weights sharpen from round to round"),
      field("gnc_rounds", gnc_rounds, "", {1.0, 1000.0}, "most changes of the weights"),
      field("gnc_iterations", gnc_iterations, "", {1.0, 100.0},
            "most iterations of the solver after each change"),
      field("gap_cauchy", gap_cauchy, "sigma", {0.0, 100.0}, "scale of a Cauchy loss on gap edges; 0: none"),
      field("place_maps", place_maps, "begin with maps where most edges between them agree"),
  };
}

}  // namespace mmlins::graph

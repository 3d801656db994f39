// SPDX-License-Identifier: MIT
#pragma once
// Parameters of the back end after the MM-LINS paper, which gives hardly any: where it is silent they are
// those of its published code. docs/math/mapping.md, "After the paper".

#include "mmlins/base/config_fields.hpp"
#include "mmlins/place/scan_context.hpp"

namespace mmlins::mapping {

/// Point-to-point ICP, and what its fit must be.
struct IcpConfig {
  double reach = 10.0;
  int max_iterations = 100;
  double max_fitness = 0.7;

  [[nodiscard]] Fields fields();
};

struct PaperFusionConfig {
  place::ScanContextConfig context;
  double max_distance = 0.4;
  int consecutive_hits = 5;
  int num_constraints = 6;
  bool optimize = true;
  int exclude_recent = 50;
  int loop_every = 5;
  int num_around = 5;
  double voxel = 0.4;
  IcpConfig initial{.reach = 200.0, .max_iterations = 100, .max_fitness = 0.6};
  IcpConfig enhanced{.reach = 100.0, .max_iterations = 500, .max_fitness = 2.0};
  IcpConfig loop{.reach = 10.0, .max_iterations = 100, .max_fitness = 0.7};
  double odometry_rotation_variance = 1e-6;
  double odometry_position_variance = 1e-4;
  double closure_variance = 2e-4;

  [[nodiscard]] Fields fields();
};

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// The whole configuration of a run: the configs of its parts, nested.

#include <string>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/mapping/mapping_config.hpp"
#include "mmlins/odometry/odometry_config.hpp"

namespace mmlins::pipeline {

struct OutputConfig {
  double map_voxel = 0.2;

  [[nodiscard]] Fields fields() {
    return {field("map_voxel", map_voxel, "m", {0.01, 10.0}, "map.pcd holds one point per cell of this edge")};
  }
};

struct SlamConfig {
  odometry::OdometryConfig odometry;
  mapping::MappingConfig mapping;
  OutputConfig output;

  [[nodiscard]] Fields fields() {
    return {group("odometry", odometry, "LiDAR-inertial odometry"), group("mapping", mapping, "the back end: places, loops, maps"),
            group("output", output, "files of a run")};
  }
};

/// Checks what the ranges of single fields cannot: values that must be in order.
/// @param source  what to call the configuration in the message: its file name
[[nodiscard]] Status validate(const SlamConfig& config, const std::string& source);

}  // namespace mmlins::pipeline

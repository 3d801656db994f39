// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/config.hpp"

namespace mmlins::pipeline {

Status validate(const SlamConfig& config, const std::string& source) {
  const odometry::ScanConfig& scan = config.odometry.scan;
  if (scan.min_leaf > scan.max_leaf) {
    return make_error(ErrorCode::kInvalid,
                      "{}: odometry.scan.min_leaf ({} m) must not be above odometry.scan.max_leaf ({} m)", source,
                      scan.min_leaf, scan.max_leaf);
  }
  const spatial::PlaneMapConfig& planes = config.odometry.map.planes;
  if (planes.min_points > planes.max_points) {
    return make_error(ErrorCode::kInvalid,
                      "{}: odometry.map.planes.min_points ({}) must not be above odometry.map.planes.max_points ({})",
                      source, planes.min_points, planes.max_points);
  }
  return {};
}

}  // namespace mmlins::pipeline

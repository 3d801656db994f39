// SPDX-License-Identifier: MIT
#pragma once
// What the odometry hands to the threads beside it, in this order: a map begins, its keyframes and bridges,
// it ends.

#include <variant>

#include "mmlins/keyframe/keyframe.hpp"
#include "mmlins/mapping/map_graph.hpp"
#include "mmlins/odometry/map_record.hpp"

namespace mmlins::pipeline {

struct BeginOfMap {
  mapping::MapBegin begin;
  odometry::MapRecord record;
};
struct EndOfMap {
  odometry::MapRecord record;
};
struct NewKeyframe {
  keyframe::KeyframePointer keyframe;
  math::Matrix6d pose_covariance = math::Matrix6d::Zero();  ///< against its map, in T Exp(e)
};
/// The IMU alone carried the pose from the keyframe before to the next.
struct Bridge {
  math::Matrix6d covariance = math::Matrix6d::Zero();  ///< of what it carried, in T Exp(e)
};
using MappingTask = std::variant<BeginOfMap, NewKeyframe, Bridge, EndOfMap>;

}  // namespace mmlins::pipeline

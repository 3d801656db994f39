// SPDX-License-Identifier: MIT
#pragma once
// Writes down what the odometry hands on, at once, and what the back end makes of it, when that is known:
// whenever the process dies, the atlas holds the maps as they were a moment before.

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/mapping/mapping_config.hpp"
#include "mmlins/pipeline/mapper_journal.hpp"
#include "mmlins/pipeline/mapping_task.hpp"

namespace mmlins::pipeline {

class AtlasRecorder {
 public:
  /// @param atlas  must outlive the recorder
  AtlasRecorder(const mapping::MappingConfig& config, atlas::Atlas& atlas)
      : atlas_(atlas), odometry_(config.link, config.optimizer) {}

  [[nodiscard]] Status write(const MappingTask& task);
  /// @pre what the mapper knew was written before
  [[nodiscard]] Status write(MapperChange change);
  [[nodiscard]] Status commit() { return atlas_.commit(); }

 private:
  [[nodiscard]] Status begin_map(const BeginOfMap& task);
  [[nodiscard]] Status add(const NewKeyframe& task);
  [[nodiscard]] Status end_map(const odometry::MapRecord& map);
  /// Gravity of the first so many factors, which will not change any more.
  [[nodiscard]] Status add_gravity(std::size_t end);
  /// Moves what the mapper did not know yet along with what it moved.
  void take_along(MapperChange& change);

  atlas::Atlas& atlas_;
  mapping::MapGraph odometry_;  ///< what the odometry says, without closures
  std::size_t num_edges_ = 0;   ///< of it, in the atlas
  std::size_t num_gravity_ = 0;
  int lost_ = -1;       ///< the last keyframe that could not be written
  int moved_map_ = -1;  ///< was moved within itself, and keyframes to come with it
  math::SE3 T_moved_map_;
  math::SE3 T_moved_world_;  ///< moves maps to come
};

}  // namespace mmlins::pipeline

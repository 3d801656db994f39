// SPDX-License-Identifier: MIT
#pragma once
// Writes down what the back end knows, as it comes to know it: whenever the process dies, the atlas holds the maps as
// they were a moment before.

#include <cstdint>
#include <string>
#include <vector>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/odometry/map_record.hpp"

namespace mmlins::pipeline {

class AtlasRecorder {
 public:
  /// @param atlas  must outlive the recorder
  explicit AtlasRecorder(atlas::Atlas& atlas) : atlas_(atlas) {}

  [[nodiscard]] Status begin_map(const odometry::MapRecord& map, const mapping::BackEndMapper& mapper);
  /// What the mapper has added or changed since the last time. Its keyframes must be in the atlas.
  [[nodiscard]] Status follow(const mapping::BackEndMapper& mapper);
  [[nodiscard]] Status end_map(const odometry::MapRecord& map, const mapping::BackEndMapper& mapper);

 private:
  [[nodiscard]] Status add_edges(const mapping::BackEndMapper& mapper);
  [[nodiscard]] Status add_places(const mapping::BackEndMapper& mapper);
  [[nodiscard]] Status place_latest(const mapping::BackEndMapper& mapper);
  [[nodiscard]] Status write_change(const mapping::BackEndMapper& mapper);
  /// Those that the graph has no longer.
  [[nodiscard]] std::vector<atlas::EdgeWeight> forget_edges(const graph::PoseGraph& graph);
  [[nodiscard]] atlas::GraphChange change_of(const mapping::BackEndMapper& mapper);
  /// Gravity of stretches that are complete.
  [[nodiscard]] Status add_gravity(const mapping::BackEndMapper& mapper, std::size_t end);

  atlas::Atlas& atlas_;
  std::vector<std::int64_t> edge_ids_;  ///< in the atlas, of the edges of the graph that are there
  std::vector<graph::Edge> edges_;      ///< these themselves
  std::vector<double> weights_;         ///< and their weights, as they are there
  std::vector<int> merge_ids_;          ///< in the atlas, of the merges of the mapper
  std::vector<bool> merge_stands_;      ///< there
  std::size_t num_places_ = 0;
  std::size_t num_gravity_ = 0;
  std::size_t num_keyframes_ = 0;
  int revision_ = 0;
};

}  // namespace mmlins::pipeline

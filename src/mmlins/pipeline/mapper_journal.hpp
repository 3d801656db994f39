// SPDX-License-Identifier: MIT
#pragma once
// Tells what the back end has come to know since the last time, as rows for the atlas. It gives them their
// ids itself: they are the same whenever they are written.

#include <cstdint>
#include <vector>

#include "mmlins/atlas/rows.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"

namespace mmlins::pipeline {

/// The ids of edges that are closures begin here; those of the odometry and of gaps are the id of their later
/// keyframe.
inline constexpr std::int64_t kFirstClosureEdge = 1'000'000'000;

struct MapperChange {
  std::vector<atlas::PlaceRow> places;
  atlas::GraphChange graph;
  /// Something was moved: poses are those of all keyframes that the mapper knew. Else of new ones.
  bool has_moved = false;

  [[nodiscard]] bool is_empty() const;
};

class MapperJournal {
 public:
  /// What the mapper has added or changed since the last time, but for what follows from the odometry alone.
  [[nodiscard]] MapperChange take(const mapping::BackEndMapper& mapper);

 private:
  struct Closed {
    std::int64_t id = 0;
    graph::Edge edge;
    double weight = 1.0;
  };
  void add_places(const mapping::BackEndMapper& mapper, MapperChange& change);
  void add_edges(const mapping::BackEndMapper& mapper, bool has_changed, MapperChange& change);
  void add_poses(const mapping::BackEndMapper& mapper, MapperChange& change);
  void add_merges(const mapping::BackEndMapper& mapper, MapperChange& change);

  std::vector<Closed> closed_;  ///< the closures that are edges of the graph, as the atlas has them
  std::int64_t next_edge_ = kFirstClosureEdge;
  std::vector<bool> merge_stands_;  ///< of each merge of the mapper, in the atlas
  std::size_t num_places_ = 0;
  std::size_t num_keyframes_ = 0;
  std::size_t num_maps_ = 0;
  int revision_ = 0;
  bool was_moved_ = false;  ///< the atlas has poses from the mapper
};

}  // namespace mmlins::pipeline

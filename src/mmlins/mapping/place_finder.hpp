// SPDX-License-Identifier: MIT
#pragma once
// Which submaps might show the same place as a new one, and where it might lie in them: those that the graph
// predicts nearby, and those that look alike.

#include <optional>
#include <vector>

#include "mmlins/mapping/map_graph.hpp"
#include "mmlins/mapping/submap_library.hpp"
#include "mmlins/place/place_database.hpp"

namespace mmlins::mapping {

struct PlaceCandidate {
  std::size_t index = 0;  ///< in the library
  ClosureOrigin origin = ClosureOrigin::kPredicted;
  double score = 0.0;
  std::vector<math::SE3> starts;  ///< guesses of T_target_source, both frames being those of the submaps
  std::optional<registration::PosePrior> prior;
};

struct FinderTimes {
  double describe_ms = 0.0;
  double query_ms = 0.0;
  double search_ms = 0.0;
};

class PlaceFinder {
 public:
  PlaceFinder(const MappingConfig& config, const MapGraph& graph, SubmapLibrary& library);

  /// Makes a submap that the library holds findable by its looks.
  void add(const SubmapRecord& record, place::PlaceDescriptor descriptor);
  [[nodiscard]] place::PlaceDescriptor describe(const keyframe::Submap& submap);

  /// Submaps that should be near, nearest first.
  [[nodiscard]] std::vector<PlaceCandidate> predicted(const SubmapRecord& source, const keyframe::Submap& submap);
  /// Submaps that look alike, best first.
  [[nodiscard]] std::vector<PlaceCandidate> recognised(const SubmapRecord& source, const place::PlaceDescriptor& descriptor);

  [[nodiscard]] const FinderTimes& times() const { return times_; }

 private:
  [[nodiscard]] bool may_be_met_again(const SubmapRecord& source, const SubmapRecord& target) const;
  [[nodiscard]] std::optional<PlaceCandidate> around(const SubmapRecord& source, const keyframe::Submap& submap,
                                                     std::size_t index, const registration::PosePrior& prior);
  [[nodiscard]] std::size_t index_of(int submap_id) const;

  MappingConfig config_;
  const MapGraph& graph_;
  SubmapLibrary& library_;
  place::PlaceDatabase places_;
  FinderTimes times_;
};

}  // namespace mmlins::mapping

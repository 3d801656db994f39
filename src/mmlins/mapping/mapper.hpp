// SPDX-License-Identifier: MIT
#pragma once
// The back end as it is by default: places are recognised by submaps, loops closed and maps joined when several closures
// agree on it.

#include <vector>

#include "mmlins/keyframe/submap_cutter.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/mapping/consistency.hpp"
#include "mmlins/mapping/place_finder.hpp"

namespace mmlins::mapping {

class Mapper final : public BackEndMapper {
 public:
  /// @param store  where the keyframes are, each before it is added here
  Mapper(const MappingConfig& config, keyframe::KeyframeStore& store);

  void begin_map(const MapBegin& begin) override;
  void add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) override;
  void bridge(const math::Matrix6d& covariance) override;
  void end_map() override;

  [[nodiscard]] const MapGraph& map_graph() const override { return graph_; }
  [[nodiscard]] const std::vector<SubmapRecord>& submaps() const override { return library_.records(); }
  [[nodiscard]] const std::vector<Closure>& closures() const override { return closures_; }
  [[nodiscard]] const std::vector<Merge>& merges() const override { return merges_; }
  [[nodiscard]] int revision() const override { return revision_; }
  [[nodiscard]] MapperTimes times() const override;

 private:
  /// A submap that looks for known places.
  struct View {
    SubmapRecord record;
    LoadedSubmapPointer loaded;
  };
  void look_around(const keyframe::Keyframes& keyframes, bool is_complete);
  [[nodiscard]] bool probe_is_due() const;
  [[nodiscard]] bool is_alone(int map) const;
  void find_known_places(const View& view, const place::PlaceDescriptor& descriptor);
  /// Verifies a candidate and files the verdict.
  /// @return its closure; none if the points of the target cannot be read
  Closure* examine(const View& view, const PlaceCandidate& candidate);
  /// Whether two maps that were joined hang together by few closures yet.
  [[nodiscard]] bool needs_ties(int map_a, int map_b) const;
  /// Uses a verified closure within a world.
  void use(Closure& closure);
  /// Another closure that puts the robot where this one does, after a stretch that the IMU alone carried.
  [[nodiscard]] Closure* fellow_of(const Closure& closure);
  /// @return false if the graph is better without what was added since `before`; then it is as it was
  bool solve(MapGraph before);
  void try_to_merge(int world_a, int world_b);
  [[nodiscard]] Placement placement_of(const Closure& closure, bool source_moves) const;
  [[nodiscard]] Placement placement_of(const Closure& closure, int world) const {
    return placement_of(closure, graph_.world_of(closure.source_map) == world);
  }
  /// Whether the graph, by gaps too, has the two keyframes about where the closure says.
  [[nodiscard]] bool is_as_predicted(const Closure& closure) const;
  /// Closures of two worlds that lie as `like` has them, but see through each other's walls.
  [[nodiscard]] int num_seen_through(int into, int world, const Placement& like) const;
  /// Merges that have stood so far and put the one end of this closure into the frame of the other.
  [[nodiscard]] std::vector<int> merges_between(const Closure& closure) const;
  /// Whether the merge would be made again, by all that is known now; otherwise it is taken back.
  void review(int merge_id);
  void dissolve(int merge_id, const std::string& why);
  [[nodiscard]] bool commit(Merge merge);
  void enhance(Merge& merge);

  MappingConfig config_;
  MapGraph graph_;
  SubmapLibrary library_;
  PlaceFinder finder_;
  keyframe::SubmapCutter cutter_;
  std::vector<Closure> closures_;
  std::vector<Merge> merges_;
  MapperTimes times_;
  Time now_;
  int revision_ = 0;
  int latest_map_ = -1;
  std::size_t num_probes_ = 0;  ///< of the latest map
  double map_begins_at_ = 0.0;  ///< odometer [m]
  double quiet_until_ = 0.0;    ///< odometer at which loops are sought again [m]
};

}  // namespace mmlins::mapping

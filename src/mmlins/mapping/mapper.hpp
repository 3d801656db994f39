// SPDX-License-Identifier: MIT
#pragma once
// The back end as it is by default: places are recognised by submaps, loops closed and maps joined when several closures
// agree on it.

#include <string>
#include <vector>

#include "mmlins/keyframe/submap_cutter.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/mapping/place_finder.hpp"
#include "mmlins/mapping/world_merger.hpp"

namespace mmlins::mapping {

class Mapper final : public BackEndMapper {
 public:
  /// @param store  where the keyframes are, each before it is added here
  Mapper(const MappingConfig& config, keyframe::KeyframeStore& store);

  void begin_map(const MapBegin& begin) override;
  void add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) override;
  void bridge(const math::Matrix6d& covariance) override;
  void end_map() override;

  [[nodiscard]] const MapGraph& map_graph() const override { return worlds_.graph; }
  [[nodiscard]] const std::vector<SubmapRecord>& submaps() const override { return library_.records(); }
  [[nodiscard]] const std::vector<Closure>& closures() const override { return worlds_.closures; }
  [[nodiscard]] const std::vector<Merge>& merges() const override { return worlds_.merges; }
  [[nodiscard]] int revision() const override { return worlds_.revision; }
  [[nodiscard]] MapperTimes times() const override;
  [[nodiscard]] std::string error() const override { return worlds_.error; }

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
  /// Ties the maps of a merge by further closures, and files it.
  void file(Merge merge);
  void enhance(Merge& merge);

  MappingConfig config_;
  Worlds worlds_;
  WorldMerger merger_;
  SubmapLibrary library_;
  PlaceFinder finder_;
  keyframe::SubmapCutter cutter_;
  MapperTimes times_;
  int latest_map_ = -1;
  std::size_t num_probes_ = 0;  ///< of the latest map
  double map_begins_at_ = 0.0;  ///< odometer [m]
  double quiet_until_ = 0.0;    ///< odometer at which loops are sought again [m]
};

}  // namespace mmlins::mapping

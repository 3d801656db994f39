// SPDX-License-Identifier: MIT
#pragma once
// What every back end does: keyframes go in, in order; where each of them lies in the world comes out, with
// what was recognised on the way. It owns no thread and never talks back to the odometry.

#include <memory>
#include <string>
#include <vector>

#include "mmlins/keyframe/keyframe_store.hpp"
#include "mmlins/mapping/closure.hpp"
#include "mmlins/mapping/map_graph.hpp"
#include "mmlins/mapping/mapping_config.hpp"
#include "mmlins/mapping/submap_library.hpp"

namespace mmlins::mapping {

/// Milliseconds spent so far.
struct MapperTimes {
  double submaps = 0.0;
  double describe = 0.0;
  double recognise = 0.0;
  double search = 0.0;
  double verify = 0.0;
  double optimize = 0.0;
  double fusion = 0.0;  ///< of these: on candidates in other worlds, and on joining them

  [[nodiscard]] double total() const { return submaps + describe + recognise + search + verify + optimize; }
};

class BackEndMapper {
 public:
  BackEndMapper() = default;
  virtual ~BackEndMapper() = default;
  BackEndMapper(const BackEndMapper&) = delete;
  BackEndMapper& operator=(const BackEndMapper&) = delete;

  /// @pre maps come in the order of their ids, which begin at 0
  virtual void begin_map(const MapBegin& begin) = 0;
  /// @param pose_covariance  of the pose against its map, in T Exp(e)
  /// @pre keyframes come in the order of their ids, which begin at 0, and belong to the latest map
  virtual void add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) = 0;
  /// From the latest keyframe to the next one of the same map the IMU alone carries the pose, and the map is found again
  /// where that ends: perhaps in the wrong place.
  /// @param covariance  of what it carried, in T Exp(e)
  virtual void bridge(const math::Matrix6d& covariance) = 0;
  /// The latest map falls asleep, or the recording ends: nothing more of it will come.
  virtual void end_map() = 0;

  [[nodiscard]] virtual const MapGraph& map_graph() const = 0;
  [[nodiscard]] virtual const std::vector<SubmapRecord>& submaps() const = 0;
  [[nodiscard]] virtual const std::vector<Closure>& closures() const = 0;
  [[nodiscard]] virtual const std::vector<Merge>& merges() const = 0;
  /// Rises whenever keyframes have been moved.
  [[nodiscard]] virtual int revision() const = 0;
  [[nodiscard]] virtual MapperTimes times() const = 0;
  /// Why the pose graph could not be optimised, the first time; empty if it always could.
  [[nodiscard]] virtual std::string error() const = 0;
};

/// The back end that the configuration names.
/// @param store  where the keyframes are, each before it is added
[[nodiscard]] std::unique_ptr<BackEndMapper> make_mapper(const MappingConfig& config,
                                                         keyframe::KeyframeStore& store);

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// Runs the mapper beside the odometry, in a thread of its own. What is handed in is worked off in order, so that the
// result does not depend on who was faster.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <variant>

#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/pipeline/atlas_recorder.hpp"

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

class BackEnd {
 public:
  /// @param atlas  where the maps are written as they grow, and points are kept that memory has no room for; none:
  ///   everything stays in memory. It must outlive the back end, and is its own until finish() has returned.
  BackEnd(const mapping::MappingConfig& config, atlas::Atlas* atlas);
  ~BackEnd();
  BackEnd(const BackEnd&) = delete;
  BackEnd& operator=(const BackEnd&) = delete;

  /// Hands in a task; waits only if very many are waiting already, so that memory stays bounded.
  void add(MappingTask task);
  /// Waits until all is done; nothing may be added afterwards.
  void finish();

  /// @pre finish() has returned
  [[nodiscard]] const mapping::BackEndMapper& mapper() const { return *mapper_; }
  [[nodiscard]] keyframe::KeyframeStore& store() { return *store_; }
  /// The first error of the store or the atlas; empty if there was none. @pre finish() has returned
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  void work();
  void perform(const MappingTask& task);
  void note(const Status& status);

  std::unique_ptr<keyframe::KeyframeStore> store_;
  std::optional<AtlasRecorder> recorder_;
  std::unique_ptr<mapping::BackEndMapper> mapper_;
  std::string error_;
  std::mutex mutex_;  ///< guards what follows; never held while working
  std::condition_variable changed_;
  std::deque<MappingTask> waiting_;
  bool no_more_ = false;
  std::thread worker_;  ///< last: it uses all of the above
};

}  // namespace mmlins::pipeline

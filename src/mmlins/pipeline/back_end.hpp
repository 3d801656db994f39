// SPDX-License-Identifier: MIT
#pragma once
// Runs the mapper beside the odometry, in a thread of its own, and the storage in another. What is handed in
// is worked off in order, so that the result does not depend on who was faster.

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/pipeline/map_rebuilder.hpp"
#include "mmlins/pipeline/mapping_task.hpp"
#include "mmlins/pipeline/storage.hpp"
#include "mmlins/pipeline/task_queue.hpp"

namespace mmlins::pipeline {

class BackEnd {
 public:
  using MakeMapper = std::function<std::unique_ptr<mapping::BackEndMapper>(const mapping::MappingConfig&,
                                                                           keyframe::KeyframeStore&)>;

  /// @param atlas  where the maps are written as they grow, and points are kept that memory has no room for.
  ///   It must outlive the back end, and is its own until finish() has returned. None: all stays in memory
  /// @param rebuilder  what the odometry gets back; none: nothing
  BackEnd(const mapping::MappingConfig& config, atlas::Atlas* atlas,
          const MakeMapper& make_mapper = mapping::make_mapper,
          std::optional<MapRebuilder> rebuilder = std::nullopt);
  ~BackEnd();
  BackEnd(const BackEnd&) = delete;
  BackEnd& operator=(const BackEnd&) = delete;

  /// Hands in a task; waits only if very many are waiting already, so that memory stays bounded.
  void add(MappingTask task);
  /// The local map that this keyframe gave rise to, if it did. Waits until the keyframe is worked off: the
  /// answer does not depend on who was faster. @pre it has been handed in, as have been those asked for before
  [[nodiscard]] std::optional<odometry::RebuiltMap> rebuilt_after(int keyframe);
  /// Waits until all is done; nothing may be added afterwards.
  void finish();

  /// @pre finish() has returned
  [[nodiscard]] const mapping::BackEndMapper& mapper() const { return *mapper_; }
  /// Whoever has it may free its memory, which the map of a long run needs. @pre finish() has returned
  [[nodiscard]] std::unique_ptr<mapping::BackEndMapper> take_mapper() { return std::move(mapper_); }
  [[nodiscard]] keyframe::KeyframeStore& store() { return *store_; }
  /// Spent on local maps for the odometry. @pre finish() has returned
  [[nodiscard]] double rebuild_ms() const { return rebuilder_ ? rebuilder_->milliseconds() : 0.0; }
  /// The first error of the store, the pose graph or the atlas; empty if there was none. @pre finish() has returned
  [[nodiscard]] std::string error() const;

 private:
  [[nodiscard]] std::unique_ptr<keyframe::KeyframeStore> make_store(const mapping::MappingConfig& config);
  void work();
  void perform(const MappingTask& task);
  void hand_back(const keyframe::Keyframe& keyframe);
  void note(const Status& status);
  void note_fault_of_graph();

  std::optional<Storage> storage_;
  std::optional<atlas::Atlas> reader_;  ///< of the atlas that the storage writes
  std::string error_;
  std::unique_ptr<keyframe::KeyframeStore> store_;
  std::unique_ptr<mapping::BackEndMapper> mapper_;
  MapperJournal journal_;
  std::optional<MapRebuilder> rebuilder_;
  std::mutex mutex_;  ///< guards what follows
  std::condition_variable worked_off_;
  int num_keyframes_done_ = 0;
  std::map<int, odometry::RebuiltMap> rebuilt_;  ///< by keyframe, until asked for
  TaskQueue<MappingTask> tasks_;
  std::thread worker_;  ///< last: it uses all of the above
};

}  // namespace mmlins::pipeline

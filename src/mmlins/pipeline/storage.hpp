// SPDX-License-Identifier: MIT
#pragma once
// Writes the atlas in a thread of its own, so that nothing that takes long keeps keyframes from the disk.
// Tasks are worked off in order; what comes of them is the same whoever was faster.

#include <mutex>
#include <string>
#include <thread>
#include <unordered_set>
#include <variant>
#include <vector>

#include "mmlins/pipeline/atlas_recorder.hpp"
#include "mmlins/pipeline/task_queue.hpp"

namespace mmlins::pipeline {

class Storage {
 public:
  /// @param atlas  must outlive the storage, and is its own until finish() has returned
  Storage(const mapping::MappingConfig& config, atlas::Atlas& atlas);
  ~Storage();
  Storage(const Storage&) = delete;
  Storage& operator=(const Storage&) = delete;

  /// From any thread; what is added about a keyframe comes after it. Waits only if very many tasks are
  /// waiting already.
  void add(const MappingTask& task) { tasks_.push(task); }
  void add(MapperChange change) { tasks_.push(std::move(change)); }
  /// Waits until all is written; nothing may be added afterwards.
  void finish();

  /// Whether a keyframe can be read from the atlas: never, if it could not be written. From any thread.
  [[nodiscard]] bool is_on_disk(int keyframe) const;
  /// The first error; empty if there was none. @pre finish() has returned
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  using Task = std::variant<MappingTask, MapperChange>;
  void work();
  void remember(const std::vector<int>& keyframes);
  /// @return whether all is well
  bool note(const Status& status);

  AtlasRecorder recorder_;
  std::string error_;
  mutable std::mutex mutex_;         ///< guards what follows
  std::unordered_set<int> on_disk_;  ///< keyframes
  TaskQueue<Task> tasks_;
  std::thread worker_;  ///< last: it uses all of the above
};

}  // namespace mmlins::pipeline

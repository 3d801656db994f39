// SPDX-License-Identifier: MIT
#pragma once
// Writes the atlas in a thread of its own, so that nothing that takes long keeps keyframes from the disk.
// Tasks are worked off in order; what comes of them is the same whoever was faster.

#include <atomic>
#include <string>
#include <thread>
#include <variant>

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

  /// Whether a keyframe is on the disk, or could not be written. From any thread
  [[nodiscard]] bool is_done_with(int keyframe) const { return keyframe < num_done_.load(); }
  /// The first error; empty if there was none. @pre finish() has returned
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  using Task = std::variant<MappingTask, MapperChange>;
  void work();
  void note(const Status& status);

  AtlasRecorder recorder_;
  std::string error_;
  std::atomic<int> num_done_ = 0;  ///< keyframes
  TaskQueue<Task> tasks_;
  std::thread worker_;  ///< last: it uses all of the above
};

}  // namespace mmlins::pipeline

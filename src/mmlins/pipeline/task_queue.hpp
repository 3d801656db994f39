// SPDX-License-Identifier: MIT
#pragma once
// Hands tasks from threads to one other thread, in order. All that threads share lies here.

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

namespace mmlins::pipeline {

template <typename Task>
class TaskQueue {
 public:
  /// @param most  tasks that may wait, so that memory stays bounded
  explicit TaskQueue(std::size_t most) : most_(most) {}

  /// Waits while the queue is full.
  void push(Task task) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return waiting_.size() < most_; });
    waiting_.push_back(std::move(task));
    changed_.notify_all();
  }
  /// Waits for a task. @return none when the queue is closed and empty
  [[nodiscard]] std::optional<Task> pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    if (waiting_.empty()) return std::nullopt;
    std::optional<Task> task(std::move(waiting_.front()));
    waiting_.pop_front();
    changed_.notify_all();
    return task;
  }
  [[nodiscard]] bool is_empty() {
    const std::lock_guard lock(mutex_);
    return waiting_.empty();
  }
  /// Nothing may be pushed afterwards.
  void close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    changed_.notify_all();
  }

 private:
  std::size_t most_;
  std::mutex mutex_;  ///< guards what follows; never held while working
  std::condition_variable changed_;
  std::deque<Task> waiting_;
  bool closed_ = false;
};

}  // namespace mmlins::pipeline

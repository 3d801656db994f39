// SPDX-License-Identifier: MIT
#pragma once
// Runs the mapper beside the odometry, in a thread of its own. What is handed in is worked off in order, so that the
// result does not depend on who was faster.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <variant>

#include "mmlins/mapping/back_end_mapper.hpp"

namespace mmlins::pipeline {

struct EndOfMap {};
struct NewKeyframe {
  keyframe::KeyframePointer keyframe;
  math::Matrix6d pose_covariance = math::Matrix6d::Zero();  ///< against its map, in T Exp(e)
};
using MappingTask = std::variant<mapping::MapBegin, NewKeyframe, EndOfMap>;

class BackEnd {
 public:
  BackEnd(const mapping::MappingConfig& config, std::unique_ptr<keyframe::KeyframeStore> store);
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
  /// The first error of the store; empty if there was none. @pre finish() has returned
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  void work();
  void perform(const MappingTask& task);

  std::unique_ptr<keyframe::KeyframeStore> store_;
  std::unique_ptr<mapping::BackEndMapper> mapper_;
  std::string error_;
  std::mutex mutex_;  ///< guards what follows; never held while working
  std::condition_variable changed_;
  std::deque<MappingTask> waiting_;
  bool no_more_ = false;
  std::thread worker_;  ///< last: it uses all of the above
};

}  // namespace mmlins::pipeline

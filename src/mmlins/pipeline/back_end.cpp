// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/back_end.hpp"

#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::pipeline {
namespace {

/// Keyframes that may wait. A search or an optimisation lasts about as long as some tens of scans.
constexpr std::size_t kMaxWaiting = 64;

}  // namespace

BackEnd::BackEnd(const mapping::MappingConfig& config, std::unique_ptr<keyframe::KeyframeStore> store)
    : store_(std::move(store)), mapper_(mapping::make_mapper(config, *store_)), worker_([this] { work(); }) {}

BackEnd::~BackEnd() { finish(); }

void BackEnd::add(MappingTask task) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return waiting_.size() < kMaxWaiting; });
  waiting_.push_back(std::move(task));
  changed_.notify_all();
}

void BackEnd::finish() {
  {
    const std::lock_guard lock(mutex_);
    no_more_ = true;
    changed_.notify_all();
  }
  if (worker_.joinable()) worker_.join();
}

void BackEnd::work() {
  while (true) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return no_more_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const MappingTask task = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    lock.unlock();
    perform(task);
  }
}

void BackEnd::perform(const MappingTask& task) {
  if (const auto* begin = std::get_if<mapping::MapBegin>(&task)) {
    mapper_->begin_map(*begin);
  } else if (const auto* added = std::get_if<NewKeyframe>(&task)) {
    if (Status status = store_->add(added->keyframe); !status && error_.empty()) {
      error_ = status.error().message;
      log::warning("{}", error_);
    }
    mapper_->add(added->keyframe, added->pose_covariance);
  } else {
    mapper_->end_map();
  }
}

}  // namespace mmlins::pipeline

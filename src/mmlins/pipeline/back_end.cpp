// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/back_end.hpp"

#include <utility>

#include "mmlins/atlas/atlas_keyframe_store.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::pipeline {
namespace {

/// Keyframes that may wait. A search or an optimisation lasts about as long as some tens of scans.
constexpr std::size_t kMaxWaiting = 64;

std::unique_ptr<keyframe::KeyframeStore> make_store(const mapping::MappingConfig& config, atlas::Atlas* atlas) {
  if (!atlas) return std::make_unique<keyframe::MemoryKeyframeStore>();
  constexpr std::size_t kMega = 1'000'000;
  return std::make_unique<atlas::AtlasKeyframeStore>(*atlas, static_cast<std::size_t>(config.memory_mb) * kMega);
}

}  // namespace

BackEnd::BackEnd(const mapping::MappingConfig& config, atlas::Atlas* atlas)
    : store_(make_store(config, atlas)), mapper_(mapping::make_mapper(config, *store_)) {
  if (atlas) recorder_.emplace(*atlas);
  worker_ = std::thread([this] { work(); });
}

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
  if (const auto* begin = std::get_if<BeginOfMap>(&task)) {
    mapper_->begin_map(begin->begin);
    if (recorder_) note(recorder_->begin_map(begin->record, *mapper_));
  } else if (const auto* added = std::get_if<NewKeyframe>(&task)) {
    note(store_->add(added->keyframe));
    mapper_->add(added->keyframe, added->pose_covariance);
    if (recorder_) note(recorder_->follow(*mapper_));
  } else if (const auto* bridge = std::get_if<Bridge>(&task)) {
    mapper_->bridge(bridge->covariance);
    if (recorder_) note(recorder_->follow(*mapper_));
  } else {
    mapper_->end_map();
    if (recorder_) note(recorder_->end_map(std::get<EndOfMap>(task).record, *mapper_));
  }
}

void BackEnd::note(const Status& status) {
  if (status || !error_.empty()) return;
  error_ = status.error().message;
  log::warning("{}", error_);
}

}  // namespace mmlins::pipeline

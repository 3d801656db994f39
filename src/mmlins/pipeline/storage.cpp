// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/storage.hpp"

#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::pipeline {
namespace {

/// Writing a keyframe takes milliseconds; the disk may make all of them wait for a while.
constexpr std::size_t kMaxWaiting = 64;
/// What waits is committed together, up to so many tasks.
constexpr int kMaxTogether = 16;

}  // namespace

Storage::Storage(const mapping::MappingConfig& config, atlas::Atlas& atlas)
    : recorder_(config, atlas), tasks_(kMaxWaiting), worker_([this] { work(); }) {}

Storage::~Storage() { finish(); }

void Storage::finish() {
  tasks_.close();
  if (worker_.joinable()) worker_.join();
}

void Storage::work() {
  int num_written = 0;
  bool is_whole = true;
  std::vector<int> keyframes;  // since the last commit, as is_whole
  while (auto task = tasks_.pop()) {
    if (auto* change = std::get_if<MapperChange>(&*task)) {
      is_whole = note(recorder_.write(std::move(*change))) && is_whole;
    } else {
      const MappingTask& handed_on = std::get<MappingTask>(*task);
      is_whole = note(recorder_.write(handed_on)) && is_whole;
      if (const auto* added = std::get_if<NewKeyframe>(&handed_on)) keyframes.push_back(added->keyframe->id);
    }
    if (++num_written % kMaxTogether != 0 && !tasks_.is_empty()) continue;
    is_whole = note(recorder_.commit()) && is_whole;
    // Where anything failed, the others may have been undone with it.
    if (std::exchange(is_whole, true)) remember(keyframes);
    keyframes.clear();
  }
}

void Storage::remember(const std::vector<int>& keyframes) {
  const std::lock_guard lock(mutex_);
  on_disk_.insert(keyframes.begin(), keyframes.end());
}

bool Storage::is_on_disk(int keyframe) const {
  const std::lock_guard lock(mutex_);
  return on_disk_.contains(keyframe);
}

bool Storage::note(const Status& status) {
  if (status || !error_.empty()) return status.ok();
  error_ = status.error().message;
  log::warning("{}", error_);
  return false;
}

}  // namespace mmlins::pipeline

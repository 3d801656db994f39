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
  int num_written = 0, num_keyframes = 0;
  while (auto task = tasks_.pop()) {
    if (auto* change = std::get_if<MapperChange>(&*task)) {
      note(recorder_.write(std::move(*change)));
    } else {
      const MappingTask& handed_on = std::get<MappingTask>(*task);
      note(recorder_.write(handed_on));
      if (const auto* added = std::get_if<NewKeyframe>(&handed_on)) num_keyframes = added->keyframe->id + 1;
    }
    if (++num_written % kMaxTogether != 0 && !tasks_.is_empty()) continue;
    note(recorder_.commit());
    num_done_ = num_keyframes;
  }
}

void Storage::note(const Status& status) {
  if (status || !error_.empty()) return;
  error_ = status.error().message;
  log::warning("{}", error_);
}

}  // namespace mmlins::pipeline

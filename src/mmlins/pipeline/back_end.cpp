// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/back_end.hpp"

#include <utility>

#include "mmlins/atlas/atlas_keyframe_store.hpp"
#include "mmlins/base/log.hpp"
#include "mmlins/graph/graph_index.hpp"

namespace mmlins::pipeline {
namespace {

/// Keyframes that may wait. A search or an optimisation lasts about as long as some tens of scans.
constexpr std::size_t kMaxWaiting = 64;

}  // namespace

BackEnd::BackEnd(const mapping::MappingConfig& config, atlas::Atlas* atlas, const MakeMapper& make_mapper,
                 std::optional<MapRebuilder> rebuilder)
    : rebuilder_(std::move(rebuilder)), tasks_(kMaxWaiting) {
  if (atlas) {
    if (auto reader = atlas->reader()) {
      reader_.emplace(std::move(*reader));
    } else {
      // The result is worth more than the bound.
      note(make_error(reader.error().code,
                      "all keyframes are kept in memory, beyond mapping.memory_mb, as the atlas cannot be read back: {}",
                      reader.error().message));
    }
    storage_.emplace(config, *atlas);
  }
  store_ = make_store(config);
  mapper_ = make_mapper(config, *store_);
  worker_ = std::thread([this] { work(); });
}

BackEnd::~BackEnd() { finish(); }

std::unique_ptr<keyframe::KeyframeStore> BackEnd::make_store(const mapping::MappingConfig& config) {
  if (!reader_) return std::make_unique<keyframe::MemoryKeyframeStore>();
  constexpr std::size_t kMega = 1'000'000;
  return std::make_unique<atlas::AtlasKeyframeStore>(*reader_,
                                                     static_cast<std::size_t>(config.memory_mb) * kMega,
                                                     [this](int id) { return storage_->is_on_disk(id); });
}

void BackEnd::add(MappingTask task) {
  // The storage first: the mapper may only speak of keyframes that are on their way to the disk.
  if (storage_) storage_->add(task);
  tasks_.push(std::move(task));
}

std::optional<odometry::RebuiltMap> BackEnd::rebuilt_after(int keyframe) {
  if (!rebuilder_) return std::nullopt;
  std::unique_lock lock(mutex_);
  worked_off_.wait(lock, [&] { return num_keyframes_done_ > keyframe; });
  rebuilt_.erase(rebuilt_.begin(), rebuilt_.lower_bound(keyframe));
  auto found = rebuilt_.extract(keyframe);
  if (found.empty()) return std::nullopt;
  return std::move(found.mapped());
}

void BackEnd::hand_back(const keyframe::Keyframe& keyframe) {
  auto rebuilt = rebuilder_->after(keyframe, *mapper_, *store_);
  const std::lock_guard lock(mutex_);
  if (rebuilt) rebuilt_.emplace(keyframe.id, std::move(*rebuilt));
  num_keyframes_done_ = keyframe.id + 1;
  worked_off_.notify_all();
}

void BackEnd::finish() {
  tasks_.close();
  if (worker_.joinable()) {
    worker_.join();
    note_fault_of_graph();
  }
  if (storage_) storage_->finish();
}

std::string BackEnd::error() const { return error_.empty() && storage_ ? storage_->error() : error_; }

void BackEnd::work() {
  while (const auto task = tasks_.pop()) perform(*task);
}

void BackEnd::perform(const MappingTask& task) {
  if (const auto* begin = std::get_if<BeginOfMap>(&task)) {
    mapper_->begin_map(begin->begin);
  } else if (const auto* added = std::get_if<NewKeyframe>(&task)) {
    note(store_->add(added->keyframe));
    mapper_->add(added->keyframe, added->pose_covariance);
    if (rebuilder_) hand_back(*added->keyframe);
  } else if (const auto* bridge = std::get_if<Bridge>(&task)) {
    mapper_->bridge(bridge->covariance);
  } else {
    mapper_->end_map();
  }
  if (!storage_) return;
  if (MapperChange change = journal_.take(*mapper_); !change.is_empty()) storage_->add(std::move(change));
}

void BackEnd::note_fault_of_graph() {
  if (!error_.empty()) return;
  const graph::PoseGraph& graph = mapper_->map_graph().graph();
  std::string fault = mapper_->error();
  // Where nothing was recognised, nothing had to be optimised.
  if (fault.empty() && !graph.nodes.empty()) {
    if (const auto index = graph::index_graph(graph); !index) fault = index.error().message;
  }
  if (!fault.empty()) error_ = fmt::format("the pose graph cannot be optimised: {}", fault);
}

void BackEnd::note(const Status& status) {
  if (status || !error_.empty()) return;
  error_ = status.error().message;
  log::warning("{}", error_);
}

}  // namespace mmlins::pipeline

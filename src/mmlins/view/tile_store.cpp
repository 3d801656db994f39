// SPDX-License-Identifier: MIT
#include "mmlins/view/tile_store.hpp"

#include <optional>

#include "mmlins/base/log.hpp"

namespace mmlins::view {
namespace {

/// More than any block has (blocks.cpp), so that no request takes long.
constexpr int kMaxKeyframes = 4096;
constexpr std::size_t kMaxPoints = 1'000'000;

}  // namespace

TileStore::TileStore(std::shared_ptr<const atlas::Atlas> atlas, std::size_t budget)
    : atlas_(std::move(atlas)), budget_(budget) {}

Result<std::string> TileStore::tile(int first, int last, int level) {
  if (first > last || last - first >= kMaxKeyframes || level < 0 || level >= kNumLevels) {
    return make_error(ErrorCode::kInvalid, "level {} of keyframes {} to {}: cannot be served", level, first,
                      last);
  }
  Tiles tiles = find({first, last});
  if (!tiles) {
    const auto keyframes = load(first, last);
    if (!keyframes) return keyframes.error();
    tiles = std::make_shared<const BlockTiles>(make_tiles(*keyframes, first));
    keep({first, last}, tiles);
  }
  return encode_tile(*tiles, level);
}

TileStore::Tiles TileStore::find(const Key& key) {
  const std::lock_guard lock(mutex_);
  const auto found = index_.find(key);
  if (found == index_.end()) return nullptr;
  recent_.splice(recent_.begin(), recent_, found->second);
  return found->second->tiles;
}

void TileStore::keep(const Key& key, const Tiles& tiles) {
  std::size_t bytes = sizeof(BlockTiles);
  for (const auto& level : tiles->levels) bytes += level.size() * sizeof(TilePoint);
  const std::lock_guard lock(mutex_);
  if (index_.contains(key)) return;
  recent_.push_front({key, tiles, bytes});
  index_[key] = recent_.begin();
  bytes_kept_ += bytes;
  while (bytes_kept_ > budget_ && recent_.size() > 1) {
    bytes_kept_ -= recent_.back().bytes;
    index_.erase(recent_.back().key);
    recent_.pop_back();
  }
}

Result<std::vector<keyframe::KeyframePointer>> TileStore::load(int first, int last) {
  const std::lock_guard lock(atlas_mutex_);
  std::vector<keyframe::KeyframePointer> keyframes;
  std::size_t num_points = 0;
  std::optional<Error> first_loss;
  for (int id = first; id <= last; ++id) {
    auto loaded = atlas_->load_keyframe(id);
    if (!loaded) {  // lost, or of a map that was deleted
      if (!first_loss) first_loss = loaded.error();
      continue;
    }
    num_points += loaded->points_imu.size();
    keyframes.push_back(std::make_shared<keyframe::Keyframe>(std::move(*loaded)));
    if (num_points > kMaxPoints) {
      return make_error(ErrorCode::kInvalid, "keyframes {} to {} are too many for one request", first, last);
    }
  }
  if (keyframes.empty()) return *first_loss;
  if (first_loss) log::warning("{}; the picture is without them", first_loss->message);
  return keyframes;
}

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#include "mmlins/atlas/atlas_keyframe_store.hpp"

namespace mmlins::atlas {

std::size_t size_in_memory(const keyframe::Keyframe& kf) {
  return sizeof(kf) + kf.points_imu.capacity() * sizeof(kf.points_imu[0]) +
         kf.intensities.capacity() * sizeof(kf.intensities[0]);
}

void AtlasKeyframeStore::keep(const keyframe::KeyframePointer& keyframe) {
  recent_.push_front(keyframe);
  index_[keyframe->id] = recent_.begin();
  bytes_kept_ += size_in_memory(*keyframe);
  for (auto one = recent_.end(); bytes_kept_ > budget_ && one != recent_.begin();) {
    --one;
    if (!on_disk_((*one)->id)) continue;
    bytes_kept_ -= size_in_memory(**one);
    index_.erase((*one)->id);
    one = recent_.erase(one);
  }
}

Status AtlasKeyframeStore::add(const keyframe::KeyframePointer& keyframe) {
  if (index_.contains(keyframe->id)) {
    return make_error(ErrorCode::kInvalid, "{}: keyframe {} exists already", atlas_.folder(), keyframe->id);
  }
  keep(keyframe);
  return {};
}

Result<keyframe::KeyframePointer> AtlasKeyframeStore::load(int id) {
  if (const auto found = index_.find(id); found != index_.end()) {
    recent_.splice(recent_.begin(), recent_, found->second);
    return recent_.front();
  }
  auto loaded = atlas_.load_keyframe(id);
  if (!loaded) return loaded.error();
  const auto keyframe = std::make_shared<const keyframe::Keyframe>(std::move(loaded).value());
  keep(keyframe);
  return keyframe::KeyframePointer(keyframe);
}

}  // namespace mmlins::atlas

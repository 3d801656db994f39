// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/keyframe_store.hpp"

namespace mmlins::keyframe {

Status MemoryKeyframeStore::add(const KeyframePointer& keyframe) {
  if (!keyframes_.emplace(keyframe->id, keyframe).second) {
    return make_error(ErrorCode::kInvalid, "keyframe {} exists already", keyframe->id);
  }
  return {};
}

Result<KeyframePointer> MemoryKeyframeStore::load(int id) {
  const auto found = keyframes_.find(id);
  if (found == keyframes_.end()) return make_error(ErrorCode::kInvalid, "there is no keyframe {}", id);
  return found->second;
}

}  // namespace mmlins::keyframe

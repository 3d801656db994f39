// SPDX-License-Identifier: MIT
#include "mmlins/mapping/submap_library.hpp"

#include <algorithm>
#include <utility>

namespace mmlins::mapping {
namespace {

constexpr std::size_t kMaxAtHand = 8;

}  // namespace

LoadedSubmapPointer SubmapLibrary::build(const keyframe::Keyframes& keyframes) const {
  auto loaded = std::make_shared<LoadedSubmap>();
  loaded->submap = keyframe::build_submap(keyframes, submap_config_);
  loaded->prepared = registration::prepare(loaded->submap, registration_config_);
  return loaded;
}

SubmapRecord SubmapLibrary::record_of(const keyframe::Submap& submap, const keyframe::Keyframes& keyframes) {
  const auto is_middle = [&](const keyframe::KeyframePointer& kf) { return kf->id == submap.id; };
  const auto middle = std::find_if(keyframes.begin(), keyframes.end(), is_middle);
  MMLINS_CHECK(middle != keyframes.end());
  return {submap.id, submap.map_id, keyframes.front()->id, keyframes.back()->id,
          (*middle)->T_map_imu.inverse() * submap.T_map_submap, {}};
}

void SubmapLibrary::add(const SubmapRecord& record, LoadedSubmapPointer loaded) {
  records_.push_back(record);
  keep_at_hand(records_.size() - 1, std::move(loaded));
}

Result<LoadedSubmapPointer> SubmapLibrary::load(std::size_t index) {
  const auto found = std::find_if(at_hand_.begin(), at_hand_.end(), [&](const AtHand& one) { return one.index == index; });
  if (found != at_hand_.end()) {
    at_hand_.splice(at_hand_.begin(), at_hand_, found);
    return at_hand_.front().loaded;
  }
  keyframe::Keyframes keyframes;
  for (int id = records_[index].first_keyframe; id <= records_[index].last_keyframe; ++id) {
    auto keyframe = store_.load(id);
    if (!keyframe) return keyframe.error();
    keyframes.push_back(*keyframe);
  }
  LoadedSubmapPointer loaded = build(keyframes);
  keep_at_hand(index, loaded);
  return loaded;
}

void SubmapLibrary::keep_at_hand(std::size_t index, LoadedSubmapPointer loaded) {
  at_hand_.push_front({index, std::move(loaded)});
  if (at_hand_.size() > kMaxAtHand) at_hand_.pop_back();
}

}  // namespace mmlins::mapping

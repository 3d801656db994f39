// SPDX-License-Identifier: MIT
#pragma once
// Keyframes that lie on disk, and as many of them in memory as a budget allows.

#include <cstddef>
#include <list>
#include <unordered_map>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/keyframe/keyframe_store.hpp"

namespace mmlins::atlas {

/// What a keyframe takes in memory [bytes].
[[nodiscard]] std::size_t size_in_memory(const keyframe::Keyframe& keyframe);

/// The answers are the same whatever the budget; only the time that they take is not. For one thread at a
/// time, which is that of the atlas.
class AtlasKeyframeStore final : public keyframe::KeyframeStore {
 public:
  /// @param atlas   must outlive the store
  /// @param budget  of what the store keeps; keyframes that somebody still uses come on top [bytes]
  AtlasKeyframeStore(Atlas& atlas, std::size_t budget) : atlas_(atlas), budget_(budget) {}

  [[nodiscard]] Status add(const keyframe::KeyframePointer& keyframe) override;
  [[nodiscard]] Result<keyframe::KeyframePointer> load(int id) override;

  [[nodiscard]] std::size_t bytes_kept() const { return bytes_kept_; }

 private:
  void keep(const keyframe::KeyframePointer& keyframe);

  using Recent = std::list<keyframe::KeyframePointer>;

  Atlas& atlas_;
  std::size_t budget_;
  std::size_t bytes_kept_ = 0;
  Recent recent_;  ///< the one used last first
  std::unordered_map<int, Recent::iterator> index_;
};

}  // namespace mmlins::atlas

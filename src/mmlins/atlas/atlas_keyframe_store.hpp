// SPDX-License-Identifier: MIT
#pragma once
// Keyframes that lie on disk, and as many of them in memory as a budget allows.

#include <cstddef>
#include <functional>
#include <list>
#include <unordered_map>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/keyframe/keyframe_store.hpp"

namespace mmlins::atlas {

/// What a keyframe takes in memory [bytes].
[[nodiscard]] std::size_t size_in_memory(const keyframe::Keyframe& keyframe);

/// The answers are the same whatever the budget; only the time that they take is not. Somebody else writes
/// the keyframes. For one thread at a time, which is that of the atlas it reads from.
class AtlasKeyframeStore final : public keyframe::KeyframeStore {
 public:
  /// @param atlas    must outlive the store
  /// @param budget   of what the store keeps; keyframes that somebody still uses, or that are not on disk
  ///   yet or never will be, come on top [bytes]
  /// @param on_disk  whether the keyframe of an id can be read from the atlas by now
  AtlasKeyframeStore(const Atlas& atlas, std::size_t budget, std::function<bool(int id)> on_disk)
      : atlas_(atlas), budget_(budget), on_disk_(std::move(on_disk)) {}

  [[nodiscard]] Status add(const keyframe::KeyframePointer& keyframe) override;
  [[nodiscard]] Result<keyframe::KeyframePointer> load(int id) override;

  [[nodiscard]] std::size_t bytes_kept() const { return bytes_kept_; }

 private:
  void keep(const keyframe::KeyframePointer& keyframe);

  using Recent = std::list<keyframe::KeyframePointer>;

  const Atlas& atlas_;
  std::size_t budget_;
  std::function<bool(int id)> on_disk_;
  std::size_t bytes_kept_ = 0;
  Recent recent_;  ///< the one used last first
  std::unordered_map<int, Recent::iterator> index_;
};

}  // namespace mmlins::atlas

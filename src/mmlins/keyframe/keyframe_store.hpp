// SPDX-License-Identifier: MIT
#pragma once
// Where keyframes are kept once they are made. Points are the bulk of a map: whoever needs them asks for a keyframe,
// uses it and lets it go; the store decides what stays in memory.

#include <unordered_map>

#include "mmlins/base/result.hpp"
#include "mmlins/keyframe/keyframe.hpp"

namespace mmlins::keyframe {

class KeyframeStore {
 public:
  virtual ~KeyframeStore() = default;

  /// @return an error if the id is taken or the keyframe cannot be written
  [[nodiscard]] virtual Status add(const KeyframePointer& keyframe) = 0;
  /// @return the keyframe as it was added, pose included; an error if there is none or it cannot be read
  [[nodiscard]] virtual Result<KeyframePointer> load(int id) = 0;
};

/// Keeps everything in memory.
class MemoryKeyframeStore final : public KeyframeStore {
 public:
  [[nodiscard]] Status add(const KeyframePointer& keyframe) override;
  [[nodiscard]] Result<KeyframePointer> load(int id) override;

 private:
  std::unordered_map<int, KeyframePointer> keyframes_;
};

}  // namespace mmlins::keyframe

// SPDX-License-Identifier: MIT
#pragma once
// Cuts a growing row of keyframes into submaps as it grows; the same cuts as split_by_travel().

#include <optional>

#include "mmlins/keyframe/submap.hpp"

namespace mmlins::keyframe {

class SubmapCutter {
 public:
  explicit SubmapCutter(const SubmapConfig& config) : config_(config) {}

  /// @pre the keyframe belongs to the map of the one before, or finish() was called
  /// @return the keyframes of a submap that is complete now
  [[nodiscard]] std::optional<Keyframes> add(KeyframePointer keyframe);
  /// @return what is left over at the end of a map, if any of it has not been returned yet
  [[nodiscard]] std::optional<Keyframes> finish();

  /// Keyframes since the middle of the last submap.
  [[nodiscard]] const Keyframes& pending() const { return pending_; }

 private:
  SubmapConfig config_;
  Keyframes pending_;
  std::size_t num_returned_ = 0;  ///< of the pending, those that are part of a submap already
};

}  // namespace mmlins::keyframe

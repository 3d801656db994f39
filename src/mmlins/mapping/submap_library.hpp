// SPDX-License-Identifier: MIT
#pragma once
// All submaps so far. What stays in memory of each is small; its points are put together again from its keyframes
// when they are needed, and a few stay at hand.

#include <list>
#include <memory>
#include <vector>

#include "mmlins/keyframe/keyframe_store.hpp"
#include "mmlins/keyframe/submap.hpp"
#include "mmlins/place/place_descriptor.hpp"
#include "mmlins/registration/register_submaps.hpp"

namespace mmlins::mapping {

/// What is known of a submap without its points.
struct SubmapRecord {
  int id = 0;  ///< that of its middle keyframe
  int map_id = 0;
  int first_keyframe = 0;
  int last_keyframe = 0;
  math::SE3 T_keyframe_submap;  ///< from its own frame to that of its middle keyframe
  place::Footprint footprint;   ///< what it looks like, once it is in the library
};

/// A submap with its points, ready to be registered and searched.
struct LoadedSubmap {
  keyframe::Submap submap;
  registration::PreparedSubmap prepared;
};
using LoadedSubmapPointer = std::shared_ptr<const LoadedSubmap>;

class SubmapLibrary {
 public:
  SubmapLibrary(const keyframe::SubmapConfig& submap, const registration::RegistrationConfig& registration,
                keyframe::KeyframeStore& store)
      : submap_config_(submap), registration_config_(registration), store_(store) {}

  [[nodiscard]] LoadedSubmapPointer build(const keyframe::Keyframes& keyframes) const;
  [[nodiscard]] static SubmapRecord record_of(const keyframe::Submap& submap, const keyframe::Keyframes& keyframes);

  void add(const SubmapRecord& record, LoadedSubmapPointer loaded);
  [[nodiscard]] const std::vector<SubmapRecord>& records() const { return records_; }
  /// @return an error if a keyframe cannot be read
  [[nodiscard]] Result<LoadedSubmapPointer> load(std::size_t index);

 private:
  struct AtHand {
    std::size_t index;
    LoadedSubmapPointer loaded;
  };
  void keep_at_hand(std::size_t index, LoadedSubmapPointer loaded);

  keyframe::SubmapConfig submap_config_;
  registration::RegistrationConfig registration_config_;
  keyframe::KeyframeStore& store_;
  std::vector<SubmapRecord> records_;
  std::list<AtHand> at_hand_;  ///< the one used last comes first
};

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// Scan Contexts of single keyframes, and the search for a similar one, as the Scan Context paper has it: ring
// keys choose a few, and these are compared. docs/math/place.md, "The baseline".

#include <functional>
#include <optional>
#include <vector>

#include "mmlins/place/scan_context.hpp"

namespace mmlins::mapping {

/// A keyframe that looks like another.
struct ContextHit {
  int keyframe = 0;       ///< that was found
  double distance = 1.0;  ///< of the two Scan Contexts
  double yaw = 0.0;       ///< of the one that looked, in the one that was found [rad]
};

class ContextIndex {
 public:
  explicit ContextIndex(const place::ScanContextConfig& config) : config_(config) {}

  [[nodiscard]] place::ScanContext describe(std::span<const Eigen::Vector3f> points_imu) const {
    return place::make_scan_context(points_imu, config_);
  }
  void add(int keyframe, place::ScanContext context);

  /// The keyframe most like the query among those that are eligible; none if none is nearer than
  /// `max_distance`.
  [[nodiscard]] std::optional<ContextHit> find(const place::ScanContext& query, double max_distance,
                                               const std::function<bool(int keyframe)>& is_eligible) const;

 private:
  struct Entry {
    int keyframe = 0;
    place::ScanContext context;
  };

  place::ScanContextConfig config_;
  std::vector<Entry> entries_;
};

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#pragma once
// What a place looks like from above, in a form that can be found again: the structure that stands around,
// and its spectrum. The magnitudes of a spectrum do not change when the place is seen from another spot, and
// turn when it is seen in another heading; so the spectrum alone says which places to look at and in which
// headings, and a matched filter then says where. docs/math/place.md.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/keyframe/bird_view.hpp"

namespace mmlins::place {

struct PlaceConfig {
  keyframe::BirdViewConfig view;
  double cell = 1.0;
  int image_size = 128;
  int num_radii = 32;
  int num_angles = 90;
  int num_harmonics = 8;
  int num_compared = 20;
  int num_headings = 2;

  [[nodiscard]] Fields fields();
};

/// A place with something standing on it; small, because a database holds thousands of them for each submap.
struct StructurePoint {
  std::int16_t x_cm = 0;
  std::int16_t y_cm = 0;
  std::uint16_t amount = 0;  ///< 0 to 65535
};

/// What has to be stored of a submap to recognise it; all else is made from it.
struct Footprint {
  std::vector<StructurePoint> structure;
  float ground = 0.0F;  ///< height of the ground around the origin [m]
};

struct PlaceDescriptor {
  Footprint footprint;
  /// radius x angle: logarithm of the magnitude of the spectrum over half a turn; each row has mean 0, the
  /// whole has norm 1.
  Eigen::MatrixXf rose;
  Eigen::VectorXf key;  ///< unit; changes neither by turning nor by shifting
};

[[nodiscard]] Footprint make_footprint(const keyframe::Submap& submap, const PlaceConfig& config);
[[nodiscard]] PlaceDescriptor make_descriptor(Footprint footprint, const PlaceConfig& config);
[[nodiscard]] PlaceDescriptor make_descriptor(const keyframe::Submap& submap, const PlaceConfig& config);

}  // namespace mmlins::place

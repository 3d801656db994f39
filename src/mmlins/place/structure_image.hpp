// SPDX-License-Identifier: MIT
#pragma once
// A footprint as an image, turned by any angle.

#include <vector>

#include "mmlins/place/fft.hpp"
#include "mmlins/place/place_descriptor.hpp"

namespace mmlins::place {

/// The structure of a footprint turned by `yaw` [rad], with its origin in the middle of the image; each point
/// is shared among the four cells around it.
[[nodiscard]] std::vector<float> structure_image(const Footprint& footprint, double yaw,
                                                 const PlaceConfig& config);

/// Images without an imaginary part; two of them fit into one transform.
[[nodiscard]] std::vector<Complex> to_complex(const std::vector<float>& real,
                                              const std::vector<float>& imaginary);

}  // namespace mmlins::place

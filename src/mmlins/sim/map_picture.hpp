// SPDX-License-Identifier: MIT
#pragma once
// A picture of a simulation from above.

#include <string>

#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {

/// What can be seen from the path at the height of the IMU, and the path on it: an SVG file's text. Parts of
/// the path on which an event spoils the LiDAR are red; a green dot is the start, a black one the end.
[[nodiscard]] std::string map_svg(const Simulation& simulation);

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// Finds lanes on which people and cars can move, and when each is where, so that none ever comes near the
// carrier, whose way is known beforehand.

#include <cstdint>
#include <vector>

#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/mover.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

/// How near the body of a mover comes to the carrier, as seen from above [m].
[[nodiscard]] double clearance_of(MoverKind kind);

/// As many movers as the config asks for, or as find a lane; the same for the same config, world and motion.
/// @param still   what stands, in the frame of the scene
/// @param motion  of the carrier, in the frame of the scene
/// @param duration  of the recording [s]
[[nodiscard]] std::vector<Mover> plan_movers(const WorldConfig& config, const World& still,
                                             const Motion& motion, double duration);

}  // namespace mmlins::sim

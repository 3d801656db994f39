// SPDX-License-Identifier: MIT
#pragma once
// Free straight stretches of ground in any world, found by casting rays.

#include <optional>
#include <vector>

#include "mmlins/sim/mover.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

/// Where the carrier is at each tick of the movers [m].
using CarrierPlaces = std::vector<Eigen::Vector3d>;

struct LaneSite {
  const World& still;
  const CarrierPlaces& carrier;
};

/// A lane near the way of the carrier, at a random place and, of cars, along or across that way. Nothing if
/// the place turns out not to be free.
[[nodiscard]] std::optional<Lane> find_lane(MoverKind kind, double cell, const LaneSite& site,
                                            Random& random);

}  // namespace mmlins::sim

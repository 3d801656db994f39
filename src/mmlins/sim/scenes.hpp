// SPDX-License-Identifier: MIT
#pragma once
// The places of the simulator. Each offers a course to travel on and the shapes around it; the seed of the
// world changes sizes, numbers and positions. Coordinates are those of the scene: z = 0 is the ground.

#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

/// A factory hall of about 30 x 20 x 5 m with pillars, machines, shelves and beams.
[[nodiscard]] Polygon hall_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> hall_shapes(const WorldConfig& config, const Polygon& keep_free);

/// City blocks: a figure-of-eight of about half a kilometre between facades, parked cars, poles and trees.
[[nodiscard]] Polygon street_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> street_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A corridor with furnished rooms on both sides, under a low ceiling.
[[nodiscard]] Polygon office_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> office_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A yard of about 70 x 55 m under the open sky: sheds, containers, crates, trees, a wall around.
[[nodiscard]] Polygon yard_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> yard_shapes(const WorldConfig& config, const Polygon& keep_free);

}  // namespace mmlins::sim

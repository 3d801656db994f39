// SPDX-License-Identifier: MIT
#pragma once
// The places of the simulator. Each offers a course to travel on and the shapes around it; the seed of the
// world changes sizes, numbers and positions. Coordinates are those of the scene: z = 0 is the ground.

#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

/// A factory hall of about 30 x 20 x 5 m with pillars, machines, shelves and beams.
[[nodiscard]] Route hall_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> hall_shapes(const WorldConfig& config, const Polygon& keep_free);

/// City blocks: a figure-of-eight of about half a kilometre between facades, parked cars, poles and trees.
[[nodiscard]] Route street_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> street_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A corridor with furnished rooms on both sides, under a low ceiling.
[[nodiscard]] Route office_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> office_shapes(const WorldConfig& config, const Polygon& keep_free);

/// The same on a square of about 700 m, with a tour of about four kilometres that visits some streets again.
[[nodiscard]] Route urban_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> urban_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A yard of about 70 x 55 m under the open sky: sheds, containers, crates, trees, a wall around.
[[nodiscard]] Route yard_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> yard_shapes(const WorldConfig& config, const Polygon& keep_free);

/// Grounds of 170 x 130 m with detached buildings, trees, bushes and parked cars.
[[nodiscard]] Route campus_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> campus_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A ring of nearly bare corridors, about 250 m long.
[[nodiscard]] Route corridor_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> corridor_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A straight road tunnel of about 270 m, with turning places outside both portals.
[[nodiscard]] Route tunnel_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> tunnel_shapes(const WorldConfig& config, const Polygon& keep_free);

/// A meadow with next to nothing on it, and a wood so far away that few sensors see it.
[[nodiscard]] Route field_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> field_shapes(const WorldConfig& config, const Polygon& keep_free);

/// Two identical halls joined by a corridor.
[[nodiscard]] Route decoy_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> decoy_shapes(const WorldConfig& config, const Polygon& keep_free);

/// Three storeys joined by stairs.
[[nodiscard]] Route floors_route(const WorldConfig& config);
[[nodiscard]] std::vector<Shape> floors_shapes(const WorldConfig& config, const Polygon& keep_free);

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// Rows of the index as structs, and back. Internal to atlas/.

#include <optional>

#include "mmlins/atlas/database.hpp"
#include "mmlins/atlas/rows.hpp"

namespace mmlins::atlas {

[[nodiscard]] Bytes pose_bytes(const SE3& T);
[[nodiscard]] Bytes vector_bytes(const Vector3d& v);
[[nodiscard]] Bytes matrix_bytes(const math::Matrix6d& M);
[[nodiscard]] Bytes id_bytes(const std::vector<int>& ids);
[[nodiscard]] Bytes structure_bytes(const place::Footprint& footprint);

/// All columns but the id in their order, and then the id.
Statement& bind_map(Statement& statement, const MapRow& map);

/// The row that the statement, a SELECT *, stands at; nothing if it is damaged.
[[nodiscard]] std::optional<MapRow> read_map(const Statement& row);
[[nodiscard]] std::optional<KeyframeRow> read_keyframe(const Statement& row);
[[nodiscard]] std::optional<EdgeRow> read_edge(const Statement& row);
[[nodiscard]] std::optional<GravityRow> read_gravity(const Statement& row);
[[nodiscard]] std::optional<PlaceRow> read_place(const Statement& row);
[[nodiscard]] std::optional<MergeRow> read_merge(const Statement& row);

}  // namespace mmlins::atlas

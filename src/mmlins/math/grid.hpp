// SPDX-License-Identifier: MIT
#pragma once
// Cells of a cubic grid as one number each, for hash tables.

#include <Eigen/Core>
#include <cstdint>

namespace mmlins::math {

/// Integer coordinates of a cell.
using CellIndex = Eigen::Vector3i;

/// Up to 2^20 cells to either side of the origin; beyond that keys repeat.
inline constexpr int kHalfGrid = 1 << 20;

/// 21 bits for each axis; bit 63 stays free.
[[nodiscard]] inline std::uint64_t cell_key(const CellIndex& index) {
  const auto part = [](int value) { return static_cast<std::uint64_t>(value + kHalfGrid) & 0x1FFFFF; };
  return part(index.x()) << 42 | part(index.y()) << 21 | part(index.z());
}

/// The cell of a key.
[[nodiscard]] inline CellIndex cell_of_key(std::uint64_t key) {
  const auto part = [&](int shift) { return static_cast<int>(key >> shift & 0x1FFFFF) - kHalfGrid; };
  return {part(42), part(21), part(0)};
}

/// Spreads keys over the slots of a table of 2^(64 - shift) entries (Fibonacci hashing).
[[nodiscard]] inline std::size_t hash_slot(std::uint64_t key, int shift) {
  return static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> shift);
}

/// The cell that holds a point, in a grid with `inverse_size` cells per metre.
template <typename Scalar>
[[nodiscard]] CellIndex cell_at(const Eigen::Matrix<Scalar, 3, 1>& point, Scalar inverse_size) {
  return (point * inverse_size).array().floor().matrix().template cast<int>();
}

}  // namespace mmlins::math

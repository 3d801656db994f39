// SPDX-License-Identifier: MIT
#pragma once
// A hash table from grid cells to payloads: open addressing over a dense array, so that walking all
// cells is a walk over memory. Entries are removed only in bulk.

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "mmlins/math/grid.hpp"

namespace mmlins::spatial {

using math::CellIndex;

/// @tparam Container  of the cells: std::deque where there may be millions, since it grows without a copy of all
template <typename Payload, template <typename...> typename Container = std::vector>
class VoxelTable {
 public:
  explicit VoxelTable(double cell_size) : cell_size_(cell_size), inverse_size_(1.0 / cell_size) { rehash(1024); }

  [[nodiscard]] double cell_size() const { return cell_size_; }

  /// The grid is shifted against the origin, so that a floor or wall at a round coordinate does not
  /// run along the faces of the cells.
  [[nodiscard]] CellIndex index_of(const Eigen::Vector3d& point) const {
    return (point.array() * inverse_size_ + kShift).floor().matrix().template cast<int>();
  }
  [[nodiscard]] Eigen::Vector3d centre_of(const CellIndex& index) const {
    return (index.cast<double>().array() + 0.5 - kShift).matrix() * cell_size_;
  }

  /// Position of a cell in payloads(), or -1.
  [[nodiscard]] std::int64_t find(const CellIndex& index) const {
    const std::uint64_t key = math::cell_key(index);
    for (std::size_t slot = slot_of(key);; slot = (slot + 1) & (slots_.size() - 1)) {
      if (slots_[slot] == kEmpty) return -1;
      if (keys_[slots_[slot]] == key) return slots_[slot];
    }
  }

  /// Position of a cell in payloads(); made with a default payload if it was not there.
  std::uint32_t find_or_add(const CellIndex& index) {
    if (4 * (keys_.size() + 1) > 3 * slots_.size()) rehash(2 * slots_.size());
    const std::uint64_t key = math::cell_key(index);
    std::size_t slot = slot_of(key);
    while (slots_[slot] != kEmpty) {
      if (keys_[slots_[slot]] == key) return slots_[slot];
      slot = (slot + 1) & (slots_.size() - 1);
    }
    slots_[slot] = static_cast<std::uint32_t>(keys_.size());
    keys_.push_back(key);
    payloads_.emplace_back();
    return slots_[slot];
  }

  /// Keeps only the cells for which `keep(index, payload)` holds.
  template <typename Keep>
  void keep_if(const Keep& keep) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (!keep(math::cell_of_key(keys_[i]), payloads_[i])) continue;
      keys_[kept] = keys_[i];
      payloads_[kept] = std::move(payloads_[i]);
      ++kept;
    }
    keys_.resize(kept);
    payloads_.resize(kept);
    rehash(std::max<std::size_t>(1024, std::bit_ceil(2 * kept)));
  }

  [[nodiscard]] const Container<Payload>& payloads() const { return payloads_; }
  [[nodiscard]] Container<Payload>& payloads() { return payloads_; }

 private:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;
  static constexpr double kShift = 0.381966;

  [[nodiscard]] std::size_t slot_of(std::uint64_t key) const { return math::hash_slot(key, hash_shift_); }

  void rehash(std::size_t num_slots) {
    slots_.assign(num_slots, kEmpty);
    hash_shift_ = 64 - std::countr_zero(num_slots);
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      std::size_t slot = slot_of(keys_[i]);
      while (slots_[slot] != kEmpty) slot = (slot + 1) & (num_slots - 1);
      slots_[slot] = static_cast<std::uint32_t>(i);
    }
  }

  double cell_size_;
  double inverse_size_;
  int hash_shift_ = 0;
  std::vector<std::uint32_t> slots_;
  Container<std::uint64_t> keys_;
  Container<Payload> payloads_;
};

}  // namespace mmlins::spatial

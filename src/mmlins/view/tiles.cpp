// SPDX-License-Identifier: MIT
#include "mmlins/view/tiles.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace mmlins::view {
namespace {

constexpr std::uint64_t kUsed = std::uint64_t{1} << 63;
constexpr std::uint64_t kIndex = 0xffffffff;

/// A well mixed number for each number, the same everywhere.
std::uint64_t mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Cells that are taken.
class CellSet {
 public:
  explicit CellSet(std::size_t most) : slots_(std::bit_ceil(2 * most + 2), 0) {}
  /// @return false if it was there already
  bool insert(std::uint64_t cell) {
    for (std::size_t at = mix(cell) & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      if (slots_[at] == (cell | kUsed)) return false;
      if (slots_[at] != 0) continue;
      slots_[at] = cell | kUsed;
      return true;
    }
  }

 private:
  std::vector<std::uint64_t> slots_;
};

std::uint64_t cell_of(const math::Vector3d& p, double edge) {
  std::uint64_t cell = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index = static_cast<std::int64_t>(std::floor(p[axis] / edge));
    cell = (cell << 21) | (static_cast<std::uint64_t>(index) & 0x1fffff);
  }
  return cell;
}

struct Placed {
  TilePoint point;
  math::Vector3d p_map;
};

std::vector<Placed> place_all(std::span<const keyframe::KeyframePointer> keyframes, int first_id) {
  std::vector<Placed> all;
  for (const keyframe::KeyframePointer& pointer : keyframes) {
    const keyframe::Keyframe& keyframe = *pointer;
    const int number = keyframe.id - first_id;
    if (number < 0 || number > std::numeric_limits<std::uint16_t>::max()) continue;
    for (std::size_t i = 0; i < keyframe.points_imu.size(); ++i) {
      const Eigen::Vector3f& p_imu = keyframe.points_imu[i];
      Placed placed;
      for (int axis = 0; axis < 3; ++axis) {
        placed.point.p_imu[static_cast<std::size_t>(axis)] =
            static_cast<std::int16_t>(std::lround(p_imu[axis] / keyframe::kPointQuantum));
      }
      placed.point.keyframe = static_cast<std::uint16_t>(number);
      placed.point.intensity = keyframe.intensities.empty() ? std::uint16_t{0} : keyframe.intensities[i];
      placed.p_map = keyframe.T_map_imu * p_imu.cast<double>();
      all.push_back(placed);
    }
  }
  return all;
}

void find_extent(const std::vector<Placed>& all, const math::SE3& T_map_imu, BlockTiles& tiles) {
  if (all.empty()) return;
  math::Vector3d sum = math::Vector3d::Zero();
  for (const Placed& placed : all) sum += placed.p_map;
  const math::Vector3d p_map_centre = sum / static_cast<double>(all.size());
  std::vector<double> distances;
  for (const Placed& placed : all) distances.push_back((placed.p_map - p_map_centre).norm());
  const auto eighty = distances.begin() + static_cast<std::ptrdiff_t>(4 * (distances.size() - 1) / 5);
  std::nth_element(distances.begin(), eighty, distances.end());
  tiles.p_imu_centre = T_map_imu.inverse() * p_map_centre;
  tiles.radius = *eighty;
}

template <typename T>
void append(std::string& bytes, const T& value) {
  static_assert(std::endian::native == std::endian::little);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

}  // namespace

BlockTiles make_tiles(std::span<const keyframe::KeyframePointer> keyframes, int first_id) {
  BlockTiles tiles;
  if (keyframes.empty()) return tiles;
  const std::vector<Placed> all = place_all(keyframes, first_id);
  find_extent(all, keyframes[keyframes.size() / 2]->T_map_imu, tiles);
  // Shuffled: in the order of mixed numbers, whose lower half is replaced by what they stand for.
  std::vector<std::uint64_t> order(all.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = (mix(i + 1) & ~kIndex) | i;
  std::sort(order.begin(), order.end());
  std::vector<CellSet> taken(kNumLevels - 1, CellSet(all.size()));
  for (const std::uint64_t shuffled : order) {
    const std::size_t i = shuffled & kIndex;
    std::size_t level = 0;
    while (level + 1 < kNumLevels && !taken[level].insert(cell_of(all[i].p_map, kLevelCells[level]))) ++level;
    tiles.levels[level].push_back(all[i].point);
  }
  return tiles;
}

std::string encode_tile(const BlockTiles& tiles, int level) {
  const std::vector<TilePoint>& points = tiles.levels[static_cast<std::size_t>(level)];
  std::string bytes = "MMT1";
  append(bytes, static_cast<std::uint32_t>(level));
  append(bytes, static_cast<std::uint32_t>(kNumLevels));
  for (std::size_t i = 0; i < kNumLevels; ++i) {
    append(bytes, static_cast<std::uint32_t>(tiles.levels[i].size()));
    append(bytes, static_cast<float>(kLevelCells[i]));
  }
  for (const double coordinate : tiles.p_imu_centre) append(bytes, static_cast<float>(coordinate));
  append(bytes, static_cast<float>(tiles.radius));
  for (const TilePoint& point : points) {
    append(bytes, point.p_imu);
    append(bytes, point.keyframe);
  }
  for (const TilePoint& point : points) append(bytes, point.intensity);
  return bytes;
}

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#pragma once
// Tiles made from an atlas when they are asked for, and kept within a budget of memory.

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/view/tiles.hpp"

namespace mmlins::view {

class TileStore {
 public:
  /// @param atlas   only this store uses it from now on
  /// @param budget  of the tiles that are kept [bytes]
  explicit TileStore(std::shared_ptr<const atlas::Atlas> atlas, std::size_t budget = 256'000'000);

  /// One level of the keyframes from one id to another, as it is sent. From any thread.
  /// @return kNotFound if there are no such keyframes, kInvalid if they are too many
  [[nodiscard]] Result<std::string> tile(int first, int last, int level);

 private:
  using Key = std::pair<int, int>;
  using Tiles = std::shared_ptr<const BlockTiles>;
  struct Kept {
    Key key;
    Tiles tiles;
    std::size_t bytes = 0;
  };

  [[nodiscard]] Tiles find(const Key& key);
  void keep(const Key& key, const Tiles& tiles);
  [[nodiscard]] Result<std::vector<keyframe::KeyframePointer>> load(int first, int last);

  std::shared_ptr<const atlas::Atlas> atlas_;
  std::size_t budget_;
  std::mutex atlas_mutex_;
  std::mutex mutex_;  ///< guards what follows
  std::size_t bytes_kept_ = 0;
  std::list<Kept> recent_;  ///< the one used last first
  std::map<Key, std::list<Kept>::iterator> index_;
};

}  // namespace mmlins::view

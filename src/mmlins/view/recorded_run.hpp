// SPDX-License-Identifier: MIT
#pragma once
// What the page is shown of a run that has ended.

#include "mmlins/view/router.hpp"
#include "mmlins/view/scene.hpp"
#include "mmlins/view/tile_store.hpp"

namespace mmlins::view {

/// An error as an answer.
[[nodiscard]] Response tile_response(Result<std::string> tile);

/// The parts put together. @param summary  of the run, JSON; empty if there is none yet
[[nodiscard]] std::string scene_json(const std::string& name, bool is_live, Time begin,
                                     const std::string& summary, const std::string& maps,
                                     const std::string& scans);

/// The earliest time that anything has.
[[nodiscard]] Time begin_of(const MapsAndEdges& maps, const Scans& scans);

class RecordedRun final : public Content {
 public:
  explicit RecordedRun(const RunFolder& run);

  [[nodiscard]] std::string scene() override { return scene_; }
  [[nodiscard]] Response tile(int first, int last, int level) override {
    return tile_response(tiles_.tile(first, last, level));
  }

 private:
  std::string scene_;
  TileStore tiles_;
};

}  // namespace mmlins::view

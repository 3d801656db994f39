// SPDX-License-Identifier: MIT
#pragma once
// The folder of a run with two maps that were merged, without a run.

#include <string>

#include "mmlins/base/text_file.hpp"
#include "tests/atlas/example.hpp"

namespace mmlins::view {

inline constexpr int kExamplePoints = 50;  ///< per keyframe

/// Two maps of ten keyframes each, in DIR/atlas.
inline bool write_example_atlas(const std::string& folder,
                                atlas::MapState last = atlas::MapState::kSleeping) {
  auto atlas = atlas::Atlas::create(folder + "/atlas");
  if (!atlas) return false;
  bool ok = true;
  for (const int id : {0, 1}) {
    atlas::MapRow map = atlas::example_map(id);
    map.state = id == 1 ? last : atlas::MapState::kSleeping;
    ok = ok && atlas->add_map(map).ok();
  }
  for (int id = 0; id < 20; ++id) {
    ok = ok && atlas->add_keyframe(atlas::example_keyframe(id, id / 10, kExamplePoints)).ok();
    if (id % 10 > 0) ok = ok && atlas->add_edge(atlas::example_edge(id - 1, id)).ok();
  }
  atlas::GraphChange change;
  change.new_edges = {atlas::example_edge(3, 14, graph::EdgeKind::kMerge)};
  change.worlds = {{1, 0}};
  atlas::MergeRow merge;
  merge.time = atlas::example_map(1).last;
  merge.map = 1;
  merge.kind = "merge";
  merge.evidence = R"({"closures": [-11]})";
  change.new_merges = {merge};
  ok = ok && atlas->apply(change).ok();
  return ok && atlas->commit().ok();
}

/// The other files, of three scans.
inline bool write_example_files(const std::string& folder) {
  const auto write = [&](const char* name, const char* text) {
    return write_text_file(folder + "/" + name, text).ok();
  };
  return write("health.csv",
               "time,state,cause,map,points,total_ms\n"
               "1600000000.100000000,INITIALIZING,,0,7,1.5\n"
               "1600000000.200000000,TRACKING,,0,7,2.5\n"
               "1600000000.300000000,LOST,no points,0,0,0.25\n") &&
         write("trajectory.tum",
               "1600000000.100000000 1 2 3 0 0 0 1\n"
               "1600000000.200000000 2 2 3 0 0 0 1\n"
               "1600000000.300000000 3 2 3 0 0 1 0\n") &&
         write("summary.json", R"({"scans": 3, "config": "long"})");
}

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
// Writes a small atlas for the tests of `mmlins maps`: two maps of 20 keyframes, 1 m apart, that were merged.
// With a number it goes on writing keyframes to a third map, and never ends.

#include <algorithm>
#include <cstdio>

#include "tests/atlas/example.hpp"

namespace mmlins::atlas {
namespace {

bool write_maps(Atlas& atlas) {
  bool ok = true;
  for (const int id : {0, 1}) {
    MapRow map = example_map(id);
    map.state = MapState::kSleeping;
    map.T_world_map = id == 0 ? SE3{} : SE3{math::so3_exp({0.0, 0.0, 1.5}), {100.0, 0.0, 0.0}};
    ok = ok && atlas.add_map(map).ok();
  }
  for (int id = 0; id < 40; ++id) {
    ok = ok && atlas.add_keyframe(example_keyframe(id, id / 20)).ok();
    if (id % 20 > 0) ok = ok && atlas.add_edge(example_edge(id - 1, id)).ok();
    ok = ok && atlas.add_gravity({id, Vector3d::UnitZ(), 0.01}).ok();
  }
  ok = ok && atlas.add_place(example_place(1, 25)).ok();
  GraphChange change;
  change.new_edges = {example_edge(5, 30, graph::EdgeKind::kMerge)};
  change.new_edges.push_back(example_edge(6, 31, graph::EdgeKind::kMerge));
  change.new_edges.back().weight = 0.0;
  for (int id = 0; id < 40; ++id) {
    SE3 T = example_keyframe(id, id / 20).T_map_imu;
    T.t.z() += 5.0;  // what tells the optimised poses from those of the odometry
    change.T_map_imu_optimised.push_back({id, T});
  }
  change.worlds = {{1, 0}};
  MergeRow merge;
  merge.time = example_map(1).last;
  merge.map = 1;
  merge.kind = "recognised";
  merge.evidence = R"({"overlap": 0.7})";
  change.new_merges = {merge};
  return ok && atlas.apply(change).ok();
}

/// Tells the number of keyframes committed, a line each time.
bool write_without_end(Atlas& atlas) {
  bool ok = atlas.add_map(example_map(2)).ok();
  for (int id = 40; ok; ++id) {
    ok = atlas.add_keyframe(example_keyframe(id, 2)).ok() && atlas.commit().ok();
    std::printf("%d\n", id + 1);
    std::fflush(stdout);
  }
  return ok;
}

int run(int argc, char** argv) {
  if (argc < 2) return 2;
  auto atlas = Atlas::create(argv[1], {.chunk_bytes = 5000});
  if (!atlas.ok() || !write_maps(*atlas)) return 1;
  if (argc > 2) return write_without_end(*atlas) ? 0 : 1;
  return atlas->commit().ok() ? 0 : 1;
}

}  // namespace
}  // namespace mmlins::atlas

int main(int argc, char** argv) { return mmlins::atlas::run(argc, argv); }

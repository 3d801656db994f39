// SPDX-License-Identifier: MIT
#pragma once
// Content for an atlas, made from numbers: whoever knows the id knows what must be found.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::atlas {

/// A folder that is removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "mmlins_atlas_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

inline SE3 example_pose(std::uint64_t seed) {
  math::Random random(seed);
  return {math::so3_exp(random.normal3()), 100.0 * random.normal3()};
}

/// Points anywhere within reach; every third keyframe has no intensities.
inline keyframe::Keyframe example_keyframe(int id, int map_id, int num_points = 50) {
  math::Random random(static_cast<std::uint64_t>(id) + 1000);
  keyframe::Keyframe kf;
  kf.id = id;
  kf.map_id = map_id;
  kf.time = time_from_ns(1'600'000'000'000'000'000 + 333'333'333LL * id);
  kf.T_map_imu = {math::so3_exp({0.0, 0.0, 0.1 * id}), {1.0 * id, 0.5 * map_id, 0.01 * id}};
  kf.down_imu = random.normal3().normalized();
  const int largest = static_cast<int>(keyframe::kPointReach / keyframe::kPointQuantum);
  for (int i = 0; i < num_points; ++i) {
    Eigen::Vector3f point;
    for (float& coordinate : point) {
      const int multiple =
          static_cast<int>(random.bits() % (2 * static_cast<unsigned>(largest) + 1)) - largest;
      coordinate = static_cast<float>(multiple * keyframe::kPointQuantum);
    }
    kf.points_imu.push_back(point);
    if (id % 3 != 0) kf.intensities.push_back(static_cast<std::uint16_t>(random.bits()));
  }
  return kf;
}

inline MapRow example_map(int id) {
  MapRow map;
  map.id = id;
  map.world = id;
  map.state = id == 0 ? MapState::kSleeping : MapState::kActive;
  map.beginning = id == 0 ? "at rest" : "after a gap";
  map.why_ended = id == 0 ? "too few matches" : "";
  map.begin = time_from_ns(1'600'000'000'000'000'000 + 10'000'000'000LL * id);
  map.last = map.begin + Duration(9'000'000'000LL);
  map.T_world_map = example_pose(static_cast<std::uint64_t>(id) + 1);
  return map;
}

inline EdgeRow example_edge(int from, int to, graph::EdgeKind kind = graph::EdgeKind::kOdometry) {
  EdgeRow row;
  row.edge.from = from;
  row.edge.to = to;
  row.edge.T_from_to = example_pose(static_cast<std::uint64_t>(from) * 1000 + static_cast<std::uint64_t>(to));
  row.edge.information = math::Matrix6d::Identity() * (1.0 / 3.0) + math::Matrix6d::Ones() * 0.01;
  row.edge.kind = kind;
  row.edge.robust = kind == graph::EdgeKind::kLoop || kind == graph::EdgeKind::kMerge;
  row.edge.provenance = from - to;
  row.evidence = R"({"overlap": 0.9, "note": "it's \"ours\""})";
  return row;
}

inline PlaceRow example_place(int map_id, int submap_id) {
  PlaceRow place;
  place.map_id = map_id;
  place.submap_id = submap_id;
  place.T_map_submap = example_pose(static_cast<std::uint64_t>(submap_id) + 77);
  place.keyframe_ids = {submap_id - 1, submap_id, submap_id + 1};
  place.footprint.ground = -1.3F;
  place.footprint.structure = {{-32768, 32767, 65535}, {12, -34, 56}, {0, 0, 0}};
  return place;
}

}  // namespace mmlins::atlas

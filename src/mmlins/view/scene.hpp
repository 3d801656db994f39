// SPDX-License-Identifier: MIT
#pragma once
// All that the viewer shows but the points: maps, keyframes, edges, merges, and the way scan by scan.

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mmlins/atlas/atlas.hpp"

namespace mmlins::view {

/// A scan as the viewer needs it. State and cause are indices into ScanNames.
struct SceneScan {
  Time time;
  math::SE3 T_world_imu;
  int map_id = 0;
  int state = 0;
  int cause = 0;
  float total_ms = 0.0F;
};

/// The names that the scans use.
struct ScanNames {
  std::vector<std::string> states;
  std::vector<std::string> causes;

  [[nodiscard]] int state(std::string_view name) { return index(states, name); }
  [[nodiscard]] int cause(std::string_view name) { return index(causes, name); }

 private:
  static int index(std::vector<std::string>& names, std::string_view name);
};

/// What the atlas says at one moment.
struct MapsAndEdges {
  std::vector<atlas::MapRow> maps;
  std::vector<atlas::KeyframeRow> keyframes;
  std::vector<atlas::EdgeRow> edges;  ///< all but those of the odometry
  std::vector<atlas::MergeRow> merges;
};
[[nodiscard]] Result<MapsAndEdges> read_maps_and_edges(const atlas::Atlas& atlas);

struct Scans {
  ScanNames names;
  std::vector<SceneScan> scans;
};

/// A finished run.
struct RunFolder {
  std::string name;  ///< of the folder
  std::shared_ptr<const atlas::Atlas> atlas;
  MapsAndEdges maps;
  Scans scans;
  std::string summary;  ///< summary.json
};

/// @return one line that says what is missing if the folder is no result, or not (yet) a whole one
[[nodiscard]] Result<RunFolder> open_run(const std::string& folder);

/// The way from trajectory.tum and health.csv.
[[nodiscard]] Result<Scans> read_scans(const std::string& folder);

/// Text as JSON has it, in quotes.
[[nodiscard]] std::string json_text(std::string_view text);

/// As JSON, docs/formats.md: "What `mmlins view` serves". Numbers of the atlas and of the recording, nothing
/// computed.
[[nodiscard]] std::string maps_json(const MapsAndEdges& maps, Time begin);
/// The scans from one on.
[[nodiscard]] std::string scans_json(const Scans& scans, std::size_t from, Time begin);

}  // namespace mmlins::view

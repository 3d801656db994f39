// SPDX-License-Identifier: MIT
// mmlins maps: what lies in an atlas, out of it into files, and whether it is whole.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "mmlins/atlas/export.hpp"
#include "mmlins/atlas/unmerge.hpp"
#include "mmlins/base/log.hpp"
#include "mmlins/eval/trajectory_file.hpp"
#include "mmlins/graph/g2o.hpp"

namespace mmlins::cli {
namespace {

using atlas::Atlas;
using atlas::MapRow;

const std::vector<std::string> kFormats = {"pcd", "ply", "g2o", "tum"};  // the first one unless told otherwise

struct MapsOptions {
  std::string folder;
  int id = 0;
  std::string format;  ///< empty: by the name of the file
  std::string out;
  double voxel = 0.1;
  bool world = false;
};

/// An index that is damaged is replaced by what can be found without it.
Result<Atlas> open_for_reading(const std::string& folder) {
  const std::string place = atlas::find_atlas(folder);
  auto opened = Atlas::open(place, atlas::Access::kRead);
  if (opened.ok() || opened.error().code != ErrorCode::kInvalid) return opened;
  log::warning("{}; the poses may be those of the odometry", opened.error().message);
  return Atlas::salvage(place);
}

/// A map and what its keyframes say about it.
struct MapSummary {
  MapRow map;
  std::size_t num_keyframes = 0;
  std::size_t num_points = 0;
  double length = 0.0;         ///< along the keyframes [m]
  Eigen::AlignedBox3d extent;  ///< of the keyframes, in the world
};

Result<MapSummary> summarise(const Atlas& atlas, const MapRow& map) {
  const auto keyframes = atlas.keyframes_of(map.id);
  if (!keyframes) return keyframes.error();
  MapSummary summary;
  summary.map = map;
  for (std::size_t i = 0; i < keyframes->size(); ++i) {
    const atlas::KeyframeRow& row = (*keyframes)[i];
    const math::Vector3d& p_map = row.T_map_imu_optimised.t;
    if (i > 0) summary.length += (p_map - (*keyframes)[i - 1].T_map_imu_optimised.t).norm();
    summary.num_points += static_cast<std::size_t>(row.num_points);
    summary.extent.extend(map.T_world_map * p_map);
  }
  summary.num_keyframes = keyframes->size();
  return summary;
}

Result<MapRow> find_map(const Atlas& atlas, int id) {
  auto maps = atlas.maps();
  if (!maps) return maps.error();
  std::string known;
  for (const MapRow& map : *maps) {
    if (map.id == id) return map;
    known += fmt::format(" {}", map.id);
  }
  return make_error(ErrorCode::kNotFound, "{}: there is no map {}; there {}{}", atlas.folder(), id,
                    maps->empty() ? "are none" : maps->size() == 1 ? "is" : "are", known);
}

/// The map itself, or all maps that share its world.
Result<std::vector<int>> chosen_maps(const Atlas& atlas, const MapsOptions& options) {
  const auto map = find_map(atlas, options.id);
  if (!map) return map.error();
  if (!options.world) return std::vector<int>{map->id};
  const auto maps = atlas.maps();
  if (!maps) return maps.error();
  std::vector<int> ids;
  for (const MapRow& other : *maps) {
    if (other.world == map->world) ids.push_back(other.id);
  }
  return ids;
}

const char* state_name(const MapRow& map) {
  return map.state == atlas::MapState::kActive ? "active" : "sleeping";
}
double lasts(const MapRow& map) { return to_seconds(map.last - map.begin); }

/// Whether a merge stands, and if it does not, who took it back.
std::string fate_of(const atlas::MergeRow& merge) {
  if (!merge.undone) return "stands";
  const auto evidence = nlohmann::json::parse(merge.evidence, nullptr, false);
  if (!evidence.is_object() || !evidence.contains("undone_because")) return "taken back";
  return fmt::format("taken back by the run: {}", evidence["undone_because"].dump());
}

Status print_merges(const Atlas& atlas) {
  const auto merges = atlas.merges();
  if (!merges) return merges.error();
  if (merges->empty()) return {};
  fmt::print("\n{:>5}  {:>4}  {:>4}  {:>20}  {}\n", "merge", "map", "into", "at [s]", "state");
  for (const atlas::MergeRow& row : *merges) {
    fmt::print("{:>5}  {:>4}  {:>4}  {:>20}  {}\n", row.id, row.map, row.into, eval::seconds_text(row.time), fate_of(row));
  }
  return {};
}

int run_list(const MapsOptions& options) {
  const auto atlas = open_for_reading(options.folder);
  if (!atlas.ok()) return fail(atlas.error());
  const auto maps = atlas->maps();
  if (!maps.ok()) return fail(maps.error());
  fmt::print("{:>4}  {:>5}  {:<8}  {:>20}  {:>9}  {:>9}  {:>10}  {:>11}  {:<12}  {}\n", "map", "world",
             "state", "begins [s]", "lasts [s]", "keyframes", "length [m]", "points", "began", "ended");
  for (const MapRow& map : *maps) {
    const auto summary = summarise(*atlas, map);
    if (!summary.ok()) return fail(summary.error());
    fmt::print("{:>4}  {:>5}  {:<8}  {:>20}  {:>9.1f}  {:>9}  {:>10.1f}  {:>11}  {:<12}  {}\n", map.id,
               map.world, state_name(map), eval::seconds_text(map.begin), lasts(map), summary->num_keyframes,
               summary->length, summary->num_points, map.beginning,
               map.why_ended.empty() ? "-" : map.why_ended);
  }
  if (const Status status = print_merges(*atlas); !status) return fail(status.error());
  return 0;
}

Status print_edges(const Atlas& atlas, int map_id) {
  const std::array ids{map_id};
  const auto keyframes = atlas::world_keyframes(atlas, ids);
  const auto edges = atlas.edges();
  if (!keyframes || !edges) return keyframes ? edges.error() : keyframes.error();
  std::vector<std::int64_t> own;
  for (const atlas::WorldKeyframe& keyframe : *keyframes) own.push_back(keyframe.id);
  std::sort(own.begin(), own.end());
  const auto is_own = [&](std::int64_t id) { return std::binary_search(own.begin(), own.end(), id); };
  std::array<int, graph::kNumEdgeKinds> believed{};
  std::array<int, graph::kNumEdgeKinds> rejected{};
  for (const atlas::EdgeRow& row : *edges) {
    if (!is_own(row.edge.from) && !is_own(row.edge.to)) continue;
    ++(row.weight > 0.0 ? believed : rejected)[static_cast<std::size_t>(row.edge.kind)];
  }
  std::string text;
  for (std::size_t kind = 0; kind < believed.size(); ++kind) {
    text += fmt::format("{}{} {}", kind == 0 ? "" : ", ", believed[kind], graph::kEdgeKindNames[kind]);
    if (rejected[kind] > 0) text += fmt::format(" ({} more rejected)", rejected[kind]);
  }
  fmt::print("  edges      {}\n", text);
  return {};
}

Status print_places_and_merges(const Atlas& atlas, int map_id) {
  const auto places = atlas.places();
  const auto merges = atlas.merges();
  if (!places || !merges) return places ? merges.error() : places.error();
  fmt::print("  places     {}\n",
             std::count_if(places->begin(), places->end(),
                           [map_id](const atlas::PlaceRow& row) { return row.map_id == map_id; }));
  for (const atlas::MergeRow& row : *merges) {
    if (row.map != map_id && row.into != map_id) continue;
    fmt::print("  merge {:<4} map {} into {} at {} s, {}{} {}\n", row.id, row.map, row.into,
               eval::seconds_text(row.time), row.kind, row.undone ? ", undone" : "", row.evidence);
  }
  return {};
}

int run_show(const MapsOptions& options) {
  const auto atlas = open_for_reading(options.folder);
  if (!atlas.ok()) return fail(atlas.error());
  const auto map = find_map(*atlas, options.id);
  if (!map.ok()) return fail(map.error());
  const auto summary = summarise(*atlas, *map);
  if (!summary.ok()) return fail(summary.error());
  MapsOptions of_world = options;
  of_world.world = true;
  const auto together = chosen_maps(*atlas, of_world);
  if (!together.ok()) return fail(together.error());
  const math::Vector3d& p = map->T_world_map.t;
  fmt::print("map {}\n  state      {}{}{}\n", map->id, state_name(*map),
             map->why_ended.empty() ? "" : "; ended: ", map->why_ended);
  fmt::print("  began      {} s, {}; lasts {:.1f} s\n", eval::seconds_text(map->begin), map->beginning,
             lasts(*map));
  fmt::print("  world      {}, of maps {}; origin of this map at ({:.3f}, {:.3f}, {:.3f}) m\n", map->world,
             fmt::join(*together, ", "), p.x(), p.y(), p.z());
  fmt::print("  keyframes  {} over {:.1f} m, {} points\n", summary->num_keyframes, summary->length,
             summary->num_points);
  if (summary->num_keyframes > 0) {
    const auto& low = summary->extent.min();
    const auto& high = summary->extent.max();
    fmt::print(
        "  extent     x {:.1f} to {:.1f}, y {:.1f} to {:.1f}, z {:.1f} to {:.1f} m in the world, of the "
        "path\n",
        low.x(), high.x(), low.y(), high.y(), low.z(), high.z());
  }
  if (const Status status = print_edges(*atlas, map->id); !status) return fail(status.error());
  if (const Status status = print_places_and_merges(*atlas, map->id); !status) return fail(status.error());
  return 0;
}

Result<std::string> export_points(const Atlas& atlas, const std::vector<int>& ids,
                                  const MapsOptions& options) {
  const auto format = options.format == "ply" ? atlas::CloudFormat::kPly : atlas::CloudFormat::kPcd;
  const auto report = atlas::export_cloud(atlas, ids, options.out, {format, options.voxel});
  if (!report) return report.error();
  if (report->num_lost > 0) {
    log::warning("{} of {} keyframes are left out: {}", report->num_lost,
                 report->num_lost + report->num_keyframes, report->first_loss);
  }
  return fmt::format("{} points of {} keyframes", report->num_points, report->num_keyframes);
}

Result<std::string> export_poses(const Atlas& atlas, const std::vector<int>& ids,
                                 const MapsOptions& options) {
  const auto keyframes = atlas::world_keyframes(atlas, ids);
  if (!keyframes) return keyframes.error();
  math::Trajectory trajectory;
  for (const atlas::WorldKeyframe& keyframe : *keyframes) {
    trajectory.push_back({keyframe.time, keyframe.T_world_imu});
  }
  if (const Status status = eval::write_tum(options.out, trajectory); !status) return status.error();
  return fmt::format("{} poses", trajectory.size());
}

Result<std::string> export_graph(const Atlas& atlas, const std::vector<int>& ids,
                                 const MapsOptions& options) {
  const auto graph = atlas::pose_graph(atlas, ids);
  if (!graph) return graph.error();
  if (const Status status = graph::write_g2o(options.out, *graph); !status) return status.error();
  return fmt::format("{} keyframes and {} edges", graph->nodes.size(), graph->edges.size());
}

/// As asked for, or else as the name of the file says.
Result<std::string> chosen_format(const MapsOptions& options) {
  const std::size_t dot = options.out.rfind('.');
  const std::string extension = dot == std::string::npos ? "" : CLI::detail::to_lower(options.out.substr(dot + 1));
  const bool is_known = std::find(kFormats.begin(), kFormats.end(), extension) != kFormats.end();
  if (options.format.empty()) return is_known ? extension : kFormats.front();
  if (!is_known || extension == options.format) return options.format;
  return make_error(ErrorCode::kInvalid, "{}: the name says {}, but --format {}; leave --format out or give another name",
                    options.out, extension, options.format);
}

int run_export(MapsOptions options) {
  auto format = chosen_format(options);
  if (!format.ok()) return fail(format.error());
  options.format = std::move(*format);
  const auto atlas = open_for_reading(options.folder);
  if (!atlas.ok()) return fail(atlas.error());
  const auto ids = chosen_maps(*atlas, options);
  if (!ids.ok()) return fail(ids.error());
  if (options.out.empty()) {
    options.out = fmt::format("{}_{}.{}", options.world ? "world_of_map" : "map", options.id, options.format);
  }
  const bool is_cloud = options.format == "pcd" || options.format == "ply";
  const auto write = is_cloud ? export_points : options.format == "tum" ? export_poses : export_graph;
  const auto what = write(*atlas, *ids, options);
  if (!what.ok()) return fail(what.error());
  fmt::print("{}: {} of map {}\n", options.out, *what, fmt::join(*ids, ", "));
  return 0;
}

int run_check(const MapsOptions& options) {
  const std::string place = atlas::find_atlas(options.folder);
  auto opened = Atlas::open(place, atlas::Access::kRead);
  std::vector<std::string> problems;
  if (!opened.ok()) {
    if (opened.error().code != ErrorCode::kInvalid) return fail(opened.error());
    problems.push_back(opened.error().message);
  }
  const auto atlas = opened.ok() ? std::move(opened) : Atlas::salvage(place);
  if (!atlas.ok()) return fail(atlas.error());
  const auto report = atlas->check();
  if (!report.ok()) return fail(report.error());
  problems.insert(problems.end(), report->problems.begin(), report->problems.end());
  fmt::print("{}: {} maps, {} keyframes, {} edges, {} points can be read; {}\n", place, report->num_maps,
             report->num_keyframes, report->num_edges, report->num_points,
             problems.empty() ? "all is well" : fmt::format("problems: {}", problems.size()));
  for (const std::string& problem : problems) fmt::print("{}\n", problem);
  return problems.empty() ? 0 : 1;
}

/// Opened for writing once it holds what is to be changed: that alone puts maps of a run that was killed to sleep.
template <typename Find>
Result<Atlas> open_to_change(const MapsOptions& options, const Find& find) {
  const std::string place = atlas::find_atlas(options.folder);
  {
    const auto as_it_is = Atlas::open(place, atlas::Access::kRead);
    if (!as_it_is) return as_it_is.error();
    if (const auto found = find(*as_it_is, options.id); !found) return found.error();
  }
  return Atlas::open(place, atlas::Access::kWrite);
}

int run_delete(const MapsOptions& options) {
  auto atlas = open_to_change(options, find_map);
  if (!atlas.ok()) return fail(atlas.error());
  const auto removed = atlas->delete_map(options.id);
  if (!removed.ok()) return fail(removed.error());
  fmt::print(
      "map {} removed: {} keyframes, {} edges, {} places, {} merges; {:.1f} MB of disk space given back\n",
      options.id, removed->num_keyframes, removed->num_edges, removed->num_places, removed->num_merges,
      1e-6 * static_cast<double>(removed->freed_bytes));
  return 0;
}

int run_unmerge(const MapsOptions& options) {
  auto atlas = open_to_change(options, atlas::find_standing_merge);
  if (!atlas.ok()) return fail(atlas.error());
  const auto apart = atlas::unmerge(*atlas, options.id);
  if (!apart.ok()) return fail(apart.error());
  fmt::print("merge {} taken back: map {} and map {} lie in two worlds again, {} edges between them no longer count\n", options.id,
             fmt::join(apart->stayed, ", "), fmt::join(apart->moved, ", "), apart->num_edges);
  return 0;
}

}  // namespace

void add_maps(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<MapsOptions>();
  CLI::App* maps = program.add_subcommand("maps", "the maps that a run left in its atlas");
  maps->add_option("folder", options->folder, "folder of a run, or its folder atlas")->required();
  maps->require_subcommand(1);
  const auto add = [&](const char* name, const char* meaning, const auto& run) {
    CLI::App* command = maps->add_subcommand(name, meaning);
    command->callback([options, &exit_code, run] { exit_code = run(*options); });
    return command;
  };
  add("list", "a line for each map, and for each merge", run_list);
  CLI::App* show = add("show", "all about one map", run_show);
  CLI::App* out =
      add("export", "a map as a file, in the frame of its world, with optimised poses", run_export);
  add("check", "read everything and say what is damaged; exit code 1 if anything is", run_check);
  CLI::App* remove = add("delete", "remove a map; asks nothing", run_delete);
  CLI::App* unmerge = add("unmerge", "take a merge back: its maps lie in two worlds again", run_unmerge);
  unmerge->add_option("id", options->id, "number of the merge, as told by list")->required();
  for (CLI::App* command : {show, out, remove}) {
    command->add_option("id", options->id, "number of the map, as told by list")->required();
  }
  out->add_option("--format", options->format, "points: pcd or ply; keyframes: tum; pose graph: g2o; else as --out ends, or pcd")
      ->check(CLI::IsMember(kFormats));
  out->add_option("--out", options->out, "file to write; else map_ID.FORMAT here");
  out->add_option("--voxel", options->voxel, "one measured point per cell of this edge [m]; 0: all points")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  out->add_flag("--world", options->world, "all maps that were merged with this one");
}

}  // namespace mmlins::cli

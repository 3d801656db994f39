// SPDX-License-Identifier: MIT
#include "mmlins/view/live_run.hpp"

#include <algorithm>
#include <boost/lockfree/spsc_queue.hpp>
#include <filesystem>

namespace mmlins::view {
namespace {

/// Far more than come between two looks at the queue.
constexpr std::size_t kQueue = 4096;
/// The atlas is read so often, and with at most so much of one core [ms].
constexpr double kReadEvery = 500.0;
constexpr double kLeastRest = 20.0;

}  // namespace

class LiveRun::Queue {
 public:
  boost::lockfree::spsc_queue<LiveScan, boost::lockfree::capacity<kQueue>> scans;
};

LiveRun::LiveRun(std::string name) : name_(std::move(name)), queue_(std::make_unique<Queue>()) {}
LiveRun::~LiveRun() = default;

Result<std::unique_ptr<LiveRun>> LiveRun::open(const std::string& folder) {
  // Two connections: one thread reads what the maps are while another reads points.
  auto rows = atlas::Atlas::reader(folder + "/atlas");
  if (!rows) return rows.error();
  auto points = atlas::Atlas::reader(folder + "/atlas");
  if (!points) return points.error();
  std::unique_ptr<LiveRun> run(new LiveRun(std::filesystem::weakly_canonical(folder).filename().string()));
  run->atlas_ = std::make_shared<const atlas::Atlas>(std::move(*rows));
  run->tiles_ = std::make_shared<TileStore>(std::make_shared<const atlas::Atlas>(std::move(*points)));
  run->maps_json_ = maps_json({}, Time{});
  return run;
}

void LiveRun::add(const LiveScan& scan) {
  if (!queue_->scans.push(scan)) ++num_left_out_;
}

void LiveRun::let_go() {
  take_scans();
  const std::unique_lock wait(use_);
  const std::lock_guard lock(mutex_);
  atlas_.reset();
  tiles_.reset();
}

Status LiveRun::end(const std::string& folder) {
  const auto run = open_run(folder);
  if (!run) return run.error();
  auto recorded = std::make_shared<RecordedRun>(*run);
  const std::lock_guard lock(mutex_);
  recorded_ = std::move(recorded);
  return {};
}

std::string LiveRun::scene() {
  const std::lock_guard lock(mutex_);
  if (recorded_) return recorded_->scene();
  return scene_json(name_, true, begin_, "", maps_json_, scans_json(scans_, 0, begin_));
}

Response LiveRun::tile(int first, int last, int level) {
  const std::shared_lock use(use_);
  std::shared_ptr<RecordedRun> recorded;
  std::shared_ptr<TileStore> tiles;
  {
    const std::lock_guard lock(mutex_);
    recorded = recorded_;
    tiles = tiles_;
  }
  if (recorded) return recorded->tile(first, last, level);
  if (tiles) return tile_response(tiles->tile(first, last, level));
  return {204, "application/octet-stream", ""};  // the run is being saved
}

void LiveRun::refresh() {
  take_scans();
  since_read_ms_ += stopwatch_.lap_ms();
  if (since_read_ms_ < std::max(kReadEvery, kLeastRest * read_ms_)) return;
  read_atlas();
  read_ms_ = stopwatch_.lap_ms();
  since_read_ms_ = 0.0;
}

void LiveRun::take_scans() {
  const std::lock_guard lock(mutex_);
  queue_->scans.consume_all([this](const LiveScan& scan) {
    if (scans_.scans.empty()) begin_ = scan.time;
    scans_.scans.push_back({scan.time, scan.T_map_imu, scan.map_id, scans_.names.state(scan.state),
                            scans_.names.cause(scan.cause), scan.total_ms});
  });
}

void LiveRun::read_atlas() {
  const std::shared_lock use(use_);
  std::shared_ptr<const atlas::Atlas> atlas;
  Time begin;
  {
    const std::lock_guard lock(mutex_);
    if (scans_.scans.empty()) return;  // times are told since the first scan
    atlas = atlas_;
    begin = begin_;
  }
  if (!atlas) return;
  const auto maps = read_maps_and_edges(*atlas);
  if (!maps) return;  // the next time
  std::string json = maps_json(*maps, begin);
  const std::lock_guard lock(mutex_);
  if (json == maps_json_) return;
  maps_json_ = std::move(json);
  ++version_;
}

std::shared_ptr<const std::string> LiveRun::news(FeedPosition& position) {
  const std::lock_guard lock(mutex_);
  if (recorded_) {
    if (position.was_told_the_end) return nullptr;
    position.was_told_the_end = true;
    return std::make_shared<const std::string>(R"({"ended":true})");
  }
  const bool has_maps = position.atlas_version != version_;
  const bool has_scans = position.num_scans < scans_.scans.size();
  if (!has_maps && !has_scans) return nullptr;
  std::string text = "{";
  if (has_maps) text += "\"atlas\":" + maps_json_;
  if (has_maps && has_scans) text += ',';
  if (has_scans) text += "\"scans\":" + scans_json(scans_, position.num_scans, begin_);
  position.atlas_version = version_;
  position.num_scans = scans_.scans.size();
  return std::make_shared<const std::string>(text + "}");
}

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#pragma once
// What the page is shown of a run that goes on, and of the same run when it has ended. The run hands in its
// scans through a queue that never makes it wait; everything else is read from the atlas, as any other reader
// would.

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <string_view>

#include "mmlins/base/stopwatch.hpp"
#include "mmlins/view/live_feed.hpp"
#include "mmlins/view/recorded_run.hpp"

namespace mmlins::view {

/// A scan as the run knows it. The names must live as long as the program.
struct LiveScan {
  Time time;
  math::SE3 T_map_imu;
  int map_id = 0;
  std::string_view state;
  std::string_view cause;
  float total_ms = 0.0F;
};

class LiveRun final : public Content, public LiveFeed {
 public:
  /// @param folder  of the run, whose atlas this process is writing
  [[nodiscard]] static Result<std::unique_ptr<LiveRun>> open(const std::string& folder);
  ~LiveRun() override;

  /// Never waits: a scan that finds no room is left out of the picture. From one thread.
  void add(const LiveScan& scan);
  /// Closes the atlas, so that its writer is the last to leave it.
  void let_go();
  /// From now on the result is shown. To be called after let_go(), when all files have been written.
  [[nodiscard]] Status end(const std::string& folder);
  [[nodiscard]] int num_left_out() const { return num_left_out_; }

  [[nodiscard]] std::string scene() override;
  [[nodiscard]] Response tile(int first, int last, int level) override;
  void refresh() override;
  [[nodiscard]] std::shared_ptr<const std::string> news(FeedPosition& position) override;

 private:
  class Queue;
  explicit LiveRun(std::string name);

  void take_scans();
  void read_atlas();

  std::string name_;
  std::unique_ptr<Queue> queue_;
  std::atomic<int> num_left_out_ = 0;
  double since_read_ms_ = 1e9;  ///< since the atlas was read, and how long that took
  double read_ms_ = 0.0;
  Stopwatch stopwatch_;

  std::shared_mutex use_;  ///< held by those who read the atlas: it is closed when they are done
  std::mutex mutex_;       ///< guards what follows; the run never takes it while scans come
  std::shared_ptr<const atlas::Atlas> atlas_;
  std::shared_ptr<TileStore> tiles_;
  std::shared_ptr<RecordedRun> recorded_;
  Scans scans_;
  Time begin_;
  std::string maps_json_;
  int version_ = 0;
};

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#pragma once
// `mmlins run --view`: the run in the browser while it goes on.

#include <atomic>
#include <memory>
#include <string>

#include "mmlins/pipeline/slam_system.hpp"
#include "mmlins/view/live_run.hpp"
#include "mmlins/view/server.hpp"
#include "viewing.hpp"

namespace mmlins::cli {

class RunView {
 public:
  /// @param folder  of the run, whose atlas has been created
  [[nodiscard]] static Result<std::unique_ptr<RunView>> start(const std::string& folder,
                                                              const ViewerOptions& options);

  /// Never waits.
  void add(const pipeline::ScanRecord& record);
  /// Before the atlas is closed.
  void let_go() { live_->let_go(); }
  /// Shows the result, until `stop` is set.
  void stay(const std::string& folder, const std::atomic<bool>& stop);

 private:
  explicit RunView(std::unique_ptr<view::LiveRun> live) : live_(std::move(live)) {}

  std::unique_ptr<view::LiveRun> live_;
  std::unique_ptr<view::Server> server_;  ///< uses live_
};

}  // namespace mmlins::cli

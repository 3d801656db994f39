// SPDX-License-Identifier: MIT
#include "run_view.hpp"

#include <chrono>
#include <cstdio>
#include <thread>

#include "mmlins/base/log.hpp"

namespace mmlins::cli {

Result<std::unique_ptr<RunView>> RunView::start(const std::string& folder, const ViewerOptions& options) {
  auto live = view::LiveRun::open(folder);
  if (!live) return live.error();
  std::unique_ptr<RunView> view(new RunView(std::move(*live)));
  auto server =
      view::Server::start({options.address, options.port, 1, true}, *view->live_, view->live_.get());
  if (!server) return server.error();
  view->server_ = std::move(*server);
  fmt::print("the run is shown at {}\n", view->server_->url());
  std::fflush(stdout);
  if (!options.no_browser) open_browser(view->server_->url());
  return view;
}

void RunView::add(const pipeline::ScanRecord& record) {
  live_->add({record.time, record.T_map_imu, record.map_id, odometry::to_string(record.state),
              odometry::to_string(record.cause), static_cast<float>(record.total_ms())});
}

void RunView::stay(const std::string& folder, const std::atomic<bool>& stop) {
  if (live_->num_left_out() > 0)
    log::warning("the viewer left out {} scans; the result has them", live_->num_left_out());
  if (const Status status = live_->end(folder); !status) {
    log::warning("the result cannot be shown: {}", status.error().message);
    return;
  }
  if (stop) return;
  fmt::print("the result is shown at {} until Ctrl-C\n", server_->url());
  std::fflush(stdout);
  while (!stop) std::this_thread::sleep_for(std::chrono::milliseconds(50));
}

}  // namespace mmlins::cli

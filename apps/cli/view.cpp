// SPDX-License-Identifier: MIT
// mmlins view: a finished run in the browser.

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "commands.hpp"
#include "mmlins/view/recorded_run.hpp"
#include "mmlins/view/server.hpp"
#include "viewing.hpp"

namespace mmlins::cli {
namespace {

struct ViewOptions {
  std::string folder;
  ViewerOptions viewer;
};

int view(const ViewOptions& options) {
  if (Status status = check_viewer(); !status) return fail(status.error());
  const auto run = view::open_run(options.folder);
  if (!run) return fail(run.error());
  view::RecordedRun content(*run);
  // Ctrl-C is waited for below, and by no other thread.
  const sigset_t ending = block_ending();
  const auto server = view::Server::start({options.viewer.address, options.viewer.port}, content);
  if (!server) return fail(server.error());
  fmt::print("{} is shown at {} until Ctrl-C\n", options.folder, (*server)->url());
  std::fflush(stdout);
  if (!options.viewer.no_browser) open_browser((*server)->url());
  int signal = 0;
  sigwait(&ending, &signal);
  return 0;
}

}  // namespace

void add_view(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = program.add_subcommand(
      "view", "Shows a run in the browser: map, trajectory, how maps grew and were joined");
  command->add_option("DIR", options->folder, "folder that mmlins run wrote (--out)")->required();
  add_viewer_options(*command, options->viewer);
  command->callback([options, &exit_code] { exit_code = view(*options); });
}

}  // namespace mmlins::cli

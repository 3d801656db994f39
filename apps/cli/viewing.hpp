// SPDX-License-Identifier: MIT
#pragma once
// What `mmlins view` and `mmlins run --view` have in common.

#include <CLI/CLI.hpp>
#include <csignal>
#include <string>

#include "mmlins/base/result.hpp"

namespace mmlins::cli {

struct ViewerOptions {
  std::string address = "127.0.0.1";
  int port = 0;
  bool no_browser = false;
};
/// @param needed  an option that these mean nothing without, or null
void add_viewer_options(CLI::App& command, ViewerOptions& options, CLI::Option* needed = nullptr);

/// An error if this program was built without the page.
[[nodiscard]] Status check_viewer();

/// Keeps SIGINT and SIGTERM for sigwait. @return these two
[[nodiscard]] sigset_t block_ending();

/// If there is a screen.
void open_browser(const std::string& url);

}  // namespace mmlins::cli

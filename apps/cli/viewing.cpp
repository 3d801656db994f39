// SPDX-License-Identifier: MIT
#include "viewing.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <cstdlib>

#include "mmlins/view/router.hpp"

extern char** environ;

namespace mmlins::cli {

void add_viewer_options(CLI::App& command, ViewerOptions& options, CLI::Option* needed) {
  CLI::Option* const added[] = {
      command.add_option("--port", options.port, "port to listen on; 0: one that is free")
          ->check(CLI::Range(0, 65535))
          ->capture_default_str(),
      command
          .add_option("--listen", options.address, "address to listen on; 0.0.0.0 lets others look as well")
          ->capture_default_str(),
      command.add_flag("--no-browser", options.no_browser, "do not open a browser")};
  for (CLI::Option* option : added) {
    if (needed) option->needs(needed);
  }
}

Status check_viewer() {
  if (!view::page().empty()) return {};
  return make_error(ErrorCode::kUnsupported,
                    "this mmlins was built without the viewer; install npm (Debian: apt-get install nodejs "
                    "npm) and build again");
}

sigset_t block_ending() {
  sigset_t ending;
  sigemptyset(&ending);
  sigaddset(&ending, SIGINT);
  sigaddset(&ending, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  return ending;
}

void open_browser(const std::string& url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO}) {
    posix_spawn_file_actions_addopen(&files, descriptor, "/dev/null", O_WRONLY, 0);
  }
  std::string program = "xdg-open";
  std::string argument = url;
  char* const arguments[] = {program.data(), argument.data(), nullptr};
  pid_t child = 0;
  // It is not waited for: where there is no xdg-open, the address that was printed will do.
  posix_spawnp(&child, program.c_str(), &files, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&files);
}

}  // namespace mmlins::cli

// SPDX-License-Identifier: MIT
// mmlins: LiDAR-inertial SLAM from the command line.

#include <fmt/format.h>

#include <cstdio>

#include "commands.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::cli {

int fail(const Error& error) {
  fmt::print(stderr, "mmlins: {}\n", error.message);
  return error.code == ErrorCode::kInterrupted ? 130 : 1;
}

namespace {

int run_program(int argc, char** argv) {
  CLI::App program{"mmlins: LiDAR-inertial odometry and mapping. A recording in, a trajectory and a map out."};
  program.set_version_flag("--version", "mmlins " MMLINS_VERSION);
  program.require_subcommand(1);
  int exit_code = 0;
  add_run(program, exit_code);
  add_info(program, exit_code);
  add_evaluate(program, exit_code);
  add_simulate(program, exit_code);
  add_config(program, exit_code);
  CLI11_PARSE(program, argc, argv);
  return exit_code;
}

}  // namespace
}  // namespace mmlins::cli

int main(int argc, char** argv) {
  mmlins::log::set_sink([](mmlins::log::Level level, const std::string& message) {
    fmt::print(stderr, "{}{}\n", level == mmlins::log::Level::kWarning ? "warning: " : "", message);
  });
  return mmlins::cli::run_program(argc, argv);
}

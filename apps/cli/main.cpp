// SPDX-License-Identifier: MIT
// mmlins: LiDAR-inertial SLAM from the command line.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>

#include "commands.hpp"
#include "mmlins/base/log.hpp"

namespace mmlins::cli {

int fail(const Error& error) {
  fmt::print(stderr, "mmlins: {}\n", error.message);
  return error.code == ErrorCode::kInterrupted ? 130 : 1;
}

namespace {

/// What a program ends with when its command line cannot be understood.
constexpr int kUsage = 2;

/// The innermost command that was given, and how to call it.
struct GivenCommand {
  const CLI::App* app;
  std::string words;
};

GivenCommand given_command(const CLI::App* program) {
  GivenCommand given{program, "mmlins"};
  while (!given.app->get_subcommands().empty()) {
    for (const CLI::Option* option : given.app->get_options()) {
      if (option->get_positional() && !option->empty()) given.words += " " + option->results().front();
    }
    given.app = given.app->get_subcommands().front();
    given.words += " " + given.app->get_name();
  }
  return given;
}

/// Which commands there are where one is missing.
std::string missing_command(const CLI::App* app) {
  const std::vector<std::string> unknown = app->remaining();
  std::string what = unknown.empty() ? "give a command:"
                                     : fmt::format("there is no command '{}'; commands are", unknown.front());
  for (const CLI::App* known : app->get_subcommands({})) what += " " + known->get_name();
  return what;
}

/// One line for a command line that cannot be understood.
std::string usage_error(const CLI::App* program, const CLI::Error& error) {
  const auto [app, command] = given_command(program);
  std::string what = error.what();
  if (app == program || what == "A subcommand is required") what = missing_command(app);
  constexpr std::string_view kNoNumber = "Could not convert: ";
  if (what.starts_with(kNoNumber)) what = "not a number: " + what.substr(kNoNumber.size());
  std::replace(what.begin(), what.end(), '\n', ' ');
  return fmt::format("mmlins: {}; see: {} --help\n", what, command);
}

int run_program(int argc, char** argv) {
  CLI::App program{
      "mmlins: LiDAR-inertial odometry and mapping. A recording in, a trajectory and a map out."};
  program.set_version_flag("--version", "mmlins " MMLINS_VERSION);
  program.require_subcommand(1);
  program.failure_message(usage_error);
  int exit_code = 0;
  add_run(program, exit_code);
  add_info(program, exit_code);
  add_evaluate(program, exit_code);
  add_simulate(program, exit_code);
  add_degrade(program, exit_code);
  add_maps(program, exit_code);
  add_view(program, exit_code);
  add_config(program, exit_code);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : kUsage;  // 0: it was asked for help
  }
  return exit_code;
}

}  // namespace
}  // namespace mmlins::cli

int main(int argc, char** argv) {
  // On a terminal the line of progress may stand there: it is erased, and drawn again below the message.
  const char* const line_start = isatty(STDERR_FILENO) != 0 ? "\r\x1b[K" : "";
  mmlins::log::set_sink([line_start](mmlins::log::Level level, const std::string& message) {
    fmt::print(stderr, "{}{}{}\n", line_start, level == mmlins::log::Level::kWarning ? "warning: " : "", message);
  });
  return mmlins::cli::run_program(argc, argv);
}

// SPDX-License-Identifier: MIT
#pragma once
// The commands of the program, one file each. Each adds its options to the program and, when it was
// the one asked for, runs and sets the exit code.

#include <CLI/CLI.hpp>

#include "mmlins/base/result.hpp"

namespace mmlins::cli {

void add_run(CLI::App& program, int& exit_code);
void add_info(CLI::App& program, int& exit_code);
void add_evaluate(CLI::App& program, int& exit_code);
void add_simulate(CLI::App& program, int& exit_code);
void add_degrade(CLI::App& program, int& exit_code);
void add_maps(CLI::App& program, int& exit_code);
void add_view(CLI::App& program, int& exit_code);
void add_config(CLI::App& program, int& exit_code);

/// Prints the one line of an error to standard error. @return the exit code for it
int fail(const Error& error);

}  // namespace mmlins::cli

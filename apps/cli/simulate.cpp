// SPDX-License-Identifier: MIT
#include "commands.hpp"

namespace mmlins::cli {
void add_simulate(CLI::App&, int&) {}
}  // namespace mmlins::cli

// SPDX-License-Identifier: MIT
#include "commands.hpp"

namespace mmlins::cli {
void add_config(CLI::App&, int&) {}
}  // namespace mmlins::cli

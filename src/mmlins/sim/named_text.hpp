// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace mmlins::sim {

/// A file that is built into the program.
struct NamedText {
  std::string name;
  std::string yaml;
};

}  // namespace mmlins::sim

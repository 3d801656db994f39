// SPDX-License-Identifier: MIT
#pragma once
// All values of a config struct as a flat list, each beside its default.

#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"

namespace mmlins::report {

struct Setting {
  std::string path;           ///< "group.key", as for --set
  std::string value;
  std::string default_value;
  std::string unit;
  std::string meaning;

  [[nodiscard]] bool differs() const { return value != default_value; }
};

/// @pre both are the fields of the same type, the second of one that nobody has changed
[[nodiscard]] std::vector<Setting> list_settings(const Fields& fields, const Fields& defaults);

}  // namespace mmlins::report

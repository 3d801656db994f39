// SPDX-License-Identifier: MIT
#pragma once
// One YAML value for one field: checked now, assigned later, so that a refused file changes nothing.

#include <yaml-cpp/yaml.h>

#include <functional>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"

namespace mmlins::config {

using Assignment = std::function<void()>;

/// Checks type, range and length. The error says what is wrong with the value, without naming the key.
/// @param field  not a group, nor a list of groups; must outlive the assignment
[[nodiscard]] Result<Assignment> check_value(const Field& field, const YAML::Node& node);

}  // namespace mmlins::config

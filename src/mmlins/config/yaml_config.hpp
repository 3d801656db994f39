// SPDX-License-Identifier: MIT
#pragma once
// YAML in and out for any struct that has fields(). Unknown keys, wrong types and values out of range
// are refused with file, line and the nearest right name. A refused file leaves the struct untouched.

#include <string>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"

namespace mmlins::config {

/// Sets the given fields from YAML text. Keys that are absent keep their value.
/// @param source  what to call the text in error messages: a file name
[[nodiscard]] Status apply_yaml(const Fields& fields, const std::string& yaml_text,
                                const std::string& source);

/// The same, from a file.
[[nodiscard]] Status apply_yaml_file(const Fields& fields, const std::string& path);

/// Sets one field from "group.key=value", as given on a command line.
[[nodiscard]] Status apply_override(const Fields& fields, const std::string& assignment);

/// All fields with their current values; with comments: meaning, unit and range of each.
/// apply_yaml on the result restores the values exactly.
[[nodiscard]] std::string to_yaml(const Fields& fields, bool with_comments);

}  // namespace mmlins::config

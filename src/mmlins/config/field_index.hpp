// SPDX-License-Identifier: MIT
#pragma once
// The fields of a config struct by their full dotted names, and in words: what a field accepts, and
// which name somebody probably meant.

#include <string>
#include <vector>

#include "mmlins/base/config_fields.hpp"

namespace mmlins::config {

struct NamedField {
  std::string name;  ///< with the groups it is in: "lidar.voxel_size"
  const Field* field = nullptr;
};

/// All fields and groups, in order, each group before its members.
/// @param prefix  goes before every name
[[nodiscard]] std::vector<NamedField> index_fields(const Fields& fields, const std::string& prefix = "");

/// The field of this full name, or nullptr.
[[nodiscard]] const Field* find_field(const std::vector<NamedField>& index, const std::string& name);

/// The name that `name` is most likely a misspelling of; empty if none comes near. A right name in the
/// wrong group counts as near.
[[nodiscard]] std::string nearest_name(const std::vector<NamedField>& index, const std::string& name);

/// The word that `word` is most likely a misspelling of; empty if none comes near.
[[nodiscard]] std::string nearest_word(const std::vector<std::string>& words, const std::string& word);

/// What a field takes, to finish the sentence "accepted: ...": type, range with unit, words.
[[nodiscard]] std::string accepted_values(const Field& field);

/// The range alone, with unit: "0.1 to 5 m"; empty if there is neither.
[[nodiscard]] std::string range_text(const Field& field);

}  // namespace mmlins::config

// SPDX-License-Identifier: MIT
#pragma once
// The tables of the index, and how to tell an index of ours from other files. Internal to atlas/.

#include <array>
#include <string>
#include <string_view>

#include "mmlins/base/result.hpp"

namespace mmlins::atlas {

inline constexpr int kFormatVersion = 1;
inline constexpr int kApplicationId = 0x6d6d6c41;  // "mmlA"

inline constexpr std::array<std::string_view, 6> kTables{"map",     "keyframe", "edge",
                                                         "gravity", "place",    "merge"};

[[nodiscard]] std::string index_path(const std::string& folder);
/// Statements that make the tables and mark the file as ours.
[[nodiscard]] std::string schema_sql();

enum class IndexKind {
  kOurs,     ///< of a version that can be read, as far as its first bytes tell
  kMissing,  ///< no such file
  kEmpty,
  kNewer,    ///< ours, but of a newer format
  kForeign,  ///< a database of another program
  kUnknown,  ///< no database, or one that is damaged at its beginning
};

/// What the first bytes of the index say; the file is not touched.
struct IndexIdentity {
  IndexKind kind = IndexKind::kMissing;
  int version = 0;
};
[[nodiscard]] IndexIdentity identify_index(const std::string& folder);

}  // namespace mmlins::atlas

// SPDX-License-Identifier: MIT
#pragma once
// What a user must know about a run, in plain words, the worst first.

#include <string>
#include <vector>

#include "mmlins/report/report.hpp"

namespace mmlins::report {

enum class Level {
  kGood,
  kNote,     ///< worth knowing
  kWarning,  ///< the result is usable, but not everywhere as good as it looks
  kBad,      ///< part of the result is missing or must not be relied on
};

[[nodiscard]] std::string_view to_string(Level level);

struct Finding {
  Level level = Level::kNote;
  std::string text;
};

struct Findings {
  Finding headline;            ///< one sentence: is all well?
  std::vector<Finding> list;   ///< the worst first; empty if there is nothing to say
};

[[nodiscard]] Findings findings_of(const ReportInput& input);

}  // namespace mmlins::report

// SPDX-License-Identifier: MIT
#pragma once
// What a run writes about its back end. docs/formats.md describes each file.

#include <string>

#include "mmlins/pipeline/slam_system.hpp"

namespace mmlins::pipeline {

/// closures.csv: every pair of places that was examined, with the verdict.
[[nodiscard]] std::string closures_csv(const RunResult& result);
/// merges.json: which maps were joined, and on what evidence.
[[nodiscard]] std::string merges_json(const RunResult& result);

}  // namespace mmlins::pipeline

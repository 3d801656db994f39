// SPDX-License-Identifier: MIT
#pragma once
// The stages of the work, as files and reports name them.

#include <array>

#include "mmlins/pipeline/slam_system.hpp"

namespace mmlins::pipeline {

/// What the work on one scan consists of; the last is the sum.
struct Stage {
  const char* name;
  double (*of)(const ScanRecord&);  ///< [ms]
};
inline constexpr std::array<Stage, 9> kStages{{
    {"read", [](const ScanRecord& r) { return r.read_ms; }},
    {"propagate", [](const ScanRecord& r) { return r.times.propagate; }},
    {"deskew", [](const ScanRecord& r) { return r.times.deskew; }},
    {"downsample", [](const ScanRecord& r) { return r.times.downsample; }},
    {"update", [](const ScanRecord& r) { return r.times.update; }},
    {"health", [](const ScanRecord& r) { return r.times.health; }},
    {"insert", [](const ScanRecord& r) { return r.times.insert; }},
    {"start", [](const ScanRecord& r) { return r.times.start; }},
    {"total", [](const ScanRecord& r) { return r.total_ms(); }},
}};

/// What the work of the back end consists of.
struct BackEndStage {
  const char* name;
  double (*of)(const MappingResult&);  ///< [ms]
};
inline constexpr std::array<BackEndStage, 7> kBackEndStages{{
    {"submaps", [](const MappingResult& r) { return r.times.submaps; }},
    {"describe", [](const MappingResult& r) { return r.times.describe; }},
    {"recognise", [](const MappingResult& r) { return r.times.recognise; }},
    {"search", [](const MappingResult& r) { return r.times.search; }},
    {"verify", [](const MappingResult& r) { return r.times.verify; }},
    {"optimize", [](const MappingResult& r) { return r.times.optimize; }},
    {"rebuild", [](const MappingResult& r) { return r.rebuild_ms; }},
}};

}  // namespace mmlins::pipeline

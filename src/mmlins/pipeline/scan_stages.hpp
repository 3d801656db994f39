// SPDX-License-Identifier: MIT
#pragma once
// The stages of the work on a scan, as files and reports name them; the last is their sum.

#include <array>

#include "mmlins/pipeline/slam_system.hpp"

namespace mmlins::pipeline {

/// What the work on one scan consists of.
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

}  // namespace mmlins::pipeline

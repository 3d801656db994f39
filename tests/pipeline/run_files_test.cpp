// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/run_files.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/atlas/example.hpp"

namespace mmlins::pipeline {
namespace {

RunResult example_run() {
  RunResult result;
  for (int i = 0; i < 3; ++i) {
    ScanRecord scan;
    scan.time = time_from_ns(1'000'000'000LL * (i + 1));
    result.scans.push_back(scan);
    result.mapping.graph.nodes.push_back({i, 0, {}, false});
    if (i > 0) result.mapping.graph.edges.push_back({i - 1, i, {}, math::Matrix6d::Identity()});
  }
  result.mapping.graph.anchors.push_back({0, {}, true});
  return result;
}

TEST(WriteRun, WritesAllElseIfThePoseGraphDoesNotHoldTogether) {
  for (const bool holds_together : {true, false}) {
    const atlas::TemporaryFolder folder;
    RunResult result = example_run();
    if (!holds_together) {
      result.mapping.graph.edges.back().information *= std::nan("");
      result.mapping.error = "the pose graph cannot be optimised";
    }
    const std::string out = folder / "run";
    ASSERT_TRUE(prepare_folder(out).ok());
    const Status written = write_run(out, result, {}, {}, {});
    ASSERT_TRUE(written.ok()) << written.error().message;
    for (const char* name : {"odometry.tum", "trajectory.tum", "map.pcd", "health.csv", "closures.csv",
                             "merges.json", "config.yaml", "rig.yaml", "summary.json"}) {
      EXPECT_TRUE(std::filesystem::exists(out + "/" + name)) << name;
    }
    EXPECT_EQ(std::filesystem::exists(out + "/graph.g2o"), holds_together);
    std::ifstream summary(out + "/summary.json");
    EXPECT_EQ(nlohmann::json::parse(summary)["mapping"]["error"], result.mapping.error);
  }
}

}  // namespace
}  // namespace mmlins::pipeline

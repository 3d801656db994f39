// SPDX-License-Identifier: MIT
#include "mmlins/report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>

#include "mmlins/report/findings.hpp"
#include "mmlins/report/report_data.hpp"
#include "tests/report/example_run.hpp"

namespace mmlins::report {
namespace {

class Report : public testing::Test {
 protected:
  pipeline::RunResult result_ = example_run();
  pipeline::RunSource source_{"some/recording.bag", "/points", "/imu", 2};
  sensor::Rig rig_;
  pipeline::SlamConfig config_;

  ReportInput input() const { return {result_, source_, rig_, config_}; }
  ordered_json data() const {
    const auto data = report_data(input());
    EXPECT_TRUE(data.ok());
    return *data;
  }
};

TEST_F(Report, FiguresAreThoseOfTheRun) {
  const ordered_json figures = data()["figures"];
  EXPECT_EQ(figures["scans"], 100);
  EXPECT_EQ(figures["scans_by_state"]["INITIALIZING"], 10);
  EXPECT_EQ(figures["scans_by_state"]["TRACKING"], 70);
  EXPECT_EQ(figures["scans_by_state"]["BRIDGING"], 10);
  EXPECT_EQ(figures["scans_by_state"]["LOST"], 10);
  EXPECT_DOUBLE_EQ(figures["duration_s"], 9.9);
  EXPECT_NEAR(figures["path_length_m"], 9.9, 1e-12);
  EXPECT_DOUBLE_EQ(figures["real_time_factor"], 0.5 / 9.9);
  EXPECT_EQ(figures["mapping"]["merges"], 1);
  EXPECT_EQ(figures["mapping"]["closures"]["counts"], 1);
  EXPECT_DOUBLE_EQ(figures["stages"]["total"]["mean_ms"], (99 * 4.0 + 31.0) / 100.0);
  EXPECT_DOUBLE_EQ(figures["stages"]["total"]["median_ms"], 4.0);
  EXPECT_DOUBLE_EQ(figures["stages"]["total"]["max_ms"], 31.0);
}

TEST_F(Report, StretchesCoverTheRunWithoutHoles) {
  const ordered_json stretches = data()["stretches"];
  ASSERT_EQ(stretches.size(), 5U);
  int scans = 0;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    if (i > 0) {
      EXPECT_EQ(stretches[i][0], stretches[i - 1][1]);
    }
    scans += stretches[i][5].get<int>();
  }
  EXPECT_EQ(scans, 100);
  EXPECT_NEAR(stretches[2][0], 4.0, 1e-9);  // dark from scan 40 on
  EXPECT_EQ(stretches[2][2], static_cast<int>(odometry::TrackingState::kBridging));
  EXPECT_EQ(stretches[2][3], static_cast<int>(odometry::Cause::kNoPoints));
  EXPECT_NEAR(stretches[4][0], 6.0, 1e-9);
  EXPECT_EQ(stretches[4][4], 1);
}

TEST_F(Report, GapsClosuresAndMergesComeWithTheirEvidence) {
  const ordered_json all = data();
  EXPECT_TRUE(all["maps"][0]["gap"].is_null());
  const ordered_json& gap = all["maps"][1]["gap"];
  EXPECT_NEAR(gap["seconds"], 2.1, 1e-9);
  EXPECT_NEAR(gap["std_position_m"], 0.2, 1e-9);
  EXPECT_EQ(all["maps"][0]["fell_asleep"], "no points");
  const ordered_json& closure = all["closures"][0];
  EXPECT_NEAR(closure["source"]["t"], 8.0, 1e-9);
  EXPECT_NEAR(closure["source"]["x"], 8.0, 1e-9);
  EXPECT_NEAR(closure["source"]["y"], 3.0, 1e-9);
  EXPECT_NEAR(closure["target"]["t"], 2.0, 1e-9);
  EXPECT_EQ(closure["overlap"], 0.75);
  EXPECT_EQ(closure["reason"], result_.mapping.closures[0].reason);
  EXPECT_EQ(all["merges"][0]["id"], 1);  // as the atlas numbers them
  EXPECT_NEAR(all["merges"][0]["moved_m"], 5.0, 1e-9);
  EXPECT_NEAR(all["merges"][0]["t"], 8.2, 1e-9);
}

TEST_F(Report, AClosureOfAnUnknownKeyframeHasNoPlace) {
  result_.mapping.closures[0].source = 7;
  EXPECT_TRUE(data()["closures"][0]["source"].is_null());
}

TEST_F(Report, CurvesHaveNothingWhereNoScanWasMatched) {
  const ordered_json curve = data()["curves"]["t1_std"];
  ASSERT_EQ(curve["y"].size(), 100U);
  EXPECT_EQ(curve["y"][39], 0.003);
  EXPECT_TRUE(curve["y"][40].is_null());
  EXPECT_TRUE(curve["y"][59].is_null());
  EXPECT_EQ(curve["y"][60], 0.003);
}

TEST_F(Report, RoundedNumbersAreShort) {
  EXPECT_EQ(rounded(0.1 + 0.2, 4).dump(), "0.3");
  EXPECT_EQ(rounded(123456.0, 3).dump(), "123000.0");
  EXPECT_EQ(rounded(-0.00123456, 3).dump(), "-0.00123");
  EXPECT_TRUE(rounded(std::nan(""), 3).is_null());
  EXPECT_EQ(rounded(std::numeric_limits<double>::infinity(), 3), 1e9);
}

TEST_F(Report, TheDataInThePageCannotEndItsElement) {
  const auto page = report_html(input());
  ASSERT_TRUE(page.ok());
  const std::string mark = "id=\"data\">";
  const auto begin = page->find(mark) + mark.size();
  const auto parsed = ordered_json::parse(page->substr(begin, page->find("</script>", begin) - begin));
  EXPECT_EQ(parsed["closures"][0]["reason"], "accepted: </script> overlap 0.75");
  EXPECT_EQ(page->find("{{"), std::string::npos) << "a mark was not replaced";
}

TEST_F(Report, ThePageAsksForNothingFromOutside) {
  const auto page = report_html(input());
  ASSERT_TRUE(page.ok());
  EXPECT_FALSE(std::regex_search(*page, std::regex("(src|href)=[\"'](https?:)?//")));
  EXPECT_EQ(page->find("@import"), std::string::npos);
  EXPECT_EQ(page->find("fetch("), std::string::npos);
}

TEST_F(Report, AnHourStaysSmall) {
  result_ = example_run(36000);
  for (int i = 0; i < 36000; ++i) {
    // As bad as it can be: every curve is noise.
    auto& scan = result_.scans[static_cast<std::size_t>(i)];
    scan.times.update = 1.0 + 1e-6 * ((i * 7919LL) % 1000003);
    scan.residual_rms = 1e-8 * ((i * 104729LL) % 1000003);
  }
  const auto page = report_html(input());
  ASSERT_TRUE(page.ok());
  EXPECT_LT(page->size(), 3'000'000U);  // of 8 MB; the picture takes at most the rest
  const ordered_json all = data();
  for (const auto& [name, curve] : all["curves"].items()) EXPECT_LE(curve["t"].size(), 2002U) << name;
}

TEST_F(Report, IsTheSameBytesForTheSameRun) {
  const auto without_memory = [&] {  // the only figure that is not of the run
    ordered_json all = data();
    all["figures"].erase("peak_memory_mib");
    return all.dump();
  };
  EXPECT_EQ(without_memory(), without_memory());
}

TEST_F(Report, APathThatCannotBeWrittenIsOneLine) {
  const Status status = write_report("no/such/folder/report.html", input());
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().message.find("no/such/folder/report.html"), std::string::npos);
  EXPECT_EQ(status.error().message.find('\n'), std::string::npos);
}

TEST_F(Report, SettingsTellWhatDiffersFromTheDefaults) {
  config_.output.map_voxel = 0.35;
  const ordered_json settings = data()["settings"]["config"];
  int changed = 0;
  for (const ordered_json& setting : settings) {
    if (!setting.contains("default")) continue;
    ++changed;
    EXPECT_EQ(setting["key"], "output.map_voxel");
    EXPECT_EQ(setting["value"], "0.35");
    EXPECT_EQ(setting["default"], "0.2");
    EXPECT_EQ(setting["unit"], "m");
  }
  EXPECT_EQ(changed, 1);
}

TEST_F(Report, TruthErrorsAreZeroForTheTruthItself) {
  math::Trajectory truth;
  for (const auto& scan : result_.scans) truth.push_back({scan.time, scan.T_world_imu});
  truth.pop_back();
  const auto comparison = compare_with_truth(result_, truth, "truth.tum");
  ASSERT_TRUE(comparison.ok()) << comparison.error().message;
  EXPECT_LT(comparison->trajectory.absolute.translation.rmse, 1e-9);  // rounding
  ASSERT_EQ(comparison->trajectory_errors.position.size(), 100U);
  EXPECT_LT(comparison->trajectory_errors.position[98], 1e-9);
  EXPECT_TRUE(std::isnan(comparison->trajectory_errors.position[99]));  // no truth there
  EXPECT_EQ(comparison->odometry_errors.position.size(), 100U);  // of a straight line
  EXPECT_LT((comparison->path_world[70] - result_.scans[70].T_world_imu.t).norm(), 1e-9);
}

TEST_F(Report, TruthOfAnotherTimeIsOneLineWithItsName) {
  const math::Trajectory truth{{time_from_ns(1), {}}, {time_from_ns(2), {}}, {time_from_ns(3), {}}};
  const auto comparison = compare_with_truth(result_, truth, "other.tum");
  ASSERT_FALSE(comparison.ok());
  EXPECT_NE(comparison.error().message.find("other.tum"), std::string::npos);
}

TEST_F(Report, HeadlineSaysThatMapsWereJoined) {
  const Findings findings = findings_of(input());
  EXPECT_EQ(findings.headline.text, "The pose was lost once, and both maps were joined again into one.");
  EXPECT_EQ(findings.headline.level, Level::kWarning);
  ASSERT_FALSE(findings.list.empty());
  EXPECT_EQ(findings.list[0].text, "20 of 100 scans, 2.0 s, were carried by the IMU alone: no points (2.0 s).");
}

TEST_F(Report, HeadlineSaysThatMapsStayedApart) {
  result_.mapping.worlds = {0, 1};
  result_.maps[1].gap->covariance *= 1000.0;
  const Findings findings = findings_of(input());
  EXPECT_EQ(findings.headline.level, Level::kBad);
  EXPECT_EQ(findings.headline.text, "The pose was lost once, and not everything was joined again: 2 maps in 2 pieces.");
  EXPECT_NE(findings.list[0].text.find("Map 1 was never recognised"), std::string::npos);
}

TEST_F(Report, HeadlineIsGoodOnlyIfAllIsWell) {
  for (auto& scan : result_.scans) {
    scan.state = odometry::TrackingState::kTracking;
    scan.map_id = 0;
  }
  result_.maps.resize(1);
  result_.mapping.worlds = {0};
  EXPECT_EQ(findings_of(input()).headline.level, Level::kGood);
  result_.read_error = "the file ends in the middle of a chunk";
  EXPECT_EQ(findings_of(input()).headline.level, Level::kBad);
  EXPECT_EQ(findings_of(input()).list[0].level, Level::kBad);
}

TEST_F(Report, AnEndWithoutAPoseIsBad) {
  result_.scans.back().state = odometry::TrackingState::kLost;
  EXPECT_EQ(findings_of(input()).headline.text, "The pose was lost and not found again before the end.");
}

}  // namespace
}  // namespace mmlins::report

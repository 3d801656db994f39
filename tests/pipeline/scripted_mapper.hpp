// SPDX-License-Identifier: MIT
#pragma once
// A mapper whose findings are known beforehand, and that takes as long as a test likes.

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "mmlins/mapping/back_end_mapper.hpp"

namespace mmlins::pipeline {

inline constexpr int kPerMap = 12;  ///< keyframes

inline math::SE3 shift(double x, double y) { return {math::Matrix3d::Identity(), {x, y, 0.0}}; }

/// Knows from the beginning what it is going to find: a closure in each map, whose optimisation moves it;
/// that map 1 belongs to map 0; and, at the end of map 2, that it was not so.
class ScriptedMapper final : public mapping::BackEndMapper {
 public:
  explicit ScriptedMapper(const mapping::MappingConfig& config) : graph_(config.link, config.optimizer) {}

  void begin_map(const mapping::MapBegin& begin) override {
    graph_.begin_map(begin);
    if (before_) before_();
  }
  void add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) override {
    graph_.add(*keyframe, pose_covariance);
    if (before_) before_();
    const int step = keyframe->id % kPerMap;
    if (step == 4)
      submaps_.push_back({keyframe->id - 2, keyframe->map_id, keyframe->id - 4, keyframe->id, {}, {}});
    if (step == 8) close(keyframe->id - 6, keyframe->id, shift(6.0, 0.3));
    if (keyframe->id == kPerMap + 9) merge();
    if (keyframe->id == 2 * kPerMap + 10) undo();
  }
  void bridge(const math::Matrix6d& covariance) override { graph_.bridge(covariance); }
  void end_map() override {}
  [[nodiscard]] const mapping::MapGraph& map_graph() const override { return graph_; }
  [[nodiscard]] const std::vector<mapping::SubmapRecord>& submaps() const override { return submaps_; }
  [[nodiscard]] const std::vector<mapping::Closure>& closures() const override { return closures_; }
  [[nodiscard]] const std::vector<mapping::Merge>& merges() const override { return merges_; }
  [[nodiscard]] int revision() const override { return revision_; }
  [[nodiscard]] mapping::MapperTimes times() const override { return {}; }
  [[nodiscard]] std::string error() const override { return error_; }

  /// Called whenever something has come in.
  std::function<void()> before_;
  std::string error_;

 private:
  void close(int target, int source, const math::SE3& T_target_source) {
    mapping::Closure closure;
    closure.id = static_cast<int>(closures_.size());
    closure.source = source;
    closure.target = target;
    closure.source_map = graph_.map_of(source);
    closure.target_map = graph_.map_of(target);
    closure.T_target_source = T_target_source;
    closure.information = 1e4 * math::Matrix6d::Identity();
    closures_.push_back(closure);
    graph_.add_closure(closure);
    EXPECT_TRUE(graph_.optimize().solved);
    ++revision_;
  }
  void merge() {
    mapping::Merge merge;
    merge.T_before = graph_.T_world_map(1);
    graph_.move_world(1, shift(0.0, 5.0));
    graph_.join(1, 0);
    close(kPerMap - 2, kPerMap + 9, shift(1.0, 2.0));
    merge.world = 1;
    merge.closures = {closures_.back().id};
    merge.T_new_old = shift(0.0, 5.0);
    merges_.push_back(merge);
  }
  void undo() {
    const int map = 1;
    graph_.separate({&map, 1}, merges_.back().T_before);
    merges_.back().undone = Time{};
    merges_.back().why_undone = "it was not so";
    ++revision_;
  }

  mapping::MapGraph graph_;
  std::vector<mapping::SubmapRecord> submaps_;
  std::vector<mapping::Closure> closures_;
  std::vector<mapping::Merge> merges_;
  int revision_ = 0;
};

}  // namespace mmlins::pipeline

// SPDX-License-Identifier: MIT
#pragma once
// The reference: the back end as the MM-LINS paper has it. Scan Context of single keyframes, hits in a row,
// ICP, constant noise, and every fusion is final. docs/math/mapping.md, "After the paper", says where the
// paper is silent or wrong and what was chosen there.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/mapping/context_index.hpp"
#include "mmlins/mapping/hit_run.hpp"
#include "mmlins/mapping/point_icp.hpp"

namespace mmlins::mapping {

class PaperMapper final : public BackEndMapper {
 public:
  /// @param store  where the keyframes are, each before it is added here
  PaperMapper(const MappingConfig& config, keyframe::KeyframeStore& store);

  void begin_map(const MapBegin& begin) override;
  void add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) override;
  void bridge(const math::Matrix6d& covariance) override;
  void end_map() override;

  [[nodiscard]] const MapGraph& map_graph() const override { return graph_; }
  /// None: places are recognised by keyframes.
  [[nodiscard]] const std::vector<SubmapRecord>& submaps() const override { return no_submaps_; }
  [[nodiscard]] const std::vector<Closure>& closures() const override { return closures_; }
  [[nodiscard]] const std::vector<Merge>& merges() const override { return merges_; }
  [[nodiscard]] int revision() const override { return revision_; }
  [[nodiscard]] MapperTimes times() const override { return times_; }
  [[nodiscard]] std::string error() const override { return error_; }

 private:
  /// Points around a keyframe, ready for ICP.
  struct Surroundings {
    math::SE3 T_keyframe_points;
    std::vector<Eigen::Vector3f> points;
  };

  void detect_loop(int keyframe, const place::ScanContext& context);
  void detect_similarity(int keyframe, const place::ScanContext& context);
  /// @return false if the initial transform does not fit
  bool fuse(int sleeping_map, const HitRun& pairs);
  /// Registers the keyframes of a pair and files the verdict.
  /// @param T_target_source  the guess
  /// @return the number of its closure, refused or not; none if points cannot be read
  std::optional<std::size_t> examine(const SimilarPair& pair, const math::SE3& T_target_source,
                                     const IcpConfig& icp);
  [[nodiscard]] std::optional<Surroundings> around(int keyframe);
  /// T_target_source as the graph has it.
  [[nodiscard]] math::SE3 predicted(const SimilarPair& pair) const;
  void use(std::size_t closure);
  void optimize();

  PaperFusionConfig config_;
  MapGraph graph_;
  ContextIndex contexts_;
  keyframe::KeyframeStore& store_;
  std::map<int, HitRun> runs_;  ///< of the active map, for each sleeping map
  std::vector<SubmapRecord> no_submaps_;
  std::vector<Closure> closures_;
  std::vector<Merge> merges_;
  MapperTimes times_;
  Time now_;
  int revision_ = 0;
  std::string error_;
  int latest_map_ = -1;
  int quiet_until_ = 0;  ///< keyframe from which on loops are sought again
};

}  // namespace mmlins::mapping

// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/mapping_files.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mmlins/pipeline/run_files.hpp"

namespace mmlins::pipeline {
namespace {

using nlohmann::ordered_json;

ordered_json to_json(const math::SE3& T) {
  const Eigen::Quaterniond q = T.quaternion();
  return {{"x", T.t.x()}, {"y", T.t.y()}, {"z", T.t.z()}, {"qx", q.x()}, {"qy", q.y()}, {"qz", q.z()}, {"qw", q.w()}};
}

}  // namespace

std::string closures_csv(const RunResult& result) {
  std::string text =
      "id,time,source,target,source_map,target_map,origin,state,score,overlap,residual_rms_m,moved_m,turned_rad,"
      "x,y,z,qx,qy,qz,qw,reason\n";
  for (const mapping::Closure& c : result.mapping.closures) {
    const math::SE3& T = c.T_target_source;
    const Eigen::Quaterniond q = T.quaternion();
    text += fmt::format("{},{},{},{},{},{},{},{},{:.3f},{:.3f},{:.4f},{:.4f},{:.5f},", c.id, stamp(c.time), c.source, c.target,
                        c.source_map, c.target_map, to_string(c.origin), to_string(c.state), c.score, c.overlap, c.residual_rms,
                        c.moved, c.turned);
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.8f},{:.8f},{:.8f},{:.8f},\"{}\"\n", T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(),
                        q.z(), q.w(), c.reason);
  }
  return text;
}

std::string merges_json(const RunResult& result) {
  ordered_json merges = ordered_json::array();
  for (const mapping::Merge& merge : result.mapping.merges) {
    ordered_json evidence = ordered_json::array();
    for (const auto* ids : {&merge.closures, &merge.enhancing}) {
      for (const int id : *ids) {
        const mapping::Closure& c = result.mapping.closures[static_cast<std::size_t>(id)];
        evidence.push_back({{"closure", id}, {"enhancing", ids == &merge.enhancing}, {"origin", std::string(to_string(c.origin))},
                            {"state", std::string(to_string(c.state))}, {"overlap", c.overlap}, {"residual_rms_m", c.residual_rms}});
      }
    }
    merges.push_back({{"id", merge.number()},
                      {"time", stamp(merge.time)},
                      {"map", merge.world},
                      {"into", merge.into},
                      {"motion_between_was_known", merge.prior_known},
                      {"moved_by", to_json(merge.T_new_old)},
                      {"evidence", std::move(evidence)}});
    if (merge.undone) merges.back()["undone"] = {{"time", stamp(*merge.undone)}, {"why", merge.why_undone}};
  }
  return merges.dump(2) + "\n";
}

}  // namespace mmlins::pipeline

// SPDX-License-Identifier: MIT
#include <iterator>

#include "mmlins/base/text_file.hpp"
#include "mmlins/graph/g2o.hpp"
#include "mmlins/graph/g2o_information.hpp"
#include "mmlins/graph/graph_index.hpp"

namespace mmlins::graph {
namespace {

/// Numbers are written with the fewest digits from which the same double is read again.
void append_pose(const SE3& T, std::string& text) {
  const Eigen::Quaterniond q = T.quaternion();
  fmt::format_to(std::back_inserter(text), " {} {} {} {} {} {} {}", T.t.x(), T.t.y(), T.t.z(), q.x(), q.y(),
                 q.z(), q.w());
}

void append_information(const Matrix6d& information, std::string& text) {
  const Matrix6d g2o = to_g2o_information(information);
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      fmt::format_to(std::back_inserter(text), " {}", g2o(row, column));
    }
  }
}

}  // namespace

Result<std::string> format_g2o(const PoseGraph& graph) {
  const Result<GraphIndex> index = index_graph(graph);
  if (!index) return index.error();
  const std::vector<SE3> poses = world_poses(graph, *index);
  std::string text;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "VERTEX_SE3:QUAT {}", graph.nodes[i].id);
    append_pose(poses[i], text);
    text += '\n';
  }
  for (const Node& node : graph.nodes) {
    if (node.held) fmt::format_to(std::back_inserter(text), "FIX {}\n", node.id);
  }
  for (const Edge& edge : graph.edges) {
    fmt::format_to(std::back_inserter(text), "EDGE_SE3:QUAT {} {}", edge.from, edge.to);
    append_pose(edge.T_from_to, text);
    append_information(edge.information, text);
    text += '\n';
  }
  return text;
}

Status write_g2o(const std::string& path, const PoseGraph& graph) {
  const Result<std::string> text = format_g2o(graph);
  if (!text) return text.error();
  return write_text_file(path, *text);
}

}  // namespace mmlins::graph

// SPDX-License-Identifier: MIT
#include <array>
#include <charconv>
#include <cmath>
#include <unordered_map>
#include <vector>

#include "mmlins/base/text_file.hpp"
#include "mmlins/graph/g2o.hpp"
#include "mmlins/graph/g2o_information.hpp"
#include "mmlins/graph/residuals.hpp"

namespace mmlins::graph {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr double kQuaternionTolerance = 0.1;  ///< a quaternion whose length is farther from 1 is a mistake
constexpr std::size_t kNumPose = 7;
constexpr std::size_t kNumInformation = 21;

using Words = std::vector<std::string_view>;

Words split_words(std::string_view line) {
  Words words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

template <typename Number>
bool parse_number(std::string_view word, Number& number) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  return error == std::errc{} && end == word.data() + word.size();
}

Result<std::int64_t> parse_id(std::string_view word) {
  std::int64_t id = 0;
  if (!parse_number(word, id)) return make_error(ErrorCode::kInvalid, "\"{}\" is not an integer id", word);
  return id;
}

Result<std::vector<double>> parse_numbers(const Words& words, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < words.size(); ++i) {
    double number = 0.0;
    if (!parse_number(words[i], number) || !std::isfinite(number)) {
      return make_error(ErrorCode::kInvalid, "\"{}\" is not a finite number", words[i]);
    }
    numbers.push_back(number);
  }
  return numbers;
}

Result<SE3> make_pose(const std::vector<double>& numbers) {
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (!(std::abs(q.norm() - 1.0) < kQuaternionTolerance)) {
    return make_error(ErrorCode::kInvalid, "quaternion of length {:.3g}; a pose is \"x y z qx qy qz qw\"",
                      q.norm());
  }
  return SE3{q.normalized().toRotationMatrix(), {numbers[0], numbers[1], numbers[2]}};
}

Result<Matrix6d> make_information(const std::vector<double>& numbers) {
  Matrix6d g2o_order;
  std::size_t next = kNumPose;
  for (int row = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column) {
      g2o_order(row, column) = g2o_order(column, row) = numbers[next++];
    }
  }
  const Matrix6d information = from_g2o_information(g2o_order);
  if (!is_information(information)) {
    return make_error(ErrorCode::kInvalid,
                      "the information matrix has negative eigenvalues; it must have none");
  }
  return information;
}

class G2oParser {
 public:
  Status parse_line(const Words& words, int line) {
    if (words[0] == "VERTEX_SE3:QUAT") return parse_vertex(words);
    if (words[0] == "EDGE_SE3:QUAT") return parse_edge(words, line);
    if (words[0] == "FIX") return parse_fix(words, line);
    return make_error(ErrorCode::kUnsupported,
                      "\"{}\" is not supported; VERTEX_SE3:QUAT, EDGE_SE3:QUAT and FIX are", words[0]);
  }

  /// Edges and FIX may stand before the vertices they name, so that these are only looked up at the end.
  Result<PoseGraph> finish(const std::string& source) {
    if (graph_.nodes.empty()) {
      return make_error(ErrorCode::kInvalid, "{}: holds no VERTEX_SE3:QUAT; give a 3D pose graph", source);
    }
    for (const auto& [id, line] : fixed_) {
      const auto node = position_.find(id);
      if (node == position_.end()) return unknown_vertex(source, line, id);
      graph_.nodes[node->second].held = true;
    }
    for (const Edge& edge : graph_.edges) {
      for (const std::int64_t id : {edge.from, edge.to}) {
        if (position_.count(id) == 0) return unknown_vertex(source, edge.provenance, id);
      }
    }
    graph_.anchors = {{.map = 0, .T_world_map = {}, .fixed = true}};
    return std::move(graph_);
  }

 private:
  static Error unknown_vertex(const std::string& source, std::int64_t line, std::int64_t id) {
    return make_error(ErrorCode::kInvalid, "{}:{}: there is no vertex {} in the file", source, line, id);
  }

  Status parse_vertex(const Words& words) {
    if (words.size() != 2 + kNumPose) {
      return make_error(ErrorCode::kInvalid, "a vertex has 8 values (id x y z qx qy qz qw), not {}",
                        words.size() - 1);
    }
    const Result<std::int64_t> id = parse_id(words[1]);
    if (!id) return id.error();
    const Result<std::vector<double>> numbers = parse_numbers(words, 2);
    if (!numbers) return numbers.error();
    const Result<SE3> pose = make_pose(*numbers);
    if (!pose) return pose.error();
    if (!position_.emplace(*id, graph_.nodes.size()).second) {
      return make_error(ErrorCode::kInvalid, "vertex {} is there twice", *id);
    }
    graph_.nodes.push_back({.id = *id, .map = 0, .T_map_node = *pose});
    return {};
  }

  Status parse_edge(const Words& words, int line) {
    if (words.size() != 3 + kNumPose + kNumInformation) {
      return make_error(ErrorCode::kInvalid,
                        "an edge has 30 values (two ids, x y z qx qy qz qw, 21 of the information), not {}",
                        words.size() - 1);
    }
    const Result<std::int64_t> from = parse_id(words[1]);
    if (!from) return from.error();
    const Result<std::int64_t> to = parse_id(words[2]);
    if (!to) return to.error();
    if (*from == *to) return make_error(ErrorCode::kInvalid, "the edge joins vertex {} to itself", *from);
    const Result<std::vector<double>> numbers = parse_numbers(words, 3);
    if (!numbers) return numbers.error();
    const Result<SE3> pose = make_pose(*numbers);
    if (!pose) return pose.error();
    const Result<Matrix6d> information = make_information(*numbers);
    if (!information) return information.error();
    const bool odometry = *to == *from + 1;
    graph_.edges.push_back({.from = *from,
                            .to = *to,
                            .T_from_to = *pose,
                            .information = *information,
                            .kind = odometry ? EdgeKind::kOdometry : EdgeKind::kLoop,
                            .robust = !odometry,
                            .provenance = line});
    return {};
  }

  Status parse_fix(const Words& words, int line) {
    for (std::size_t i = 1; i < words.size(); ++i) {
      const Result<std::int64_t> id = parse_id(words[i]);
      if (!id) return id.error();
      fixed_.emplace_back(*id, line);
    }
    return {};
  }

  PoseGraph graph_;
  std::unordered_map<std::int64_t, std::size_t> position_;
  std::vector<std::pair<std::int64_t, int>> fixed_;  ///< id and line
};

}  // namespace

Result<PoseGraph> parse_g2o(std::string_view text, const std::string& source) {
  G2oParser parser;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const Words words = split_words(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (words.empty() || words[0][0] == '#') continue;
    const Status status = parser.parse_line(words, line);
    if (!status) return make_error(status.error().code, "{}:{}: {}", source, line, status.error().message);
  }
  return parser.finish(source);
}

Result<PoseGraph> read_g2o(const std::string& path) {
  const Result<std::string> text = read_text_file(path);
  if (!text) return text.error();
  return parse_g2o(*text, path);
}

}  // namespace mmlins::graph

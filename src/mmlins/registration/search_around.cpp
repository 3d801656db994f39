// SPDX-License-Identifier: MIT
#include "mmlins/registration/search_around.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <queue>
#include <tuple>

#include "mmlins/registration/fit_height.hpp"
#include "mmlins/registration/structure_grid.hpp"

namespace mmlins::registration {

namespace {

using math::SE3;
using math::Vector3d;

constexpr int kNumLevels = 6;      // windows of up to 32 cells
constexpr int kMaxColumns = 1500;  // of the source, the highest ones

/// A square of 2^level shifts from (x, y) on, all with one yaw; its score bounds those of all in it.
struct Node {
  float score;
  int level, yaw, x, y;
};

struct LowerScore {  // with a full order, so that equal scores come in the same order everywhere
  bool operator()(const Node& a, const Node& b) const {
    const auto rank = [](const Node& n) { return std::tuple(n.score, -n.level, n.yaw, n.x, n.y); };
    return rank(a) < rank(b);
  }
};
using Queue = std::priority_queue<Node, std::vector<Node>, LowerScore>;

/// Columns of the source turned to one heading, in cells of the target.
struct TurnedColumn {
  int x, y;
  float weight;
};

std::vector<keyframe::Column> strongest(std::vector<keyframe::Column> columns) {
  std::stable_sort(columns.begin(), columns.end(),
                   [](const auto& a, const auto& b) { return a.structure > b.structure; });
  const auto last =
      std::find_if(columns.begin(), columns.end(), [](const auto& c) { return c.structure <= 0.0F; });
  columns.erase(last, columns.end());
  if (columns.size() > kMaxColumns) columns.resize(kMaxColumns);
  return columns;
}

class Search {
 public:
  Search(const std::vector<keyframe::Column>& source, const std::vector<keyframe::Column>& target,
         const SearchRegion& region, const SearchConfig& config)
      : config_(config), region_(region), grid_(target, config.view, kNumLevels), source_(source) {
    for (const keyframe::Column& column : source_) total_ += column.structure;
  }

  std::vector<Start> run(const SE3& T_guess) {
    guess_ = T_guess.t.head<2>();
    const double yaw = std::atan2(T_guess.R(1, 0) - T_guess.R(0, 1), T_guess.R(0, 0) + T_guess.R(1, 1));
    const double step = config_.yaw_step_deg * std::numbers::pi / 180.0;
    const int turns = static_cast<int>(std::ceil(region_.yaw / step));
    Queue queue;
    for (int k = -turns; k <= turns; ++k) {
      yaws_.push_back(yaw + k * step);
      turned_.push_back(turn(yaws_.back()));
      push_roots(queue, static_cast<int>(yaws_.size()) - 1);
    }
    return best_of(queue);
  }

 private:
  [[nodiscard]] std::vector<TurnedColumn> turn(double yaw) const {
    const Eigen::Rotation2Df R(static_cast<float>(yaw));
    std::vector<TurnedColumn> turned;
    for (const keyframe::Column& column : source_) {
      const Eigen::Vector2f p = R * column.place + guess_.cast<float>();
      turned.push_back(
          {grid_.cell_of(p.x()), grid_.cell_of(p.y()), column.structure / static_cast<float>(total_)});
    }
    return turned;
  }

  [[nodiscard]] float score(int level, int yaw, int x, int y) const {
    float sum = 0.0F;
    for (const TurnedColumn& column : turned_[static_cast<std::size_t>(yaw)]) {
      sum += column.weight * grid_.bound(level, column.x + x, column.y + y);
    }
    return sum;
  }

  void push(Queue& queue, int level, int yaw, int x, int y) const {
    const float bound = score(level, yaw, x, y);
    if (bound >= static_cast<float>(config_.min_score)) queue.push({bound, level, yaw, x, y});
  }

  void push_roots(Queue& queue, int yaw) const {
    const int reach_x = static_cast<int>(std::ceil(region_.semi_axis_x / config_.view.cell));
    const int reach_y = static_cast<int>(std::ceil(region_.semi_axis_y / config_.view.cell));
    constexpr int kStep = 1 << (kNumLevels - 1);
    for (int x = -reach_x; x <= reach_x; x += kStep) {
      for (int y = -reach_y; y <= reach_y; y += kStep) push(queue, kNumLevels - 1, yaw, x, y);
    }
  }

  [[nodiscard]] bool is_inside(int x, int y) const {
    const double u = x * config_.view.cell / std::max(region_.semi_axis_x, config_.view.cell);
    const double v = y * config_.view.cell / std::max(region_.semi_axis_y, config_.view.cell);
    return u * u + v * v <= 1.0;
  }

  [[nodiscard]] Start start_of(const Node& node) const {
    const Eigen::Vector2d t = guess_ + config_.view.cell * Eigen::Vector2d(node.x, node.y);
    return {{math::so3_exp(Vector3d(0, 0, yaws_[static_cast<std::size_t>(node.yaw)])), {t.x(), t.y(), 0.0}},
            node.score};
  }

  [[nodiscard]] bool is_new(const Start& start, const std::vector<Start>& starts) const {
    return std::none_of(starts.begin(), starts.end(), [&](const Start& other) {
      const SE3 T = other.T_target_source.inverse() * start.T_target_source;
      return T.t.norm() < config_.apart &&
             math::so3_log(T.R).norm() < config_.apart_deg * std::numbers::pi / 180.0;
    });
  }

  /// Nodes come in the order of their bounds, so a leaf that comes is better than all that is left.
  std::vector<Start> best_of(Queue& queue) const {
    std::vector<Start> starts;
    for (int n = 0; !queue.empty() && n < config_.max_nodes; ++n) {
      const Node node = queue.top();
      queue.pop();
      if (node.level == 0) {
        const Start start = start_of(node);
        if (is_inside(node.x, node.y) && is_new(start, starts)) starts.push_back(start);
        if (static_cast<int>(starts.size()) >= config_.num_starts) break;
        continue;
      }
      const int half = 1 << (node.level - 1);
      for (const int dx : {0, half}) {
        for (const int dy : {0, half}) push(queue, node.level - 1, node.yaw, node.x + dx, node.y + dy);
      }
    }
    return starts;
  }

  const SearchConfig& config_;
  const SearchRegion& region_;
  StructureGrid grid_;
  const std::vector<keyframe::Column>& source_;
  double total_ = 0.0;
  Eigen::Vector2d guess_ = Eigen::Vector2d::Zero();
  std::vector<double> yaws_;
  std::vector<std::vector<TurnedColumn>> turned_;
};

}  // namespace

Fields SearchConfig::fields() {
  return {
      group("view", view, "the views from above that are compared"),
      field("yaw_step_deg", yaw_step_deg, "deg", {0.2, 30.0}, "between the headings that are tried"),
      field("num_starts", num_starts, "", {1.0, 50.0}, "places to return, at most"),
      field("apart", apart, "m", {0.0, 50.0}, "two places nearer than this and `apart_deg` are one"),
      field("apart_deg", apart_deg, "deg", {0.0, 180.0}, "the same for headings"),
      field("min_score", min_score, "", {0.0, 1.0}, "share of the structure that must meet structure"),
      field("max_nodes", max_nodes, "", {1000.0, 1e9}, "steps after which the search gives up"),
  };
}

std::vector<Start> search_around(const keyframe::Submap& source, const keyframe::Submap& target,
                                 const SE3& T_guess, const SearchRegion& region, const SearchConfig& config) {
  const auto target_columns = keyframe::columns_of(target, config.view);
  const auto standing = strongest(keyframe::columns_of(source, config.view));
  if (standing.empty()) return {};
  std::vector<Start> starts = Search(standing, target_columns, region, config).run(T_guess);
  for (Start& start : starts) {
    start.T_target_source.t.z() = T_guess.t.z();
    start.T_target_source = fit_height(source, target, start.T_target_source, region.height);
  }
  return starts;
}

}  // namespace mmlins::registration

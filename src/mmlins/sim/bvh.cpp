// SPDX-License-Identifier: MIT
#include "mmlins/sim/bvh.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace mmlins::sim {

namespace {

using Eigen::AlignedBox3d;

constexpr int kShapesPerLeaf = 2;
constexpr std::size_t kStackSize =
    128;                          // more than twice the depth of any tree that build() makes of a scene
constexpr double kMargin = 2e-3;  // around the bounds of a node [m]

using Shapes = std::vector<Shape>::iterator;

AlignedBox3d bounds_of(Shapes begin, Shapes end) {
  AlignedBox3d bounds;
  for (auto shape = begin; shape != end; ++shape) bounds.extend(bounds_of(*shape));
  return bounds;
}

double area_of(const AlignedBox3d& box) {
  const Eigen::Vector3d s = box.sizes();
  return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
}

void sort_along(int axis, Shapes begin, Shapes end) {
  std::stable_sort(begin, end,
                   [axis](const Shape& a, const Shape& b) { return a.center(axis) < b.center(axis); });
}

struct Split {
  double cost = std::numeric_limits<double>::infinity();
  int axis = 0;
  int left = 1;  // number of shapes
};

// The surface area heuristic: a ray meets a box in proportion to its surface.
Split best_split(Shapes begin, Shapes end) {
  const auto count = static_cast<int>(end - begin);
  Split best;
  for (int axis = 0; axis < 3; ++axis) {
    sort_along(axis, begin, end);
    std::vector<double> right_areas(static_cast<std::size_t>(count));
    AlignedBox3d right;
    for (int i = count - 1; i > 0; --i) {
      right.extend(bounds_of(begin[i]));
      right_areas[static_cast<std::size_t>(i)] = area_of(right);
    }
    AlignedBox3d left;
    for (int i = 1; i < count; ++i) {
      left.extend(bounds_of(begin[i - 1]));
      const double cost = i * area_of(left) + (count - i) * right_areas[static_cast<std::size_t>(i)];
      if (cost < best.cost) best = {cost, axis, i};
    }
  }
  return best;
}

}  // namespace

struct Bvh::FlatRay {
  Eigen::Array4f origin;
  Eigen::Array4f inverse;  // 1 / direction; the fourth element is unused
};

Bvh::Bvh(std::vector<Shape> shapes) : shapes_(std::move(shapes)) {
  if (!shapes_.empty()) build(0, static_cast<int>(shapes_.size()));
}

void Bvh::build(int first, int count) {
  const auto begin = shapes_.begin() + first;
  const AlignedBox3d bounds = bounds_of(begin, begin + count);
  const std::size_t index = nodes_.size();
  Node node{Eigen::Array4f::Zero(), Eigen::Array4f::Zero(), first, count, 0};
  node.min.head<3>() = (bounds.min().array() - kMargin).cast<float>();
  node.max.head<3>() = (bounds.max().array() + kMargin).cast<float>();
  nodes_.push_back(node);
  if (count <= kShapesPerLeaf) return;

  const Split split = best_split(begin, begin + count);
  sort_along(split.axis, begin, begin + count);
  build(first, split.left);
  nodes_[index].first = static_cast<int>(nodes_.size());
  nodes_[index].count = 0;
  nodes_[index].axis = split.axis;
  build(first + split.left, count - split.left);
}

// Where the ray enters the node's box, or infinity.
inline float Bvh::entry_range(const Node& node, const FlatRay& ray) {
  const Eigen::Array4f a = (node.min - ray.origin) * ray.inverse;
  const Eigen::Array4f b = (node.max - ray.origin) * ray.inverse;
  const Eigen::Array4f near = a.min(b);
  const Eigen::Array4f far = a.max(b);
  const float enter = std::max(std::max(0.0F, near(0)), std::max(near(1), near(2)));
  const float leave = std::min(far(0), std::min(far(1), far(2)));
  return enter <= leave ? enter : std::numeric_limits<float>::infinity();
}

std::optional<Bvh::Hit> Bvh::first_hit(const Ray& ray, double max_range) const {
  if (nodes_.empty()) return std::nullopt;
  FlatRay flat{Eigen::Array4f::Zero(), Eigen::Array4f::Zero()};
  flat.origin.head<3>() = ray.origin.cast<float>().array();
  // Something tiny instead of zero, so that no 0 * infinity arises.
  flat.inverse.head<3>() = ray.direction.array().unaryExpr(
      [](double d) { return static_cast<float>(1.0 / (std::abs(d) < 1e-20 ? 1e-20 : d)); });
  Hit best{max_range, -1, 0};
  std::array<std::pair<int, float>, kStackSize> stack;  // nodes still to visit, with their entry ranges
  std::size_t size = 0;
  stack[size++] = {0, entry_range(nodes_[0], flat)};
  while (size > 0) {
    const auto [index, entry] = stack[--size];
    if (static_cast<double>(entry) >= best.range) continue;
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    for (int i = node.first; i < node.first + node.count; ++i) {
      const auto hit = intersect(shapes_[static_cast<std::size_t>(i)], ray);
      if (hit && hit->range < best.range) best = {hit->range, i, hit->face};
    }
    if (node.count > 0) continue;
    // The nearer child is pushed last, to be visited first.
    int near = index + 1;
    int far = node.first;
    if (ray.direction(node.axis) < 0.0) std::swap(near, far);
    for (const int child : {far, near}) {
      const float enter = entry_range(nodes_[static_cast<std::size_t>(child)], flat);
      if (static_cast<double>(enter) < best.range && size < kStackSize) stack[size++] = {child, enter};
    }
  }
  if (best.shape < 0) return std::nullopt;
  return best;
}

}  // namespace mmlins::sim

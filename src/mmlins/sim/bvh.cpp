// SPDX-License-Identifier: MIT
#include "mmlins/sim/bvh.hpp"

#include <algorithm>
#include <array>

namespace mmlins::sim {

namespace {

constexpr int kShapesPerLeaf = 2;
constexpr int kMaxDepth = 64;  // halving at every level, this suffices for any number of shapes

// Range at which the ray enters the box, or infinity. `inverse` holds 1 / direction.
double entry_range(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& origin, const Eigen::Vector3d& inverse) {
  const Eigen::Array3d a = (box.min() - origin).array() * inverse.array();
  const Eigen::Array3d b = (box.max() - origin).array() * inverse.array();
  const double enter = std::max(0.0, a.min(b).maxCoeff());
  return enter <= a.max(b).minCoeff() ? enter : std::numeric_limits<double>::infinity();
}

// 1 / direction, with zero replaced by something tiny, so that no 0 * infinity arises.
Eigen::Vector3d safe_inverse(const Eigen::Vector3d& direction) {
  return direction.unaryExpr([](double d) { return 1.0 / (d == 0.0 ? 1e-300 : d); });
}

}  // namespace

Bvh::Bvh(std::vector<Shape> shapes) : shapes_(std::move(shapes)) {
  if (!shapes_.empty()) build(0, static_cast<int>(shapes_.size()));
}

void Bvh::build(int first, int count) {
  const auto begin = shapes_.begin() + first;
  Eigen::AlignedBox3d bounds;
  Eigen::AlignedBox3d centers;
  for (int i = 0; i < count; ++i) {
    bounds.extend(bounds_of(begin[i]));
    centers.extend(begin[i].center);
  }
  int axis = 0;
  centers.sizes().maxCoeff(&axis);
  const auto node = static_cast<std::size_t>(nodes_.size());
  nodes_.push_back({bounds, first, count, axis});
  if (count <= kShapesPerLeaf) return;

  const int half = count / 2;
  std::stable_sort(begin, begin + count, [axis](const Shape& a, const Shape& b) { return a.center(axis) < b.center(axis); });
  build(first, half);
  nodes_[node].first = static_cast<int>(nodes_.size());
  nodes_[node].count = 0;
  build(first + half, count - half);
}

std::optional<Bvh::Hit> Bvh::first_hit(const Ray& ray, double max_range) const {
  if (nodes_.empty()) return std::nullopt;
  const Eigen::Vector3d inverse = safe_inverse(ray.direction);
  Hit best{max_range, -1, 0};
  std::array<std::pair<int, double>, kMaxDepth> stack;  // nodes still to visit, with their entry ranges
  std::size_t size = 0;
  stack[size++] = {0, entry_range(nodes_[0].bounds, ray.origin, inverse)};
  while (size > 0) {
    const auto [index, entry] = stack[--size];
    if (entry >= best.range) continue;
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
      const double enter = entry_range(nodes_[static_cast<std::size_t>(child)].bounds, ray.origin, inverse);
      if (enter < best.range) stack[size++] = {child, enter};
    }
  }
  if (best.shape < 0) return std::nullopt;
  return best;
}

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#pragma once
// Finds the first shape on a ray: a tree of bounding boxes over the shapes of a scene.

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "mmlins/sim/shape.hpp"

namespace mmlins::sim {

class Bvh {
 public:
  struct Hit {
    double range = std::numeric_limits<double>::infinity();  ///< [m]
    int shape = 0;                                           ///< index into shapes()
    int face = 0;
  };

  /// Keeps the shapes, in an order of its own.
  explicit Bvh(std::vector<Shape> shapes);

  /// The nearest shape that the ray enters within `max_range`.
  [[nodiscard]] std::optional<Hit> first_hit(const Ray& ray, double max_range) const;
  [[nodiscard]] const std::vector<Shape>& shapes() const { return shapes_; }

 private:
  struct Node {
    Eigen::Array4f min, max;  // a little larger than the content, because single precision rounds [m]
    int first = 0;            // leaf: first shape; inner node: its right child, the left one is the next node
    int count = 0;            // number of shapes of a leaf; 0 for an inner node
    int axis = 0;             // along which the children are separated
  };
  struct FlatRay;
  [[nodiscard]] static float entry_range(const Node& node, const FlatRay& ray);
  void build(int first, int count);

  std::vector<Shape> shapes_;
  std::vector<Node> nodes_;
};

}  // namespace mmlins::sim

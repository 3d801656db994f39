// SPDX-License-Identifier: MIT
#include "mmlins/sim/cloud_world.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "mmlins/io/pcd_file.hpp"
#include "mmlins/io/ply_file.hpp"

namespace mmlins::sim {

namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr double kClosingRadius = 0.87;  // half the diagonal of a cube, as a share of its edge
constexpr int kFewestPoints = 5;         // in a cube and its neighbours

using Cell = std::array<std::int32_t, 3>;

/// Sums over the points of one cube, counted from the first point of the cloud.
struct Moments {
  Cell cell{};
  int count = 0;
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();

  void add(const Moments& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
};

/// One entry per cube, in the order of the cubes.
std::vector<Moments> gather(std::span<const Eigen::Vector3f> points, const Vector3d& zero, double spacing) {
  constexpr double kMostCells = std::numeric_limits<std::int32_t>::max() / 2;
  std::vector<std::pair<Cell, std::size_t>> places;  // of every point
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d scaled = (points[i].cast<double>() - zero) / spacing;
    if (!(scaled.cwiseAbs().maxCoeff() < kMostCells)) continue;  // also if it is not a number
    const auto number = [&](int axis) { return static_cast<std::int32_t>(std::floor(scaled(axis))); };
    places.push_back({{number(0), number(1), number(2)}, i});
  }
  std::sort(places.begin(), places.end());
  std::vector<Moments> cubes;
  for (const auto& [cell, i] : places) {
    if (cubes.empty() || cubes.back().cell != cell) cubes.push_back({cell});
    const Vector3d p = points[i].cast<double>() - zero;
    cubes.back().add({cell, 1, p, p * p.transpose()});
  }
  return cubes;
}

/// The cube with its 26 neighbours.
Moments neighbourhood(const std::vector<Moments>& cubes, const Cell& cell) {
  Moments sum{cell};
  for (std::int32_t dx = -1; dx <= 1; ++dx) {
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      // The three cubes above each other are next to each other in the order.
      const Cell lowest{cell[0] + dx, cell[1] + dy, cell[2] - 1};
      auto cube = std::lower_bound(cubes.begin(), cubes.end(), lowest,
                                   [](const Moments& m, const Cell& c) { return m.cell < c; });
      for (; cube != cubes.end() && cube->cell[0] == lowest[0] && cube->cell[1] == lowest[1] &&
             cube->cell[2] <= cell[2] + 1;
           ++cube) {
        sum.add(*cube);
      }
    }
  }
  return sum;
}

bool is_finite(const Eigen::Vector3f& p) { return p.allFinite(); }

Result<std::vector<Eigen::Vector3f>> read_cloud(const std::string& path) {
  if (path.empty()) {
    return make_error(ErrorCode::kInvalid,
                      "world.scene cloud needs a point cloud: set world.file to a .pcd or .ply file");
  }
  if (path.ends_with(".ply")) return io::read_ply(path);
  if (!path.ends_with(".pcd"))
    return make_error(ErrorCode::kUnsupported, "{}: a world is made from a .pcd or .ply file", path);
  auto cloud = io::read_pcd(path);
  if (!cloud) return cloud.error();
  return std::move(cloud->points);
}

}  // namespace

std::vector<Disc> discs_of(std::span<const Eigen::Vector3f> points, const CloudDiscs& config) {
  const auto first = std::find_if(points.begin(), points.end(), is_finite);
  if (first == points.end()) return {};
  const Vector3d zero = first->cast<double>();
  const std::vector<Moments> cubes = gather(points, zero, config.spacing);
  const double radius = config.radius > 0.0 ? config.radius : kClosingRadius * config.spacing;
  std::vector<Disc> discs;
  for (const Moments& cube : cubes) {
    const Moments around = neighbourhood(cubes, cube.cell);
    if (around.count < kFewestPoints) continue;
    const Vector3d mean = around.sum / around.count;
    const Matrix3d covariance = around.squares / around.count - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(covariance);
    const Vector3d normal = axes.eigenvectors().col(0);
    // Around the middle of the cube and not of its points, so that neighbouring discs leave no holes.
    const Vector3d middle =
        config.spacing * (Vector3d(cube.cell[0], cube.cell[1], cube.cell[2]).array() + 0.5);
    const Vector3d own_mean = cube.sum / cube.count;
    discs.push_back({zero + middle - normal.dot(middle - own_mean) * normal, normal, radius});
  }
  return discs;
}

Result<std::unique_ptr<World>> load_cloud_world(const std::string& path, const CloudDiscs& config) {
  const auto points = read_cloud(path);
  if (!points) return points.error();
  if (points->empty())
    return make_error(ErrorCode::kInvalid, "{}: holds no points; give a cloud of the site as world.file",
                      path);
  std::vector<Disc> discs = discs_of(*points, config);
  if (discs.empty()) {
    return make_error(
        ErrorCode::kInvalid,
        "{}: none of its {} points makes a surface; give a denser cloud or a larger world.disc_spacing", path,
        points->size());
  }
  return make_disc_world(std::move(discs));
}

}  // namespace mmlins::sim

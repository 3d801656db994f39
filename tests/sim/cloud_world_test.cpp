// SPDX-License-Identifier: MIT
#include "mmlins/sim/cloud_world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>

#include "mmlins/base/text_file.hpp"
#include "mmlins/io/pcd_file.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::sim {
namespace {

using Eigen::Vector3f;
using math::Vector3d;

constexpr double kFar = 200.0;  // [m]

std::vector<Vector3f> points_on_ground(int count, const Vector3d& middle) {
  Random random(5);
  std::vector<Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const Vector3d p = middle + Vector3d(random.uniform(-10, 10), random.uniform(-10, 10), 0.0);
    points.push_back(p.cast<float>());
  }
  return points;
}

std::string temporary(const std::string& name) {
  return (std::filesystem::temp_directory_path() / ("mmlins_cloud_world_" + name)).string();
}

TEST(CloudWorld, APlaneOfPointsIsHitAtItsDistanceAndHasNoHoles) {
  const auto world = make_disc_world(discs_of(points_on_ground(150'000, {0, 0, 0}), {}));
  Random random(6);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d origin(random.uniform(-5, 5), random.uniform(-5, 5), 2.0);
    const Vector3d target(random.uniform(-9, 9), random.uniform(-9, 9), 0.0);
    const Vector3d direction = (target - origin).normalized();
    const auto hit = world->cast({origin, direction}, kFar);
    ASSERT_TRUE(hit.has_value()) << target.transpose();
    EXPECT_NEAR(hit->range, (target - origin).norm(), 1e-6);
    EXPECT_NEAR(hit->normal.z(), 1.0, 1e-6);
    EXPECT_NEAR(world->distance(target, hit->surface), 0.0, 1e-6);
  }
}

// A map of a city in the national grid: single precision would be off by decimetres there.
TEST(CloudWorld, RangesAreExactFarFromTheOrigin) {
  const Vector3d middle(524'288.0, 4'194'304.0, 128.0);
  std::vector<Disc> discs;
  for (int i = -20; i <= 20; ++i)
    discs.push_back({middle + Vector3d(0.1 * i, 0.0, 0.0), Vector3d::UnitZ(), 0.2});
  const auto world = make_disc_world(discs);
  const auto hit = world->cast({middle + Vector3d(0.03, 0.01, 7.5), -Vector3d::UnitZ()}, kFar);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->range, 7.5, 1e-9);
}

TEST(CloudWorld, ASphereOfPointsTurnsItsDiscsOutwards) {
  constexpr double kRadius = 5.0;
  Random random(7);
  std::vector<Vector3f> points;
  for (int i = 0; i < 120'000; ++i) points.push_back((kRadius * random.normal3().normalized()).cast<float>());
  const auto world = make_disc_world(discs_of(points, {}));
  for (int i = 0; i < 1000; ++i) {
    const Vector3d direction = random.normal3().normalized();
    const auto hit = world->cast({Vector3d::Zero(), direction}, kFar);
    ASSERT_TRUE(hit.has_value());
    // The mean of a cube of a curved surface lies up to (0.3 m)^2 / (2 * 5 m) inside, the disc's rim outside.
    EXPECT_NEAR(hit->range, kRadius, 0.02);
    EXPECT_LT(hit->normal.dot(direction), -0.99);
  }
}

TEST(MeshWorld, TrianglesAreHitAtTheirClosedFormDistance) {
  TriangleMesh mesh;
  mesh.vertices = {{5, -1, -1}, {5, 1, -1}, {7, 0, 2}};
  mesh.triangles = {{0, 1, 2}};
  const auto world = make_mesh_world(mesh);
  // On the plane x = 5 + 2/3 (z + 1).
  EXPECT_NEAR(world->cast({{0, 0, 0.5}, {1, 0, 0}}, kFar)->range, 6.0, 1e-9);
  EXPECT_FALSE(world->cast({{0, 0, 0.5}, {-1, 0, 0}}, kFar).has_value());
  EXPECT_FALSE(world->cast({{0, 0, 0.5}, {1, 0, 0}}, 5.9).has_value());
}

TEST(CloudWorld, ReadsPcdAndPlyTheSame) {
  const std::vector<Vector3f> points = points_on_ground(60'000, {1, 2, 3});
  const std::string pcd = temporary("a.pcd"), ply = temporary("a.ply");
  ASSERT_TRUE(io::write_pcd(pcd, points, {}).ok());
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 60000\nproperty uchar red\nproperty float x\n"
      "property float y\nproperty float z\nelement face 0\nproperty list uchar int "
      "vertex_index\nend_header\n";
  char line[100];
  for (const Vector3f& p : points) {
    std::snprintf(line, sizeof line, "7 %.9g %.9g %.9g\n", static_cast<double>(p.x()),
                  static_cast<double>(p.y()), static_cast<double>(p.z()));
    text += line;
  }
  ASSERT_TRUE(write_text_file(ply, text).ok());
  const auto one = load_cloud_world(pcd, {});
  const auto other = load_cloud_world(ply, {});
  ASSERT_TRUE(one.ok()) << one.error().message;
  ASSERT_TRUE(other.ok()) << other.error().message;
  for (const double x : {-6.0, 0.3, 8.1}) {
    const auto a = (*one)->cast({{x, 2.2, 9.0}, {0, 0, -1}}, kFar);
    const auto b = (*other)->cast({{x, 2.2, 9.0}, {0, 0, -1}}, kFar);
    ASSERT_TRUE(a && b);
    EXPECT_NEAR(a->range, 6.0, 1e-5);
    EXPECT_EQ(a->range, b->range);
  }
}

TEST(CloudWorld, UselessCloudsAreRefusedByName) {
  const std::string empty = temporary("empty.pcd");
  ASSERT_TRUE(io::write_pcd(empty, {}, {}).ok());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::string nowhere = temporary("nan.pcd");
  ASSERT_TRUE(io::write_pcd(nowhere, std::vector<Vector3f>(100, Vector3f(nan, nan, nan)), {}).ok());
  const std::string no_ply = temporary("bad.ply");
  ASSERT_TRUE(write_text_file(no_ply, "ply\nformat ascii 1.0\nelement vertex 9\nproperty float x\n").ok());
  for (const std::string& path : {empty, nowhere, no_ply, temporary("missing.pcd"), temporary("a.las")}) {
    const auto world = load_cloud_world(path, {});
    ASSERT_FALSE(world.ok()) << path;
    EXPECT_NE(world.error().message.find(path), std::string::npos) << world.error().message;
    EXPECT_EQ(world.error().message.find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
// The only file that sees Embree.
#include "mmlins/sim/embree_world.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "mmlins/base/check.hpp"

namespace mmlins::sim {

namespace {

using math::Vector3d;

constexpr double kReflectivity = 0.4;
constexpr double kMinSlope = 1e-3;  // rays more grazing than this see no defined surface

struct Plane {
  Vector3d point = Vector3d::Zero();  // [m]
  Vector3d normal = Vector3d::UnitZ();
};

/// One geometry, all of whose primitives are flat. Coordinates are counted from the middle, because those of
/// a surveyed site may be too large for single precision.
class EmbreeWorld : public World {
 public:
  EmbreeWorld(std::vector<Plane> planes, const Vector3d& middle)
      : planes_(std::move(planes)),
        middle_(middle),
        device_(rtcNewDevice("threads=1")),
        scene_(rtcNewScene(device_)) {}
  ~EmbreeWorld() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeWorld(const EmbreeWorld&) = delete;
  EmbreeWorld& operator=(const EmbreeWorld&) = delete;

  RTCDevice device() const { return device_; }
  void build(RTCGeometry geometry) {
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(scene_);
  }

  std::optional<Hit> cast(const Ray& ray, double max_range) const override {
    const Eigen::Vector3f origin = (ray.origin - middle_).cast<float>();
    const Eigen::Vector3f direction = ray.direction.cast<float>();
    RTCRayHit query{};
    query.ray.org_x = origin.x();
    query.ray.org_y = origin.y();
    query.ray.org_z = origin.z();
    query.ray.dir_x = direction.x();
    query.ray.dir_y = direction.y();
    query.ray.dir_z = direction.z();
    query.ray.tfar = static_cast<float>(max_range);
    query.ray.mask = ~0U;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene_, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    const Plane& plane = planes_[query.hit.primID];
    const double slope = plane.normal.dot(ray.direction);
    if (std::abs(slope) < kMinSlope) return std::nullopt;
    const double range = plane.normal.dot(plane.point - ray.origin) / slope;
    if (range <= 0.0 || range > max_range) return std::nullopt;
    return Hit{range, slope < 0.0 ? plane.normal : Vector3d(-plane.normal), kReflectivity,
               static_cast<int>(query.hit.primID)};
  }

  double distance(const Vector3d& p, int surface) const override {
    const Plane& plane = planes_[static_cast<std::size_t>(surface)];
    return plane.normal.dot(p - plane.point);
  }

 private:
  std::vector<Plane> planes_;
  Vector3d middle_;
  RTCDevice device_;
  RTCScene scene_;
};

Vector3d middle_of(const std::vector<Plane>& planes) {
  Eigen::AlignedBox3d bounds;
  for (const Plane& plane : planes) bounds.extend(plane.point);
  return planes.empty() ? Vector3d::Zero() : Vector3d(bounds.center());
}

template <typename Element>
std::span<Element> new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  void* const data = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Element), count);
  return {static_cast<Element*>(data), count};
}

}  // namespace

std::unique_ptr<World> make_mesh_world(const TriangleMesh& mesh) {
  std::vector<Plane> planes;
  for (const auto& [a, b, c] : mesh.triangles) {
    MMLINS_CHECK(std::max({a, b, c}) < mesh.vertices.size());
    const Vector3d& p = mesh.vertices[a];
    planes.push_back({p, (mesh.vertices[b] - p).cross(mesh.vertices[c] - p).normalized()});
  }
  const Vector3d middle = middle_of(planes);
  auto world = std::make_unique<EmbreeWorld>(std::move(planes), middle);
  if (mesh.triangles.empty()) return world;
  const RTCGeometry geometry = rtcNewGeometry(world->device(), RTC_GEOMETRY_TYPE_TRIANGLE);
  const auto vertices = new_buffer<std::array<float, 3>>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3,
                                                         mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f p = (mesh.vertices[i] - middle).cast<float>();
    vertices[i] = {p.x(), p.y(), p.z()};
  }
  const auto triangles = new_buffer<std::array<std::uint32_t, 3>>(geometry, RTC_BUFFER_TYPE_INDEX,
                                                                  RTC_FORMAT_UINT3, mesh.triangles.size());
  std::copy(mesh.triangles.begin(), mesh.triangles.end(), triangles.begin());
  world->build(geometry);
  return world;
}

std::unique_ptr<World> make_disc_world(std::vector<Disc> discs) {
  std::vector<Plane> planes;
  for (const Disc& disc : discs) planes.push_back({disc.center, disc.normal});
  const Vector3d middle = middle_of(planes);
  auto world = std::make_unique<EmbreeWorld>(std::move(planes), middle);
  if (discs.empty()) return world;
  const RTCGeometry geometry = rtcNewGeometry(world->device(), RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  const auto places =
      new_buffer<std::array<float, 4>>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, discs.size());
  const auto normals =
      new_buffer<std::array<float, 3>>(geometry, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, discs.size());
  for (std::size_t i = 0; i < discs.size(); ++i) {
    const Eigen::Vector3f p = (discs[i].center - middle).cast<float>();
    const Eigen::Vector3f n = discs[i].normal.cast<float>();
    places[i] = {p.x(), p.y(), p.z(), static_cast<float>(discs[i].radius)};
    normals[i] = {n.x(), n.y(), n.z()};
  }
  world->build(geometry);
  return world;
}

}  // namespace mmlins::sim

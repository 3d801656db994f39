// SPDX-License-Identifier: MIT
#include "mmlins/sim/world.hpp"

#include <cmath>
#include <numbers>

#include "mmlins/base/check.hpp"
#include "mmlins/sim/random.hpp"
#include "mmlins/sim/scenes.hpp"

namespace mmlins::sim {

namespace {

constexpr int kGround = 0;  // surface number; those of shapes follow
constexpr double kGroundReflectivity = 0.25;
// Of the search for the uneven surface next to the even one.
constexpr int kMaxSteps = 6;
// One last step from here leaves an error of its square times half the curvature, below 1e-6 m.
constexpr double kCloseEnough = 1e-4;  // [m]
constexpr double kMinSlope = 0.02;     // rays more grazing than this see no defined surface

// A cloud offers no course of its own.
Route cloud_route(const WorldConfig&) { return {}; }

struct Scene {
  const char* name;
  Route (*route)(const WorldConfig&);
  std::vector<Shape> (*shapes)(const WorldConfig&, const Polygon& keep_free);
};

// In the order of SceneKind.
constexpr std::array<Scene, 12> kScenes{{{"hall", hall_route, hall_shapes},
                                         {"street", street_route, street_shapes},
                                         {"office", office_route, office_shapes},
                                         {"yard", yard_route, yard_shapes},
                                         {"campus", campus_route, campus_shapes},
                                         {"urban", urban_route, urban_shapes},
                                         {"corridor", corridor_route, corridor_shapes},
                                         {"tunnel", tunnel_route, tunnel_shapes},
                                         {"field", field_route, field_shapes},
                                         {"decoy", decoy_route, decoy_shapes},
                                         {"floors", floors_route, floors_shapes},
                                         {"cloud", cloud_route, nullptr}}};

const Scene& scene_of(const WorldConfig& config) { return kScenes[static_cast<std::size_t>(config.scene)]; }

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const Scene& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

ShapeWorld::ShapeWorld(std::vector<Shape> shapes, const Roughness& roughness)
    : bvh_(std::move(shapes)),
      relief_({roughness.surfaces, 0.4, 3.0, false}, sub_seed(roughness.seed, 0)),
      ground_relief_({roughness.ground_waves, 9.0, 30.0, true}, sub_seed(roughness.seed, 1)) {}

std::optional<Hit> ShapeWorld::cast(const Ray& ray, double max_range) const {
  // Most rays end on the ground soon: it is asked first.
  const double to_ground = ray.direction.z() < 0.0 ? -ray.origin.z() / ray.direction.z() : max_range;
  const bool meets_ground = to_ground > 0.0 && to_ground < max_range;
  const auto shape_hit = bvh_.first_hit(ray, meets_ground ? to_ground : max_range);
  if (!shape_hit && !meets_ground) return std::nullopt;
  double range = shape_hit ? shape_hit->range : to_ground;
  const int surface = shape_hit ? 1 + kFacesPerShape * shape_hit->shape + shape_hit->face : kGround;

  // Newton's method from the even surface to the uneven one. Where it fails, the ray grazes.
  for (int step = 0; step < kMaxSteps; ++step) {
    const Implicit f = implicit(ray.origin + range * ray.direction, surface);
    const double slope = f.gradient.dot(ray.direction);
    if (slope > -kMinSlope) return std::nullopt;
    range -= f.value / slope;
    if (std::abs(f.value) < kCloseEnough) {
      if (range <= 0.0 || range > max_range) return std::nullopt;
      return Hit{range, f.gradient.normalized(), reflectivity(surface), surface};
    }
  }
  return std::nullopt;
}

ShapeWorld::Implicit ShapeWorld::implicit(const math::Vector3d& p, int surface) const {
  const Bump bump = relief_.at(p);
  if (surface == kGround) {
    const Bump wave = ground_relief_.at(p);
    return {p.z() - bump.height - wave.height, math::Vector3d::UnitZ() - bump.gradient - wave.gradient};
  }
  const auto shape = static_cast<std::size_t>((surface - 1) / kFacesPerShape);
  const FaceDistance even = distance_to_face(bvh_.shapes()[shape], (surface - 1) % kFacesPerShape, p);
  return {even.distance - bump.height, even.normal - bump.gradient};
}

double ShapeWorld::reflectivity(int surface) const {
  if (surface == kGround) return kGroundReflectivity;
  return bvh_.shapes()[static_cast<std::size_t>((surface - 1) / kFacesPerShape)].reflectivity;
}

double ShapeWorld::distance(const math::Vector3d& p, int surface) const {
  const Implicit f = implicit(p, surface);
  return f.value / f.gradient.norm();
}

math::SE3 WorldConfig::T_world_scene() const {
  const double yaw = yaw_deg * std::numbers::pi / 180.0;
  return {Eigen::AngleAxisd(yaw, math::Vector3d::UnitZ()).toRotationMatrix(),
          {offset[0], offset[1], offset[2]}};
}

Fields WorldConfig::fields() {
  return {
      field("scene", scene, scene_names(), "what kind of place; cloud: made from world.file"),
      field("file", file, "point cloud (.pcd or .ply) that a world of the kind cloud is made from"),
      field("disc_spacing", disc_spacing, "m", {0.01, 5.0},
            "edge of the cubes that get a disc each, of a cloud"),
      field("disc_radius", disc_radius, "m", {0.0, 5.0},
            "of the discs of a cloud; 0: just enough to leave no holes"),
      field("seed", seed, "", {0, 1e9}, "another number, another place of that kind"),
      field("yaw_deg", yaw_deg, "deg", {-180.0, 180.0}, "how the scene is turned in the world"),
      field("offset", offset, "m", {-1e5, 1e5}, "where the scene lies in the world"),
      field("unevenness", unevenness, "m", {0.0, 0.03}, "root mean square of the bumps of all surfaces"),
      field("ground_waves", ground_waves, "m", {0.0, 0.3},
            "root mean square of the long waves of the ground"),
      field("clutter", clutter, "", {0.0, 3.0}, "number of loose objects, as a share of the usual"),
      field("movers", movers, "", {0, 500}, "number of people and cars that move about"),
      field("mover_speed", mover_speed, "m/s", {0.0, 30.0},
            "of all of them; 0: people at 0.7 to 1.8 and cars at 5 to 12"),
  };
}

Route scene_route(const WorldConfig& config) { return scene_of(config).route(config); }

std::unique_ptr<ShapeWorld> make_world(const WorldConfig& config, const Polygon& keep_free) {
  MMLINS_CHECK(config.scene != SceneKind::kCloud);
  const auto seed = static_cast<std::uint64_t>(config.seed);
  return std::make_unique<ShapeWorld>(scene_of(config).shapes(config, keep_free),
                                      ShapeWorld::Roughness{config.unevenness, config.ground_waves, seed});
}

}  // namespace mmlins::sim

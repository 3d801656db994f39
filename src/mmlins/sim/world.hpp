// SPDX-License-Identifier: MIT
#pragma once
// The surroundings: where does a ray meet a surface? A world of other making (meshes, point clouds)
// implements the same interface.

#include <memory>
#include <optional>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sim/bvh.hpp"
#include "mmlins/sim/course.hpp"
#include "mmlins/sim/relief.hpp"

namespace mmlins::sim {

struct Hit {
  double range = 0.0;                               ///< [m]
  math::Vector3d normal = math::Vector3d::UnitZ();  ///< of the surface, towards the ray's origin
  double reflectivity = 0.5;                        ///< diffuse, 0 to 1
  int surface = 0;                                  ///< number of the surface, for World::distance
};

class World {
 public:
  virtual ~World() = default;
  /// The first surface along the ray within `max_range`; safe to call from several threads.
  [[nodiscard]] virtual std::optional<Hit> cast(const Ray& ray, double max_range) const = 0;
  /// How far the point is from the given surface, unevenness included; positive in front of it [m].
  [[nodiscard]] virtual double distance(const math::Vector3d& p, int surface) const = 0;
  /// The same at an instant [s after the start of the recording], for surfaces that move.
  [[nodiscard]] virtual double distance_at(const math::Vector3d& p, int surface, double /*seconds*/) const {
    return distance(p, surface);
  }
};

enum class SceneKind {
  kHall,
  kStreet,
  kOffice,
  kYard,
  kCampus,
  kUrban,
  kCorridor,
  kTunnel,
  kField,
  kDecoy,
  kFloors,
  kCloud
};

/// The scenes by name, in the order of SceneKind.
[[nodiscard]] std::vector<std::string> scene_names();

struct WorldConfig {
  SceneKind scene = SceneKind::kHall;
  std::string file;
  double disc_spacing = 0.2;
  double disc_radius = 0.0;
  int seed = 1;
  double yaw_deg = 27.3;
  std::array<double, 3> offset{3.137, -1.713, 0.371};
  double unevenness = 0.008;
  double ground_waves = 0.03;
  double clutter = 1.0;
  int movers = 0;
  double mover_speed = 0.0;

  [[nodiscard]] Fields fields();
  [[nodiscard]] math::SE3 T_world_scene() const;
};

/// Shapes on a gently waving ground, all surfaces slightly uneven. Coordinates are those of the scene.
class ShapeWorld : public World {
 public:
  struct Roughness {
    double surfaces = 0.0;      ///< root mean square of the unevenness of all surfaces [m]
    double ground_waves = 0.0;  ///< the same of the long waves of the ground [m]
    std::uint64_t seed = 0;
  };

  /// The ground is the plane z = 0.
  ShapeWorld(std::vector<Shape> shapes, const Roughness& roughness);

  [[nodiscard]] std::optional<Hit> cast(const Ray& ray, double max_range) const override;
  [[nodiscard]] double distance(const math::Vector3d& p, int surface) const override;
  [[nodiscard]] std::size_t num_shapes() const { return bvh_.shapes().size(); }

 private:
  struct Implicit {  // f(p) = 0 on the uneven surface
    double value;
    math::Vector3d gradient;
  };
  [[nodiscard]] double reflectivity(int surface) const;
  [[nodiscard]] Implicit implicit(const math::Vector3d& p, int surface) const;

  Bvh bvh_;
  Relief relief_;
  Relief ground_relief_;
};

/// The course on which a carrier can travel through the scene, in the scene's coordinates.
[[nodiscard]] Route scene_route(const WorldConfig& config);
/// The scene, in its own coordinates. Not for SceneKind::kCloud, which comes from load_cloud_world().
/// @param keep_free  places that the carrier passes; loose objects keep away from them
[[nodiscard]] std::unique_ptr<ShapeWorld> make_world(const WorldConfig& config, const Polygon& keep_free);

}  // namespace mmlins::sim

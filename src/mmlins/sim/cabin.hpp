// SPDX-License-Identifier: MIT
#pragma once
// The cabin of an elevator: a room in motion. It is there only while its event lasts, and hides all else from
// those inside, except through its open door.

#include <optional>

#include "mmlins/degrade/event_spec.hpp"
#include "mmlins/sim/motion.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

class Cabin {
 public:
  /// @param motion  of the carrier, which the cabin is built around
  /// @param unevenness  of its walls [m]
  Cabin(const degrade::EventSpec& elevator, const Motion& motion, const TrajectoryConfig& trajectory,
        double unevenness);

  [[nodiscard]] bool is_there(double seconds) const;
  /// What a ray from within meets: a hit on the cabin, or where it leaves through the door.
  struct Sight {
    std::optional<Hit> hit;
    std::optional<double> leaves_at;  ///< range of the open door [m]
  };
  [[nodiscard]] Sight cast(const Ray& ray, double max_range) const;
  [[nodiscard]] double distance_at(const math::Vector3d& p, int surface, double seconds) const;
  /// The middle of the floor; x points to the door.
  [[nodiscard]] math::SE3 T_scene_cabin(double seconds) const;

 private:
  [[nodiscard]] double half_gap(double seconds) const;

  degrade::EventSpec elevator_;
  math::SE3 T_scene_start_;
  ShapeWorld shell_;  // whose ground is the floor
};

}  // namespace mmlins::sim

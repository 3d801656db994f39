// SPDX-License-Identifier: MIT
#pragma once
// A world in which things move: what stands still, of any making, movers about it, and cabins of elevators
// that the carrier rides in. A ray meets each of them where it is at the ray's own time.

#include <memory>
#include <vector>

#include "mmlins/sim/cabin.hpp"
#include "mmlins/sim/mover.hpp"
#include "mmlins/sim/world.hpp"

namespace mmlins::sim {

class MovingWorld : public World {
 public:
  MovingWorld(std::unique_ptr<World> still, std::vector<Mover> movers, std::vector<Cabin> cabins = {});

  [[nodiscard]] std::optional<Hit> cast(const Ray& ray, double max_range) const override;
  /// Of a surface that moves: as it is at the start of the recording.
  [[nodiscard]] double distance(const math::Vector3d& p, int surface) const override;
  [[nodiscard]] double distance_at(const math::Vector3d& p, int surface, double seconds) const override;

  [[nodiscard]] const World& still() const { return *still_; }
  [[nodiscard]] const std::vector<Mover>& movers() const { return movers_; }

 private:
  [[nodiscard]] std::optional<Hit> cast_from_cabin(std::size_t cabin, const Ray& ray, double max_range) const;
  [[nodiscard]] std::optional<Hit> cast_outside(const Ray& ray, double max_range) const;

  std::unique_ptr<World> still_;
  std::vector<Mover> movers_;
  std::vector<Cabin> cabins_;
};

/// Surfaces of cabins are numbered from here on.
inline constexpr int kFirstCabinSurface = 1'500'000'000;
/// Surfaces of movers are numbered from here on, up to those of cabins.
inline constexpr int kFirstMoverSurface = 1'000'000'000;

}  // namespace mmlins::sim

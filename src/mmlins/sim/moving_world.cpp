// SPDX-License-Identifier: MIT
#include "mmlins/sim/moving_world.hpp"

#include <limits>
#include <utility>

namespace mmlins::sim {

namespace {

constexpr int kMostShapes = 8;  // of a mover
constexpr int kSurfacesPerCabin = 1000;
constexpr int kSurfacesPerMover = kMostShapes * kFacesPerShape;

}  // namespace

MovingWorld::MovingWorld(std::unique_ptr<World> still, std::vector<Mover> movers, std::vector<Cabin> cabins)
    : still_(std::move(still)), movers_(std::move(movers)), cabins_(std::move(cabins)) {}

std::optional<Hit> MovingWorld::cast(const Ray& ray, double max_range) const {
  for (std::size_t i = 0; i < cabins_.size(); ++i) {
    if (cabins_[i].is_there(ray.time)) return cast_from_cabin(i, ray, max_range);
  }
  return cast_outside(ray, max_range);
}

std::optional<Hit> MovingWorld::cast_from_cabin(std::size_t cabin, const Ray& ray, double max_range) const {
  Cabin::Sight sight = cabins_[cabin].cast(ray, max_range);
  if (sight.hit) sight.hit->surface += kFirstCabinSurface + static_cast<int>(cabin) * kSurfacesPerCabin;
  if (!sight.leaves_at) return sight.hit;
  Ray onward = ray;
  onward.origin += *sight.leaves_at * ray.direction;
  auto hit = cast_outside(onward, max_range - *sight.leaves_at);
  if (hit) hit->range += *sight.leaves_at;
  return hit;
}

std::optional<Hit> MovingWorld::cast_outside(const Ray& ray, double max_range) const {
  auto best = still_->cast(ray, max_range);
  double limit = best ? best->range : max_range;
  const MoverInstant now = mover_instant(ray.time);
  for (std::size_t m = 0; m < movers_.size(); ++m) {
    const auto place = movers_[m].place(now);
    if (!place || !movers_[m].may_meet(ray, *place, limit)) continue;
    const Ray from_there{ray.origin - *place, ray.direction, ray.time};
    const std::vector<Shape>& shapes = movers_[m].shapes();
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const auto hit = intersect(shapes[i], from_there);
      if (!hit || hit->range >= limit) continue;
      limit = hit->range;
      const auto face = distance_to_face(shapes[i], hit->face, from_there.origin + limit * ray.direction);
      best = Hit{limit, face.normal, shapes[i].reflectivity,
                 kFirstMoverSurface + static_cast<int>(m) * kSurfacesPerMover +
                     static_cast<int>(i) * kFacesPerShape + hit->face};
    }
  }
  return best;
}

double MovingWorld::distance(const math::Vector3d& p, int surface) const {
  return distance_at(p, surface, 0.0);
}

double MovingWorld::distance_at(const math::Vector3d& p, int surface, double seconds) const {
  if (surface < kFirstMoverSurface) return still_->distance_at(p, surface, seconds);
  if (surface >= kFirstCabinSurface) {
    const int of_cabins = surface - kFirstCabinSurface;
    const auto cabin = static_cast<std::size_t>(of_cabins / kSurfacesPerCabin);
    return cabins_[cabin].distance_at(p, of_cabins % kSurfacesPerCabin, seconds);
  }
  const int number = surface - kFirstMoverSurface;
  const Mover& mover = movers_[static_cast<std::size_t>(number / kSurfacesPerMover)];
  const auto place = mover.place(mover_instant(seconds));
  if (!place) return std::numeric_limits<double>::infinity();
  const auto shape = static_cast<std::size_t>(number % kSurfacesPerMover / kFacesPerShape);
  return distance_to_face(mover.shapes()[shape], number % kFacesPerShape, p - *place).distance;
}

}  // namespace mmlins::sim

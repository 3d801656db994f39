// SPDX-License-Identifier: MIT
#include "mmlins/sim/open_simulation.hpp"

#include "mmlins/sim/cloud_world.hpp"
#include "mmlins/sim/rides.hpp"

namespace mmlins::sim {

namespace {

constexpr double kCheckRate = 10.0;     // [Hz]
constexpr double kSmallestStep = 1e-6;  // [m]

}  // namespace

Status check_path(const Simulation& simulation, const std::string& source) {
  const math::Trajectory truth = simulation.truth(kCheckRate);
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    const math::Vector3d here = truth[i].pose.t;
    const math::Vector3d step = truth[i + 1].pose.t - here;
    // An elevator passes through floors.
    const double seconds = to_seconds(truth[i].time - simulation.start_time());
    if (holds(simulation.config().events, degrade::EventKind::kElevator, seconds)) continue;
    if (step.norm() < kSmallestStep || !simulation.cast({here, step.normalized()}, step.norm())) continue;
    return make_error(
        ErrorCode::kInvalid,
        "{}: the trajectory leads through a surface after {:.1f} s, at x {:.1f} y {:.1f} z {:.1f} m of "
        "the world; choose another course, size or height",
        source, seconds, here.x(), here.y(), here.z());
  }
  return {};
}

Result<std::unique_ptr<Simulation>> open_simulation(const SimulationConfig& config,
                                                    const std::string& source) {
  std::unique_ptr<World> world;
  if (config.world.scene == SceneKind::kCloud) {
    auto loaded = load_cloud_world(config.world.file, {config.world.disc_spacing, config.world.disc_radius});
    if (!loaded) return loaded.error();
    world = std::move(loaded).value();
  }
  auto simulation = std::make_unique<Simulation>(config, std::move(world));
  if (const Status status = check_path(*simulation, source); !status) return status.error();
  return simulation;
}

}  // namespace mmlins::sim

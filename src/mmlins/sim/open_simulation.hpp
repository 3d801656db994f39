// SPDX-License-Identifier: MIT
#pragma once
// Simulations whose world may come from a file, and whose path is checked before anything is recorded.

#include <memory>

#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {

/// @param config  valid (validate())
/// @param source  what to call the config in messages: a scenario or file name
/// Errors: a world that cannot be read, a path that leads through a surface of the world.
[[nodiscard]] Result<std::unique_ptr<Simulation>> open_simulation(const SimulationConfig& config,
                                                                  const std::string& source);

/// Whether the IMU passes through a surface on its way; where and when, if so.
[[nodiscard]] Status check_path(const Simulation& simulation, const std::string& source);

}  // namespace mmlins::sim

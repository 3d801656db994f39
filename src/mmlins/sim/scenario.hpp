// SPDX-License-Identifier: MIT
#pragma once
// Scenarios: named, ready-made simulations, and files of the same form. The named ones are the files of
// config/scenarios/, built into the program.

#include <string>
#include <vector>

#include "mmlins/sim/named_text.hpp"
#include "mmlins/sim/simulation.hpp"

namespace mmlins::sim {

using ScenarioText = NamedText;

/// The built-in scenarios by name, in alphabetical order.
[[nodiscard]] std::vector<ScenarioText> scenario_texts();
/// The first line of a scenario's text: what it is.
[[nodiscard]] std::string summary_of(const ScenarioText& scenario);

/// The built-in scenario of that name, or the YAML file at that path, with `overrides` ("group.key=value")
/// applied on top.
/// Errors: an unknown name (names the nearest one), an unreadable file, unknown keys, values out of range.
[[nodiscard]] Result<SimulationConfig> load_scenario(const std::string& name_or_path,
                                                     const std::vector<std::string>& overrides = {});

}  // namespace mmlins::sim

// SPDX-License-Identifier: MIT
#include "mmlins/sim/scenario.hpp"

#include "mmlins/config/field_index.hpp"
#include "mmlins/config/yaml_config.hpp"

namespace mmlins::sim {

namespace {

bool looks_like_a_file(const std::string& name) {
  return name.find('/') != std::string::npos || name.ends_with(".yaml") || name.ends_with(".yml");
}

Status apply_named(const Fields& fields, const std::string& name) {
  const std::vector<ScenarioText> scenarios = scenario_texts();
  for (const ScenarioText& scenario : scenarios) {
    if (scenario.name == name) return config::apply_yaml(fields, scenario.yaml, name);
  }
  std::vector<std::string> names;
  for (const ScenarioText& scenario : scenarios) names.push_back(scenario.name);
  const std::string nearest = config::nearest_word(names, name);
  return make_error(ErrorCode::kNotFound,
                    "there is no scenario '{}'{} (--list shows all; a name ending in .yaml is a file)", name,
                    nearest.empty() ? "" : "; did you mean '" + nearest + "'?");
}

}  // namespace

std::string summary_of(const ScenarioText& scenario) {
  const std::string line = scenario.yaml.substr(0, scenario.yaml.find('\n'));
  return line.starts_with("# ") ? line.substr(2) : "";
}

Result<SimulationConfig> load_scenario(const std::string& name_or_path,
                                       const std::vector<std::string>& overrides) {
  SimulationConfig config;
  const Fields fields = config.fields();
  const Status loaded = looks_like_a_file(name_or_path) ? config::apply_yaml_file(fields, name_or_path)
                                                        : apply_named(fields, name_or_path);
  if (!loaded) return loaded.error();
  for (const std::string& assignment : overrides) {
    if (const Status status = config::apply_override(fields, assignment); !status) return status.error();
  }
  if (const Status status = validate(config, name_or_path); !status) return status.error();
  return config;
}

}  // namespace mmlins::sim

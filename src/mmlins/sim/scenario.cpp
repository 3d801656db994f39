// SPDX-License-Identifier: MIT
#include "mmlins/sim/scenario.hpp"

#include <algorithm>
#include <numeric>

#include "mmlins/config/yaml_config.hpp"

namespace mmlins::sim {

namespace {

// Number of letters to insert, delete or replace to make one word of the other.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

std::string nearest_name(const std::string& name, const std::vector<ScenarioText>& scenarios) {
  const auto nearest = std::min_element(scenarios.begin(), scenarios.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a.name) < edit_distance(name, b.name);
  });
  return nearest == scenarios.end() ? "" : nearest->name;
}

bool looks_like_a_file(const std::string& name) {
  return name.find('/') != std::string::npos || name.find(".y") != std::string::npos;
}

Status apply_named(const Fields& fields, const std::string& name) {
  const std::vector<ScenarioText> scenarios = scenario_texts();
  for (const ScenarioText& scenario : scenarios) {
    if (scenario.name == name) return config::apply_yaml(fields, scenario.yaml, name);
  }
  return make_error(ErrorCode::kNotFound,
                    "there is no scenario '{}'; did you mean '{}'? --list shows all, a path with .yaml reads a file", name,
                    nearest_name(name, scenarios));
}

}  // namespace

std::string summary_of(const ScenarioText& scenario) {
  const std::string line = scenario.yaml.substr(0, scenario.yaml.find('\n'));
  return line.starts_with("# ") ? line.substr(2) : "";
}

Result<SimulationConfig> load_scenario(const std::string& name_or_path, const std::vector<std::string>& overrides) {
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

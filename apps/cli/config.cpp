// SPDX-License-Identifier: MIT
// mmlins config: every setting with its default, meaning, unit and range, ready to be edited.

#include "mmlins/pipeline/config.hpp"

#include <fmt/format.h>

#include "commands.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::cli {

void add_config(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("config", "Print all settings with their defaults as a YAML file");
  auto of_rig = std::make_shared<bool>(false);
  command->add_flag("--rig", *of_rig, "the sensors (run --rig) instead of the method (run --config)");
  command->callback([of_rig, &exit_code] {
    pipeline::SlamConfig config;
    sensor::Rig rig;
    fmt::print("{}", config::to_yaml(*of_rig ? rig.fields() : config.fields(), true));
    exit_code = 0;
  });
}

}  // namespace mmlins::cli

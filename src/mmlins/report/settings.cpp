// SPDX-License-Identifier: MIT
#include "mmlins/report/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <span>
#include <type_traits>

#include "mmlins/base/check.hpp"

namespace mmlins::report {
namespace {

std::string value_text(const Field& field) {
  return std::visit(
      [](const auto& value) -> std::string {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, NumbersAccess>) {
          return fmt::format("[{}]", fmt::join(std::span(value.data, static_cast<std::size_t>(value.size)), ", "));
        } else if constexpr (std::is_same_v<Value, EnumAccess>) {
          return value.words[static_cast<std::size_t>(value.get())];
        } else if constexpr (std::is_same_v<Value, GroupsAccess>) {
          return fmt::format("{} entries", value.items().size());
        } else if constexpr (std::is_same_v<Value, Fields>) {
          return {};
        } else {
          return fmt::format("{}", *value);
        }
      },
      field.value);
}

void append(std::vector<Setting>& settings, const std::string& prefix, const Fields& fields, const Fields& defaults) {
  MMLINS_CHECK(fields.size() == defaults.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string path = prefix.empty() ? fields[i].name : prefix + "." + fields[i].name;
    if (const auto* nested = std::get_if<Fields>(&fields[i].value)) {
      append(settings, path, *nested, std::get<Fields>(defaults[i].value));
    } else {
      settings.push_back({path, value_text(fields[i]), value_text(defaults[i]), fields[i].unit, fields[i].meaning});
    }
  }
}

}  // namespace

std::vector<Setting> list_settings(const Fields& fields, const Fields& defaults) {
  std::vector<Setting> settings;
  append(settings, "", fields, defaults);
  return settings;
}

}  // namespace mmlins::report

// SPDX-License-Identifier: MIT
// Reading: the whole text is checked before the first field changes.
#include "mmlins/config/yaml_config.hpp"

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <map>

#include "mmlins/base/text_file.hpp"
#include "mmlins/config/field_index.hpp"
#include "mmlins/config/yaml_value.hpp"

namespace mmlins::config {
namespace {

// A recording given by mistake must not be loaded as text.
constexpr std::uintmax_t kLargestFile = 16U << 20U;  // [bytes]

/// Walks a YAML tree along the fields and collects what to assign.
class Reader {
 public:
  Reader(const Fields& fields, std::string source, const std::string& prefix = "")
      : index_(index_fields(fields, prefix)), source_(std::move(source)) {}

  Status read_group(const YAML::Node& node, const std::string& prefix) {
    if (node.IsNull()) return {};  // all members left out
    if (!node.IsMap()) {
      const std::string what = prefix.empty() ? "the file" : prefix.substr(0, prefix.size() - 1);
      return refuse(node, what + " must be a group of \"key: value\" lines");
    }
    for (const auto& entry : node) {
      if (!entry.first.IsScalar()) return refuse(entry.first, "a key must be a plain word");
      if (const Status status = read_entry(prefix + entry.first.Scalar(), entry.first, entry.second);
          !status) {
        return status;
      }
    }
    return {};
  }

  Status read_entry(const std::string& name, const YAML::Node& key, const YAML::Node& value) {
    const Field* field = find_field(index_, name);
    if (field == nullptr) return refuse(key, unknown_key(name));
    const int line = key.Mark().line + 1;
    if (const auto [earlier, is_new] = lines_.emplace(name, line); !is_new) {
      return refuse(key,
                    fmt::format("{} is given twice, first in line {}; remove one", name, earlier->second));
    }
    if (std::holds_alternative<Fields>(field->value)) return read_group(value, name + ".");
    if (const auto* list = std::get_if<GroupsAccess>(&field->value)) return read_list(*list, name, key, value);
    Result<Assignment> assignment = check_value(*field, value);
    if (!assignment) {
      return refuse(
          key, fmt::format("{} {}; accepted: {}", name, assignment.error().message, accepted_values(*field)));
    }
    assignments_.push_back(std::move(assignment).value());
    return {};
  }

  void assign_all() const {
    for (const Assignment& assign : assignments_) assign();
  }

 private:
  Status read_list(const GroupsAccess& list, const std::string& name, const YAML::Node& key,
                   const YAML::Node& value) {
    if (!value.IsSequence() && !value.IsNull()) {
      return refuse(key, name + " must be a list of groups, - {key: value, ...}");
    }
    const std::shared_ptr<GroupsDraft> draft = list.draft();
    for (std::size_t i = 0; i < value.size(); ++i) {
      const std::string item = fmt::format("{}[{}]", name, i);
      const Fields fields = draft->append();
      if (!value[i].IsMap()) return refuse(value[i], item + " must be a group of \"key: value\" lines");
      Reader reader(fields, source_, item + ".");
      if (const Status status = reader.read_group(value[i], item + "."); !status) return status;
      reader.assign_all();  // to the draft
    }
    assignments_.push_back([draft] { draft->replace_list(); });
    return {};
  }

  std::string unknown_key(const std::string& name) const {
    const std::string nearest = nearest_name(index_, name);
    if (!nearest.empty()) return fmt::format("unknown key {}; did you mean {}?", name, nearest);
    return fmt::format("unknown key {}; \"mmlins config\" lists all keys", name);
  }

  Error refuse(const YAML::Node& node, const std::string& what) const {
    const int line = node.Mark().line;
    if (line < 0) return make_error(ErrorCode::kInvalid, "{}: {}", source_, what);  // not from a file
    return make_error(ErrorCode::kInvalid, "{}:{}: {}", source_, line + 1, what);
  }

  std::vector<NamedField> index_;
  std::string source_;
  std::map<std::string, int> lines_;  ///< where each key was seen
  std::vector<Assignment> assignments_;
};

Result<YAML::Node> parse(const std::string& text, const std::string& source) {
  if (text.find('\0') != std::string::npos) {
    return make_error(ErrorCode::kInvalid, "{}:1: is no text file; give a YAML file of \"key: value\" lines",
                      source);
  }
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.empty()) return YAML::Node();
    if (documents.size() == 1) return documents.front();
    return make_error(ErrorCode::kInvalid, "{}:{}: a second YAML document begins here; remove the \"---\"",
                      source, std::max(0, documents[1].Mark().line) + 1);
  } catch (const YAML::Exception& e) {
    return make_error(ErrorCode::kInvalid, "{}:{}: not valid YAML: {}", source, std::max(0, e.mark.line) + 1,
                      e.msg);
  }
}

Result<std::string> read_settings(const std::string& path) {
  std::error_code error;
  if (const auto size = std::filesystem::file_size(path, error); !error && size > kLargestFile) {
    return make_error(ErrorCode::kInvalid, "{}: {} MB is too large for settings; give a YAML file", path,
                      size >> 20U);
  }
  return read_text_file(path);
}

}  // namespace

Status apply_yaml(const Fields& fields, const std::string& yaml_text, const std::string& source) {
  const Result<YAML::Node> root = parse(yaml_text, source);
  if (!root) return root.error();
  try {
    Reader reader(fields, source);
    if (const Status status = reader.read_group(*root, ""); !status) return status;
    reader.assign_all();
    return {};
  } catch (const YAML::Exception& e) {
    return make_error(ErrorCode::kInvalid, "{}:{}: {}", source, std::max(0, e.mark.line) + 1, e.msg);
  }
}

Status apply_yaml_file(const Fields& fields, const std::string& path) {
  const Result<std::string> text = read_settings(path);
  if (!text) return text.error();
  return apply_yaml(fields, *text, path);
}

Status apply_override(const Fields& fields, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (equals == 0 || equals == std::string::npos) {
    return make_error(ErrorCode::kInvalid, "'{}': write a setting as key=value, for instance group.key=1",
                      assignment);
  }
  const std::string source = "'" + assignment + "'";
  const Result<YAML::Node> value = parse(assignment.substr(equals + 1), source);
  if (!value) return value.error();
  try {
    Reader reader(fields, source);
    const YAML::Node key(assignment.substr(0, equals));
    if (const Status status = reader.read_entry(key.Scalar(), key, *value); !status) return status;
    reader.assign_all();
    return {};
  } catch (const YAML::Exception& e) {
    return make_error(ErrorCode::kInvalid, "{}: {}", source, e.msg);
  }
}

}  // namespace mmlins::config

// SPDX-License-Identifier: MIT
#include "mmlins/io/ply_file.hpp"

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>

namespace mmlins::io {
namespace {

struct Property {
  std::string name;
  std::string type;
  std::size_t offset = 0;  ///< [bytes] in a vertex of a binary file
};

struct Header {
  std::string format;
  std::size_t num_vertices = 0;
  std::size_t vertex_size = 0;  ///< [bytes]
  std::vector<Property> properties;
  std::array<std::size_t, 3> xyz{};  ///< which properties they are
};

const std::map<std::string, std::size_t>& type_sizes() {
  static const std::map<std::string, std::size_t> sizes{
      {"char", 1},   {"int8", 1},    {"uchar", 1},  {"uint8", 1},  {"short", 2}, {"int16", 2},
      {"ushort", 2}, {"uint16", 2},  {"int", 4},    {"int32", 4},  {"uint", 4},  {"uint32", 4},
      {"float", 4},  {"float32", 4}, {"double", 8}, {"float64", 8}};
  return sizes;
}

/// Takes over one line. @return what is wrong with it, or nothing
std::string apply_line(Header& header, std::string& element, const std::string& line) {
  std::istringstream words(line);
  std::string key, type, name;
  words >> key;
  if (key == "format") {
    words >> header.format;
  } else if (key == "element") {
    std::size_t count = 0;
    if (!(words >> element >> count)) return "has a damaged element line";
    if (element == "vertex") header.num_vertices = count;
    if (element != "vertex" && header.properties.empty()) return "must have its vertices first";
  } else if (key == "property" && element == "vertex") {
    words >> type >> name;
    const auto size = type_sizes().find(type);
    if (size == type_sizes().end())
      return "has a vertex property of the type '" + type + "', which is not supported";
    header.properties.push_back({name, type, header.vertex_size});
    header.vertex_size += size->second;
  }
  return {};
}

Result<Header> read_header(std::istream& file, const std::string& path) {
  Header header;
  std::string element;
  std::string line;
  if (!std::getline(file, line) || !line.starts_with("ply")) {
    return make_error(ErrorCode::kInvalid, "{}: is no PLY file", path);
  }
  while (true) {
    if (!std::getline(file, line) || line.size() > 10'000) {
      return make_error(ErrorCode::kInvalid, "{}: its header has no end", path);
    }
    if (line.ends_with('\r')) line.pop_back();
    if (line == "end_header") break;
    if (const std::string fault = apply_line(header, element, line); !fault.empty())
      return make_error(ErrorCode::kInvalid, "{}: {}", path, fault);
  }
  if (header.format != "ascii" && header.format != "binary_little_endian") {
    return make_error(ErrorCode::kUnsupported,
                      "{}: format '{}' is not supported; save it as ascii or binary_little_endian", path,
                      header.format);
  }
  const std::array<std::string, 3> wanted{"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::size_t i = 0;
    while (i < header.properties.size() && header.properties[i].name != wanted[axis]) ++i;
    if (i == header.properties.size())
      return make_error(ErrorCode::kInvalid, "{}: its vertices have no {}", path, wanted[axis]);
    header.xyz[axis] = i;
  }
  return header;
}

template <typename Value>
float load(const char* source) {
  Value value;
  std::memcpy(&value, source, sizeof(Value));
  return static_cast<float>(value);
}

float binary_value(const char* vertex, const Property& property) {
  const char* const source = vertex + property.offset;
  const std::string& type = property.type;
  if (type == "float" || type == "float32") return load<float>(source);
  if (type == "double" || type == "float64") return load<double>(source);
  if (type == "int" || type == "int32") return load<std::int32_t>(source);
  if (type == "uint" || type == "uint32") return load<std::uint32_t>(source);
  if (type == "short" || type == "int16") return load<std::int16_t>(source);
  if (type == "ushort" || type == "uint16") return load<std::uint16_t>(source);
  if (type == "char" || type == "int8") return load<std::int8_t>(source);
  return load<std::uint8_t>(source);
}

bool read_binary(std::istream& file, const Header& header, std::vector<Eigen::Vector3f>& points) {
  std::vector<char> vertex(header.vertex_size);
  for (std::size_t i = 0; i < header.num_vertices; ++i) {
    if (!file.read(vertex.data(), static_cast<std::streamsize>(vertex.size()))) return false;
    const auto value = [&](int axis) {
      return binary_value(vertex.data(), header.properties[header.xyz[static_cast<std::size_t>(axis)]]);
    };
    points.emplace_back(value(0), value(1), value(2));
  }
  return true;
}

bool read_ascii(std::istream& file, const Header& header, std::vector<Eigen::Vector3f>& points) {
  std::vector<float> values(header.properties.size());
  for (std::size_t i = 0; i < header.num_vertices; ++i) {
    for (float& value : values) {
      std::string word;  // by strtof, since streams do not read "nan"
      if (!(file >> word)) return false;
      char* end = nullptr;
      value = std::strtof(word.c_str(), &end);
      if (end == word.c_str()) return false;
    }
    points.emplace_back(values[header.xyz[0]], values[header.xyz[1]], values[header.xyz[2]]);
  }
  return true;
}

}  // namespace

Result<std::vector<Eigen::Vector3f>> read_ply(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return make_error(ErrorCode::kNotFound, "{}: cannot be read: {}", path, std::strerror(errno));
  const auto header = read_header(file, path);
  if (!header.ok()) return header.error();
  std::vector<Eigen::Vector3f> points;
  const bool ok =
      header->format == "ascii" ? read_ascii(file, *header, points) : read_binary(file, *header, points);
  if (!ok) {
    return make_error(ErrorCode::kInvalid, "{}: ends after {} of {} vertices", path, points.size(),
                      header->num_vertices);
  }
  return points;
}

}  // namespace mmlins::io

// SPDX-License-Identifier: MIT
#include "mmlins/base/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace mmlins {

Status write_text_file(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) {
    const std::string reason = std::strerror(errno);
    std::remove(temporary.c_str());
    return make_error(ErrorCode::kIo, "cannot write {}: {}", path, reason);
  }
  if (std::rename(temporary.c_str(), path.c_str()) != 0) {
    const std::string reason = std::strerror(errno);
    std::remove(temporary.c_str());
    return make_error(ErrorCode::kIo, "cannot write {}: {}", path, reason);
  }
  return {};
}

Result<std::string> read_text_file(const std::string& path) {
  if (std::filesystem::is_directory(path)) return make_error(ErrorCode::kIo, "{} is a folder, not a file", path);
  std::ifstream file(path, std::ios::binary);
  if (!file) return make_error(ErrorCode::kNotFound, "cannot read {}: {}", path, std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace mmlins

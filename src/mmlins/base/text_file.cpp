// SPDX-License-Identifier: MIT
#include "mmlins/base/text_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace mmlins {

Error cannot_write(const std::string& path, int reason) {
  const char* const advice = reason == ENOSPC ? "; free some space" : "";
  return make_error(ErrorCode::kIo, "{}: cannot be written: {}{}", path, std::strerror(reason), advice);
}

Status write_text_file(const std::string& path, const std::string& text) {
  const std::string temporary = path + ".part";
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (file && std::rename(temporary.c_str(), path.c_str()) == 0) return {};
  const int reason = errno;
  std::remove(temporary.c_str());
  return cannot_write(path, reason);
}

Result<std::string> read_text_file(const std::string& path) {
  std::error_code failure;
  if (std::filesystem::is_directory(path, failure)) {
    return make_error(ErrorCode::kInvalid, "{}: is a folder; give a file", path);
  }
  std::ifstream file(path, std::ios::binary);
  if (!file && errno == ENOENT) return make_error(ErrorCode::kNotFound, "{}: no such file; check the path", path);
  if (!file) return make_error(ErrorCode::kIo, "{}: cannot be read: {}", path, std::strerror(errno));
  std::ostringstream text;
  text << file.rdbuf();
  if (file.bad()) return make_error(ErrorCode::kIo, "{}: reading failed; check the disk", path);
  return text.str();
}

}  // namespace mmlins

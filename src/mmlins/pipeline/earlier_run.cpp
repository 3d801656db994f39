// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/earlier_run.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/pipeline/run_files.hpp"

namespace mmlins::pipeline {
namespace {

namespace fs = std::filesystem;

bool is_part_of_a_run(const std::string& name) {
  return name == "atlas" || std::find(std::begin(kRunFiles), std::end(kRunFiles), name) != std::end(kRunFiles);
}

bool holds_a_run(const std::string& folder) {
  std::error_code failure;
  // Folders under the names of files are somebody else's.
  return fs::exists(folder + "/atlas", failure) || std::any_of(std::begin(kRunFiles), std::end(kRunFiles), [&](const char* name) {
           return fs::is_regular_file(folder + "/" + name, failure);
         });
}

/// The atlas first: it alone may refuse.
Status move_run(const std::string& from, const std::string& to) {
  if (const Status status = atlas::Atlas::move(from + "/atlas", to + "/atlas"); !status) return status;
  std::error_code failure;
  for (const char* name : kRunFiles) {
    if (!fs::is_regular_file(from + "/" + name, failure)) continue;
    fs::rename(from + "/" + name, to + "/" + name, failure);
    if (failure) return make_error(ErrorCode::kIo, "{}/{}: cannot be moved to {}: {}", from, name, to, failure.message());
  }
  return {};
}

Status remove_folder(const std::string& folder) {
  std::error_code failure;
  fs::remove_all(folder, failure);
  if (failure) return make_error(ErrorCode::kIo, "{}: cannot be removed: {}", folder, failure.message());
  return {};
}

}  // namespace

bool EarlierRun::exists() const {
  std::error_code failure;
  return fs::exists(aside_, failure);
}

Status EarlierRun::check_aside() const {
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(aside_, failure)) {
    const std::string name = entry.path().filename().string();
    if (is_part_of_a_run(name)) continue;
    return make_error(ErrorCode::kInvalid, "{}: holds {}, which is no part of a run; choose another folder with --out", aside_, name);
  }
  return {};
}

Result<EarlierRun> EarlierRun::put_aside(const std::string& folder) {
  const EarlierRun earlier(folder);
  if (earlier.exists()) {
    if (const Status status = earlier.check_aside(); !status) return status.error();
    std::error_code failure;
    const bool is_whole = fs::exists(folder + "/summary.json", failure);
    // Left by a run that was killed: the atlas is replaced when the next one is made.
    if (!is_whole) return earlier;
    if (const Status status = remove_folder(earlier.aside_); !status) return status.error();
  }
  if (!holds_a_run(folder)) return earlier;
  std::error_code failure;
  fs::create_directory(earlier.aside_, failure);
  if (failure) return make_error(ErrorCode::kIo, "{}: cannot be made: {}", earlier.aside_, failure.message());
  if (const Status status = move_run(folder, earlier.aside_); !status) {
    // What was moved already goes back.
    if (const Status back = earlier.put_back(); !back) return back.error();
    return status.error();
  }
  return earlier;
}

Status EarlierRun::put_back() const {
  if (!exists()) return {};
  if (const Status status = move_run(aside_, folder_); !status) return status;
  return remove_folder(aside_);
}

Status EarlierRun::remove() const { return exists() ? remove_folder(aside_) : Status{}; }

}  // namespace mmlins::pipeline

// SPDX-License-Identifier: MIT
#pragma once
// A run into a folder that holds one already: the earlier one is kept until there is something in its place, and the two
// are never mixed.

#include <string>

#include "mmlins/base/result.hpp"

namespace mmlins::pipeline {

class EarlierRun {
 public:
  /// Moves what a run has left in the folder into `earlier_run` below it. One that lies there already is the last that came to its
  /// end: it stays there, and what a killed run has left is removed.
  /// @return an error if what is there is no part of a run, or is being written; nothing has been moved then
  [[nodiscard]] static Result<EarlierRun> put_aside(const std::string& folder);

  [[nodiscard]] bool exists() const;
  /// The new run came to nothing: all is as it was.
  [[nodiscard]] Status put_back() const;
  /// The new run is whole.
  [[nodiscard]] Status remove() const;

 private:
  explicit EarlierRun(std::string folder) : folder_(std::move(folder)), aside_(folder_ + "/earlier_run") {}
  [[nodiscard]] Status check_aside() const;

  std::string folder_;
  std::string aside_;
};

}  // namespace mmlins::pipeline

// SPDX-License-Identifier: MIT
#pragma once
// The files of the page, compiled into the program (cmake/embed_page.cmake).

#include <string>
#include <vector>

namespace mmlins::report {

struct PageFile {
  std::string name;
  std::string text;
};

[[nodiscard]] std::vector<PageFile> page_files();

}  // namespace mmlins::report

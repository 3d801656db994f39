// SPDX-License-Identifier: MIT
#pragma once
// Which request gets which answer. Knows nothing of sockets.

#include <string>
#include <string_view>

namespace mmlins::view {

struct Response {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

/// What a page is shown. Its functions may be called from any thread.
class Content {
 public:
  Content() = default;
  virtual ~Content() = default;
  Content(const Content&) = delete;
  Content& operator=(const Content&) = delete;

  /// JSON: name, begin, summary, maps, scans; all there is at this moment.
  [[nodiscard]] virtual std::string scene() = 0;
  /// One level of the points of a run of keyframes, or a line that says why there is none.
  [[nodiscard]] virtual Response tile(int first, int last, int level) = 0;
};

/// @param target  path of a request, such as /api/tiles/0-15/2
[[nodiscard]] Response answer(std::string_view target, Content& content);

/// Whether a request was meant for this machine, and comes from a page of ours: pages of others can neither
/// ask under a name of theirs that leads here, nor open a connection for themselves.
[[nodiscard]] bool is_own_host(std::string_view host);
[[nodiscard]] bool is_same_origin(std::string_view origin, std::string_view host);

/// The page, a whole HTML document; empty if the program was built without it.
[[nodiscard]] std::string_view page();

}  // namespace mmlins::view

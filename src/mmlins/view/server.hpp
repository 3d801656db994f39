// SPDX-License-Identifier: MIT
#pragma once
// Serves the page to browsers of this machine, or of others if asked to. It has threads of its own.

#include <memory>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/view/live_feed.hpp"
#include "mmlins/view/router.hpp"

namespace mmlins::view {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< of this machine; 0.0.0.0: all it has
  int port = 0;                       ///< 0: one that is free
  int num_threads = 2;
  bool yields = false;  ///< its threads give way to all others: what goes on beside it comes first
};

class Server {
 public:
  /// @param content  what is shown; must outlive the server
  /// @param feed     what is sent by /api/live as it comes; none: there is no such path. It must outlive the
  /// server
  /// @return one line that says why the address cannot be listened on
  [[nodiscard]] static Result<std::unique_ptr<Server>> start(const ServerOptions& options, Content& content,
                                                             LiveFeed* feed = nullptr);
  /// Ends all connections.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  [[nodiscard]] int port() const;
  /// For a browser.
  [[nodiscard]] std::string url() const;

 private:
  struct Parts;
  explicit Server(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace mmlins::view

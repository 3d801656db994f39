// SPDX-License-Identifier: MIT
#pragma once
// Connections to browsers, one object each, kept alive by its pending operations. Internal to view/.

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <memory>
#include <optional>
#include <string>

#include "mmlins/view/live_feed.hpp"
#include "mmlins/view/router.hpp"

namespace mmlins::view {

class LiveSessions;

/// What all connections of a server share.
struct Serving {
  Content& content;
  LiveFeed* feed = nullptr;
  LiveSessions* live = nullptr;  ///< none without a feed
  bool only_this_machine = true;
};

class HttpSession : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(boost::asio::ip::tcp::socket socket, const Serving& serving)
      : stream_(std::move(socket)), serving_(serving) {}
  /// To be called on the strand of its socket.
  void read();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;
  using Reply = boost::beast::http::response<boost::beast::http::string_body>;

  void handle(Request request);
  [[nodiscard]] Reply reply_to(const Request& request);
  void write(Reply reply);

  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  std::optional<Reply> reply_;
  const Serving& serving_;
};

}  // namespace mmlins::view

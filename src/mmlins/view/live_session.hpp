// SPDX-License-Identifier: MIT
#pragma once
// WebSocket connections that are told the news. Internal to view/.

#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "mmlins/view/live_feed.hpp"

namespace mmlins::view {

class LiveSession;

/// Those that are open.
class LiveSessions {
 public:
  void add(const std::shared_ptr<LiveSession>& session);
  /// Lets each look for news, in its own strand.
  void wake();

 private:
  std::mutex mutex_;
  std::vector<std::weak_ptr<LiveSession>> sessions_;
};

class LiveSession : public std::enable_shared_from_this<LiveSession> {
 public:
  LiveSession(boost::asio::ip::tcp::socket socket, LiveFeed& feed)
      : stream_(std::move(socket)), feed_(feed) {}

  void accept(const boost::beast::http::request<boost::beast::http::empty_body>& request,
              LiveSessions& sessions);
  /// From any thread.
  void wake();

 private:
  /// Sends what is new, unless it is still sending.
  void send();
  /// Clients have nothing to say, but that they leave is learnt by reading.
  void read();

  boost::beast::websocket::stream<boost::beast::tcp_stream> stream_;
  boost::beast::flat_buffer buffer_;
  LiveFeed& feed_;
  FeedPosition position_;
  std::shared_ptr<const std::string> sending_;
};

}  // namespace mmlins::view

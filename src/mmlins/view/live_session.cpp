// SPDX-License-Identifier: MIT
#include "mmlins/view/live_session.hpp"

#include <algorithm>
#include <boost/asio/dispatch.hpp>
#include <boost/asio/post.hpp>

namespace mmlins::view {

namespace beast = boost::beast;
namespace websocket = beast::websocket;

void LiveSessions::add(const std::shared_ptr<LiveSession>& session) {
  const std::lock_guard lock(mutex_);
  sessions_.push_back(session);
}

void LiveSessions::wake() {
  const std::lock_guard lock(mutex_);
  std::erase_if(sessions_, [](const auto& session) { return session.expired(); });
  for (const auto& session : sessions_) {
    if (const auto alive = session.lock()) alive->wake();
  }
}

void LiveSession::accept(const beast::http::request<beast::http::empty_body>& request,
                         LiveSessions& sessions) {
  stream_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  stream_.read_message_max(1024);
  stream_.auto_fragment(false);  // the message is in memory anyway
  stream_.async_accept(request, [self = shared_from_this(), &sessions](beast::error_code failure) {
    if (failure) return;
    sessions.add(self);
    self->read();
    self->send();
  });
}

void LiveSession::wake() {
  boost::asio::post(stream_.get_executor(), [self = shared_from_this()] { self->send(); });
}

void LiveSession::send() {
  if (sending_) return;
  sending_ = feed_.news(position_);
  if (!sending_) return;
  stream_.text(true);
  stream_.async_write(boost::asio::buffer(*sending_),
                      [self = shared_from_this()](beast::error_code failure, std::size_t) {
                        if (failure) return;  // sending_ stays: nothing more will be sent
                        self->sending_.reset();
                        self->send();
                      });
}

void LiveSession::read() {
  stream_.async_read(buffer_, [self = shared_from_this()](beast::error_code failure, std::size_t) {
    self->buffer_.consume(self->buffer_.size());
    if (!failure) self->read();
  });
}

}  // namespace mmlins::view

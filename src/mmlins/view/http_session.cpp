// SPDX-License-Identifier: MIT
#include "mmlins/view/http_session.hpp"

#include <boost/asio/dispatch.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>

#include "mmlins/view/live_session.hpp"

namespace mmlins::view {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

constexpr std::chrono::seconds kPatience{60};
constexpr std::uint32_t kMaxHeader = 16 * 1024;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

void HttpSession::read() {
  parser_.emplace();
  parser_->header_limit(kMaxHeader);
  stream_.expires_after(kPatience);
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](beast::error_code failure, std::size_t) {
                     if (!failure) return self->handle(self->parser_->release());
                     beast::error_code ignored;
                     self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
                   });
}

void HttpSession::handle(Request request) {
  const bool is_ours =
      is_same_origin(view_of(request[http::field::origin]), view_of(request[http::field::host])) &&
      (!serving_.only_this_machine || is_own_host(view_of(request[http::field::host])));
  if (serving_.live && is_ours && beast::websocket::is_upgrade(request) && request.target() == "/api/live") {
    stream_.expires_never();
    return std::make_shared<LiveSession>(stream_.release_socket(), *serving_.feed)
        ->accept(request, *serving_.live);
  }
  write(reply_to(request));
}

HttpSession::Reply HttpSession::reply_to(const Request& request) {
  Response response;
  const bool is_own = !serving_.only_this_machine || is_own_host(view_of(request[http::field::host]));
  if (!is_own) {
    response = {403, response.type, "only names of this machine are answered\n"};
  } else if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response = {405, response.type, "there is nothing here but to be read\n"};
  } else {
    response = answer(view_of(request.target()), serving_.content);
  }
  Reply reply{static_cast<http::status>(response.status), request.version()};
  reply.set(http::field::content_type, response.type);
  reply.set(http::field::cache_control, "no-store");
  reply.set("X-Content-Type-Options", "nosniff");
  reply.set("Content-Security-Policy", kPolicy);
  if (response.status == 405) reply.set(http::field::allow, "GET, HEAD");
  reply.keep_alive(request.keep_alive());
  const std::size_t size = response.body.size();
  if (request.method() != http::verb::head) reply.body() = std::move(response.body);
  reply.content_length(size);
  return reply;
}

void HttpSession::write(Reply reply) {
  reply_.emplace(std::move(reply));
  stream_.expires_after(kPatience);
  http::async_write(stream_, *reply_, [self = shared_from_this()](beast::error_code failure, std::size_t) {
    if (failure) return;
    if (self->reply_->keep_alive()) return self->read();
    beast::error_code ignored;
    self->stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

}  // namespace mmlins::view

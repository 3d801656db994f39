// SPDX-License-Identifier: MIT
#include "mmlins/view/server.hpp"

#include <sys/resource.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <thread>
#include <vector>

#include "mmlins/view/http_session.hpp"
#include "mmlins/view/live_session.hpp"

namespace mmlins::view {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kRefresh{200};
constexpr int kNice = 10;

Error cannot_listen(const ServerOptions& options, const boost::system::error_code& failure) {
  if (failure == asio::error::address_in_use) {
    return make_error(ErrorCode::kIo, "port {} of {} is in use; leave --port out and a free one is taken",
                      options.port, options.address);
  }
  if (failure == asio::error::access_denied) {
    return make_error(ErrorCode::kIo,
                      "port {} may not be used without special rights; choose one above 1023 with --port",
                      options.port);
  }
  return make_error(ErrorCode::kIo, "{} port {}: cannot be listened on: {}", options.address, options.port,
                    failure.message());
}

}  // namespace

struct Server::Parts {
  Parts(Content& content, LiveFeed* feed) : serving{content, feed, feed ? &live : nullptr, true} {}

  [[nodiscard]] boost::system::error_code listen(const tcp::endpoint& endpoint);
  void accept();
  void refresh();

  LiveSessions live;
  Serving serving;
  asio::io_context context;
  tcp::acceptor acceptor{context};
  asio::steady_timer timer{context};
  std::string address;
  std::vector<std::thread> threads;
};

boost::system::error_code Server::Parts::listen(const tcp::endpoint& endpoint) {
  boost::system::error_code failure;
  acceptor.open(endpoint.protocol(), failure);
  if (!failure) acceptor.set_option(asio::socket_base::reuse_address(true), failure);
  if (!failure) acceptor.bind(endpoint, failure);
  if (!failure) acceptor.listen(asio::socket_base::max_listen_connections, failure);
  return failure;
}

void Server::Parts::accept() {
  acceptor.async_accept(asio::make_strand(context),
                        [this](boost::system::error_code failure, tcp::socket socket) {
                          if (failure == asio::error::operation_aborted) return;
                          if (!failure) {
                            const auto executor = socket.get_executor();
                            auto session = std::make_shared<HttpSession>(std::move(socket), serving);
                            asio::post(executor, [session] { session->read(); });
                          }
                          accept();
                        });
}

void Server::Parts::refresh() {
  serving.feed->refresh();
  live.wake();
  timer.expires_after(kRefresh);
  timer.async_wait([this](boost::system::error_code failure) {
    if (!failure) refresh();
  });
}

Server::Server(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

Result<std::unique_ptr<Server>> Server::start(const ServerOptions& options, Content& content,
                                              LiveFeed* feed) {
  boost::system::error_code failure;
  const auto address =
      asio::ip::make_address(options.address == "localhost" ? "127.0.0.1" : options.address, failure);
  if (failure)
    return make_error(ErrorCode::kInvalid,
                      "--listen {}: give an IP address of this machine, such as 127.0.0.1", options.address);
  auto parts = std::make_unique<Parts>(content, feed);
  failure = parts->listen({address, static_cast<unsigned short>(options.port)});
  if (failure) return cannot_listen(options, failure);
  parts->serving.only_this_machine = address.is_loopback();
  parts->address = address.is_unspecified() ? "127.0.0.1"
                   : address.is_v6()        ? "[" + address.to_string() + "]"
                                            : address.to_string();
  parts->accept();
  if (feed) asio::post(parts->context, [raw = parts.get()] { raw->refresh(); });
  for (int i = 0; i < options.num_threads; ++i) {
    parts->threads.emplace_back([raw = parts.get(), yields = options.yields] {
      if (yields) setpriority(PRIO_PROCESS, 0, kNice);  // on Linux: of this thread alone
      raw->context.run();
    });
  }
  return std::unique_ptr<Server>(new Server(std::move(parts)));
}

Server::~Server() {
  parts_->context.stop();
  for (std::thread& thread : parts_->threads) thread.join();
}

int Server::port() const {
  boost::system::error_code ignored;
  return parts_->acceptor.local_endpoint(ignored).port();
}

std::string Server::url() const { return fmt::format("http://{}:{}/", parts_->address, port()); }

}  // namespace mmlins::view

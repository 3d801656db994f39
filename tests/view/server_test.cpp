// SPDX-License-Identifier: MIT
#include "mmlins/view/server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "mmlins/view/live_run.hpp"
#include "tests/view/example_run.hpp"

namespace mmlins::view {
namespace {

/// The whole answer to a request; "" if there is none.
std::string ask(int port, const std::string& target, const std::string& method = "GET") {
  const int descriptor = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  std::string answer;
  if (connect(descriptor, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0) {
    const std::string request =
        method + " " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    if (send(descriptor, request.data(), request.size(), MSG_NOSIGNAL) > 0) {
      char buffer[4096];
      for (ssize_t count = 0; (count = recv(descriptor, buffer, sizeof(buffer), 0)) > 0;) {
        answer.append(buffer, static_cast<std::size_t>(count));
      }
    }
  }
  close(descriptor);
  return answer;
}

class Served : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_example_atlas(folder_.path(), atlas::MapState::kActive));
    auto opened = LiveRun::open(folder_.path());
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    run_ = std::move(*opened);
    auto started = Server::start({.num_threads = 2, .yields = true}, *run_, run_.get());
    ASSERT_TRUE(started.ok()) << started.error().message;
    server_ = std::move(*started);
  }

  atlas::TemporaryFolder folder_;
  std::unique_ptr<LiveRun> run_;
  std::unique_ptr<Server> server_;
};

TEST_F(Served, APortIsTakenOnce) {
  EXPECT_GT(server_->port(), 0);
  EXPECT_EQ(server_->url(), "http://127.0.0.1:" + std::to_string(server_->port()) + "/");
  const auto second = Server::start({.port = server_->port()}, *run_);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().message.find("is in use"), std::string::npos) << second.error().message;
}

TEST_F(Served, HeadHasTheHeaderOfGetAndNoBody) {
  const std::string get = ask(server_->port(), "/api/tiles/0-9/4");
  const std::string head = ask(server_->port(), "/api/tiles/0-9/4", "HEAD");
  EXPECT_TRUE(get.starts_with("HTTP/1.1 200"));
  EXPECT_EQ(head, get.substr(0, get.find("\r\n\r\n") + 4));
}

/// Also what a thread sanitizer has to look at.
TEST_F(Served, RequestsAndScansComeAtTheSameTime) {
  constexpr int kScans = 2000;
  std::thread odometry([this] {
    for (int i = 0; i < kScans; ++i) {
      run_->add({time_from_ns(1'600'000'000'000'000'000 + 100'000'000LL * i), {}, 0, "TRACKING", "", 1.0F});
    }
  });
  std::vector<std::thread> browsers;
  std::atomic<int> num_answers = 0;
  for (int browser = 0; browser < 3; ++browser) {
    browsers.emplace_back([&, browser] {
      for (int i = 0; i < 10; ++i) {
        const std::string target =
            i % 2 == 0 ? "/api/scene" : "/api/tiles/0-9/" + std::to_string((i + browser) % 5);
        if (ask(server_->port(), target).starts_with("HTTP/1.1 200")) ++num_answers;
      }
    });
  }
  odometry.join();
  for (std::thread& browser : browsers) browser.join();
  run_->let_go();
  EXPECT_EQ(num_answers, 30);
  EXPECT_TRUE(ask(server_->port(), "/api/tiles/0-9/0").starts_with("HTTP/1.1 204"));
  FeedPosition position;
  (void)run_->news(position);
  EXPECT_EQ(position.num_scans, static_cast<std::size_t>(kScans));
}

}  // namespace
}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#pragma once
// News of a run that goes on. A client that has taken what it was sent asks for what is new since then, so
// that a slow one gets news less often and in larger pieces, and nothing queues up.

#include <cstddef>
#include <memory>
#include <string>

namespace mmlins::view {

/// How much a client has been sent.
struct FeedPosition {
  std::size_t num_scans = 0;
  int atlas_version = -1;
  bool was_told_the_end = false;
};

class LiveFeed {
 public:
  LiveFeed() = default;
  virtual ~LiveFeed() = default;
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;

  /// Takes note of what has happened. Called by the server every 200 ms, from one thread at a time.
  virtual void refresh() = 0;
  /// The message that brings a client up to date, of which the position is then told; null if there is no
  /// news.
  [[nodiscard]] virtual std::shared_ptr<const std::string> news(FeedPosition& position) = 0;
};

}  // namespace mmlins::view

// SPDX-License-Identifier: MIT
#include "mmlins/base/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <memory>
#include <thread>

namespace mmlins::parallel {
namespace {
struct ThreadLimit {
  int num_threads = 0;
  std::unique_ptr<tbb::global_control> control;
};
// TBB keeps its limit per process, so this is the one place where the project does too.
ThreadLimit& thread_limit() {
  static ThreadLimit limit;
  return limit;
}
}  // namespace

void set_num_threads(int num_threads) {
  ThreadLimit& limit = thread_limit();
  limit.num_threads = num_threads;
  limit.control.reset();
  if (num_threads > 0) {
    limit.control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                          static_cast<std::size_t>(num_threads));
  }
}

int num_threads() {
  const int limit = thread_limit().num_threads;
  return limit > 0 ? limit : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

void for_each_chunk(std::size_t num_chunks, const std::function<void(std::size_t)>& body) {
  if (num_chunks <= 1 || num_threads() == 1) {
    for (std::size_t chunk = 0; chunk < num_chunks; ++chunk) body(chunk);
    return;
  }
  tbb::parallel_for(std::size_t{0}, num_chunks, body);
}

}  // namespace mmlins::parallel

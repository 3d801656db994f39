// SPDX-License-Identifier: MIT
#include "mmlins/view/live_run.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/view/example_run.hpp"

namespace mmlins::view {
namespace {

class Live : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_example_atlas(folder_.path(), atlas::MapState::kActive));
    auto opened = LiveRun::open(folder_.path());
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    run_ = std::move(*opened);
  }
  void add(int count) {
    for (int i = 0; i < count; ++i) {
      run_->add({time_from_ns(1'600'000'000'000'000'000 + 100'000'000LL * num_added_++),
                 {},
                 0,
                 "TRACKING",
                 "",
                 1.0F});
    }
  }
  /// What a client is told; "" if nothing.
  std::string news(FeedPosition& position) {
    const auto text = run_->news(position);
    return text ? *text : "";
  }

  atlas::TemporaryFolder folder_;
  std::unique_ptr<LiveRun> run_;
  int num_added_ = 0;
};

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST_F(Live, NewsAreWhatAClientHasNotBeenTold) {
  FeedPosition quick;
  FeedPosition slow;
  add(3);
  run_->refresh();
  const std::string first = news(quick);
  EXPECT_TRUE(has(first, R"("from":0)") && has(first, R"("t":[0.000,0.100,0.200])") &&
              has(first, R"("blocks")"))
      << first;
  EXPECT_EQ(news(quick), "");
  add(2);
  run_->refresh();
  const std::string second = news(quick);
  EXPECT_TRUE(has(second, R"("from":3)") && has(second, R"("t":[0.300,0.400])")) << second;
  EXPECT_FALSE(has(second, "blocks"));  // the maps are as they were
  EXPECT_TRUE(has(news(slow), R"("t":[0.000,0.100,0.200,0.300,0.400])"));
}

TEST_F(Live, AScanThatFindsNoRoomIsLeftOutAndNothingWaits) {
  add(5000);
  EXPECT_EQ(run_->num_left_out(), 5000 - 4096);
  run_->refresh();
  add(10);
  EXPECT_EQ(run_->num_left_out(), 5000 - 4096);
  run_->refresh();
  FeedPosition position;
  (void)news(position);
  EXPECT_EQ(position.num_scans, 4106U);
}

TEST_F(Live, TheSceneIsLiveUntilTheRunHasEnded) {
  add(1);
  run_->refresh();
  EXPECT_TRUE(has(run_->scene(), R"("live":true)"));
  EXPECT_EQ(run_->tile(0, 9, 0).status, 200);
  run_->let_go();
  EXPECT_EQ(run_->tile(0, 9, 0).status, 204);
  EXPECT_FALSE(run_->end(folder_.path()).ok());  // its files are not there
  {
    auto atlas =
        atlas::Atlas::open(folder_ / "atlas", atlas::Access::kWrite);  // lets the active map fall asleep
    ASSERT_TRUE(atlas.ok());
  }
  ASSERT_TRUE(write_example_files(folder_.path()));
  const Status ended = run_->end(folder_.path());
  ASSERT_TRUE(ended.ok()) << ended.error().message;
  FeedPosition position;
  EXPECT_EQ(news(position), R"({"ended":true})");
  EXPECT_EQ(news(position), "");
  EXPECT_TRUE(has(run_->scene(), R"("live":false)"));
  EXPECT_EQ(run_->tile(0, 9, 0).status, 200);
}

/// Whether other processes see that somebody has the file open. To be asked by one of them.
bool is_locked_for_others(const std::string& path) {
  const pid_t child = fork();
  if (child == 0) {
    struct flock lock {};
    lock.l_type = F_WRLCK;
    const bool has_answer = fcntl(::open(path.c_str(), O_RDWR), F_GETLK, &lock) == 0;
    _exit(has_answer && lock.l_type != F_UNLCK ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 1;
}

TEST(LiveRun, LeavesTheWriterOfTheAtlasItsLocks) {
  const atlas::TemporaryFolder folder;
  auto writer = atlas::Atlas::create(folder / "atlas");
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer->add_map(atlas::example_map(0)).ok() && writer->commit().ok());
  const std::string index = folder / "atlas/index.sqlite";
  ASSERT_TRUE(is_locked_for_others(index));
  {
    const auto run = LiveRun::open(folder.path());
    ASSERT_TRUE(run.ok());
    EXPECT_TRUE(is_locked_for_others(index));
  }
  EXPECT_TRUE(is_locked_for_others(index));
}

}  // namespace
}  // namespace mmlins::view

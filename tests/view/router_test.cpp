// SPDX-License-Identifier: MIT
#include "mmlins/view/router.hpp"

#include <gtest/gtest.h>

#include "mmlins/view/recorded_run.hpp"
#include "tests/view/example_run.hpp"

namespace mmlins::view {
namespace {

class Router : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_example_atlas(folder_.path()) && write_example_files(folder_.path()));
    const auto run = open_run(folder_.path());
    ASSERT_TRUE(run.ok()) << run.error().message;
    content_ = std::make_unique<RecordedRun>(*run);
  }
  Response get(const std::string& target) { return answer(target, *content_); }

  atlas::TemporaryFolder folder_;
  std::unique_ptr<RecordedRun> content_;
};

TEST_F(Router, GivesThePage) {
  EXPECT_EQ(get("/").status, 200);
  EXPECT_EQ(get("/").body, page());
  EXPECT_EQ(get("/?x=1").body, page());
}

TEST_F(Router, TheSceneHasEverythingButTheConfiguration) {
  const Response scene = get("/api/scene");
  EXPECT_EQ(scene.status, 200);
  EXPECT_EQ(scene.type, "application/json");
  for (const char* part : {R"("live":false)", R"("scans":3)", R"("begin":"1600000000.000000000")",
                           R"("id":[0,1,2,)", R"("kind":"merge")", R"("blocks":[[0,0,9,500],[1,10,19,500]])",
                           R"("states":["INITIALIZING","TRACKING","LOST"])", R"("closure":-11)",
                           R"("note":"it's \"ours\"")", R"("evidence":{"closures":[-11]})"}) {
    EXPECT_NE(scene.body.find(part), std::string::npos) << part << " is not in " << scene.body;
  }
  EXPECT_EQ(scene.body.find("config"), std::string::npos);
}

TEST_F(Router, TilesOfAllBlocksHoldAllPoints) {
  std::size_t num_points = 0;
  for (const char* block : {"0-9", "10-19"}) {
    for (int level = 0; level < 5; ++level) {
      const Response tile = get("/api/tiles/" + std::string(block) + "/" + std::to_string(level));
      ASSERT_EQ(tile.status, 200) << tile.body;
      EXPECT_EQ((tile.body.size() - 68) % 10, 0U);
      num_points += (tile.body.size() - 68) / 10;
    }
  }
  EXPECT_EQ(num_points, 20U * kExamplePoints);
}

TEST_F(Router, RequestsThatMakeNoSenseAreRefused) {
  for (const char* bad :
       {"/api/tiles/", "/api/tiles/1", "/api/tiles/1-2", "/api/tiles/1-2/", "/api/tiles/a-2/0",
        "/api/tiles/1-2/0x", "/api/tiles/-1-2/0", "/api/tiles/1-2/5", "/api/tiles/5-2/0",
        "/api/tiles/0-4096/0", "/api/tiles/99999999999999999999-2/0", "/api/tiles/1-2/-1"}) {
    EXPECT_EQ(get(bad).status, 400) << bad;
  }
  for (const char* unknown :
       {"", "/api", "/api/scene/", "/../secret", "/atlas/index.sqlite", "/api/tiles/20-21/0"}) {
    EXPECT_EQ(get(unknown).status, 404) << unknown;
  }
}

TEST_F(Router, TheSameTileComesFromMemoryAndAfterItWasForgotten) {
  const auto open = [this] {
    auto opened = atlas::Atlas::open(folder_ / "atlas", atlas::Access::kRead);
    return std::make_shared<const atlas::Atlas>(std::move(opened).value());
  };
  TileStore forgetful(open(), 1);
  TileStore generous(open());
  for (int round = 0; round < 2; ++round) {
    for (const int first : {0, 10})
      EXPECT_EQ(*forgetful.tile(first, first + 9, 3), *generous.tile(first, first + 9, 3));
  }
}

TEST(Hosts, OnlyThisMachineIsAnswered) {
  for (const char* own : {"localhost", "localhost:80", "127.0.0.1:8000", "[::1]:8000", "[::1]"})
    EXPECT_TRUE(is_own_host(own)) << own;
  for (const char* other : {"", "example.org", "example.org:80", "localhost.example.org",
                            "127.0.0.1.example.org", "10.0.0.1", "[::2]:80"}) {
    EXPECT_FALSE(is_own_host(other)) << other;
  }
}

TEST(Hosts, OtherPagesAreOthers) {
  EXPECT_TRUE(is_same_origin("", "localhost:80"));
  EXPECT_TRUE(is_same_origin("http://localhost:81", "localhost:81"));
  EXPECT_FALSE(is_same_origin("http://localhost:82", "localhost:81"));
  EXPECT_FALSE(is_same_origin("http://example.org", "localhost:81"));
  EXPECT_FALSE(is_same_origin("null", "localhost:81"));
}

}  // namespace
}  // namespace mmlins::view

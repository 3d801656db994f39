// SPDX-License-Identifier: MIT
// Recognition and registration of submaps on simulated revisits: what is found, and how long it takes.
// Recall is that at 100 % precision: the share of queries whose best candidate scores above the best wrong
// one.
// --benchmark_filter=Recall/campus chooses; each of those takes up to a minute, most of it for the simulator.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "mmlins/base/parallel.hpp"
#include "mmlins/place/place_database.hpp"
#include "mmlins/place/scan_context.hpp"
#include "mmlins/registration/search_around.hpp"
#include "mmlins/registration/verify.hpp"
#include "tests/place/simulated_submaps.hpp"

namespace mmlins {
namespace {

using keyframe::Submap;
using math::SE3;
using place_test::DriveSpec;
using place_test::Site;
using place_test::true_T;

constexpr double kDeg = M_PI / 180.0;

struct Scene {
  std::string name;
  sim::SceneKind kind;
  double speed;     // [m/s]
  double duration;  // [s]
};

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all{{"campus", sim::SceneKind::kCampus, 4.0, 90.0},
                                      {"urban", sim::SceneKind::kUrban, 6.0, 70.0},
                                      {"hall", sim::SceneKind::kHall, 1.5, 55.0}};
  return all;
}

struct Answer {
  double score;
  bool right;
};

double recall(std::vector<Answer> answers) {
  std::sort(answers.begin(), answers.end(),
            [](const Answer& a, const Answer& b) { return a.score > b.score; });
  const auto wrong = std::find_if(answers.begin(), answers.end(), [](const Answer& a) { return !a.right; });
  return answers.empty() ? 0.0
                         : static_cast<double>(wrong - answers.begin()) / static_cast<double>(answers.size());
}

double yaw_of(const SE3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

struct Revisit {
  Scene scene;
  std::string old_sensor, new_sensor;
  bool reverse;
  double offset;  // [m]
};

/// The first drive through a scene; kept, because several revisits share it.
const std::vector<Submap>& first_drive(const Scene& scene, const Site& site, const std::string& sensor) {
  static std::map<std::string, std::vector<Submap>> drives;
  auto& drive = drives[scene.name + sensor];
  if (drive.empty())
    drive = site.submaps({.sensor = sensor, .duration = scene.duration, .step = 1.5, .seed = 1});
  return drive;
}

const Site& site_of(const Scene& scene) {
  static std::map<std::string, std::unique_ptr<Site>> sites;
  auto& site = sites[scene.name];
  if (!site) site = std::make_unique<Site>(scene.kind, 1, scene.speed);
  return *site;
}

Answer ask_default(const place::PlaceDatabase& database, const std::vector<Submap>& places,
                   const Submap& query) {
  const auto best =
      database.query(place::make_descriptor(query, {}), 1, [](const place::PlaceId&) { return true; }).at(0);
  const SE3 truth = true_T(places[static_cast<std::size_t>(best.id.submap_id)], query);
  const SE3 apart = best.T_place_query.inverse() * truth;
  return {best.score, apart.t.head<2>().norm() < 2.5 && std::abs(yaw_of(apart)) < 10 * kDeg};
}

Answer ask_scan_context(const std::vector<place::ScanContext>& contexts, const std::vector<Submap>& places,
                        const Submap& query, double near) {
  constexpr std::size_t kShortlist = 10;  // of the paper's experiments
  const place::ScanContext context = place::make_scan_context(query.points, {});
  std::vector<std::pair<float, std::size_t>> ranked;
  for (std::size_t i = 0; i < contexts.size(); ++i) {
    ranked.emplace_back((contexts[i].ring_key - context.ring_key).norm(), i);
  }
  std::sort(ranked.begin(), ranked.end());
  place::ContextMatch best{.distance = 2.0};
  std::size_t found = 0;
  for (std::size_t k = 0; k < std::min(kShortlist, ranked.size()); ++k) {
    const place::ContextMatch match = place::compare(context, contexts[ranked[k].second], {});
    if (match.distance >= best.distance) continue;
    best = match;
    found = ranked[k].second;
  }
  const SE3 truth = true_T(places[found], query);
  const bool right =
      truth.t.norm() < near && std::abs(std::remainder(yaw_of(truth) - best.yaw, 2 * M_PI)) < 10 * kDeg;
  return {-best.distance, right};
}

void BM_Recall(benchmark::State& state, const Revisit& revisit) {
  for (auto _ : state) {
    const Site& site = site_of(revisit.scene);
    const auto& places = first_drive(revisit.scene, site, revisit.old_sensor);
    const auto queries = site.submaps({.sensor = revisit.new_sensor,
                                       .reverse = revisit.reverse,
                                       .offset = revisit.offset,
                                       .from = 2.3,
                                       .duration = revisit.scene.duration,
                                       .step = 1.5,
                                       .seed = 2});
    place::PlaceDatabase database({});
    std::vector<place::ScanContext> contexts;
    for (std::size_t i = 0; i < places.size(); ++i) {
      database.add({0, static_cast<int>(i)}, place::make_descriptor(places[i], {}));
      contexts.push_back(place::make_scan_context(places[i].points, {}));
    }
    std::vector<Answer> ours, baseline;
    for (const Submap& query : queries) {
      const auto is_near = [&](const Submap& place) {
        return true_T(place, query).t.norm() < revisit.offset + 5.0;
      };
      if (std::none_of(places.begin(), places.end(), is_near)) continue;
      ours.push_back(ask_default(database, places, query));
      // A right place of the baseline may be one submap farther along: it gives no shift.
      baseline.push_back(ask_scan_context(contexts, places, query, revisit.offset + 8.0));
    }
    state.counters["places"] = static_cast<double>(places.size());
    state.counters["queries"] = static_cast<double>(ours.size());
    state.counters["recall"] = recall(ours);
    state.counters["scan_context"] = recall(baseline);
  }
}

struct Pair {
  Submap old_submap, new_submap;
};
const Pair& pair() {
  static const Pair made = [] {
    parallel::set_num_threads(1);  // times are those of one thread
    const Site site(sim::SceneKind::kCampus, 1, 3.0);
    return Pair{site.submaps({.sensor = "vlp16", .duration = 6, .seed = 1}).at(0),
                site.submaps({.sensor = "mid360", .from = 0.8, .duration = 6, .seed = 2}).at(0)};
  }();
  return made;
}

void BM_Describe(benchmark::State& state) {
  const Submap& submap = pair().new_submap;
  for (auto _ : state) benchmark::DoNotOptimize(place::make_descriptor(submap, {}));
}

void BM_Query(benchmark::State& state) {
  place::PlaceDatabase database({});
  for (int i = 0; i < state.range(0); ++i)
    database.add({0, i}, place::make_descriptor(pair().old_submap, {}));
  const auto query = place::make_descriptor(pair().new_submap, {});
  for (auto _ : state) {
    benchmark::DoNotOptimize(database.query(query, 5, [](const place::PlaceId&) { return true; }));
  }
}

void BM_CompareScanContexts(benchmark::State& state) {
  const auto a = place::make_scan_context(pair().old_submap.points, {});
  const auto b = place::make_scan_context(pair().new_submap.points, {});
  for (auto _ : state) benchmark::DoNotOptimize(place::compare(b, a, {}));
}

SE3 off_by(const SE3& T, double distance, double yaw_deg) {
  return {T.R * math::so3_exp({0, 0, yaw_deg * kDeg}),
          T.t + math::Vector3d(0.8 * distance, 0.6 * distance, 0.1)};
}

void BM_Prepare(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(registration::prepare(pair().new_submap, {}));
}

void BM_Register(benchmark::State& state) {
  const auto source = registration::prepare(pair().new_submap, {}),
             target = registration::prepare(pair().old_submap, {});
  const SE3 guess = off_by(true_T(pair().old_submap, pair().new_submap), static_cast<double>(state.range(0)),
                           5.0 * static_cast<double>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(registration::register_submaps(source, target, guess, {}));
}

void BM_SearchAround(benchmark::State& state) {
  const SE3 guess = off_by(true_T(pair().old_submap, pair().new_submap), 18.0, 14.0);
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        registration::search_around(pair().new_submap, pair().old_submap, guess, {}, {}));
  }
}

void BM_Verify(benchmark::State& state) {
  const auto source = registration::prepare(pair().new_submap, {}),
             target = registration::prepare(pair().old_submap, {});
  const std::vector<SE3> starts{off_by(true_T(pair().old_submap, pair().new_submap), 1.0, 3.0)};
  for (auto _ : state) {
    benchmark::DoNotOptimize(registration::verify(source, target, starts, std::nullopt, {}));
  }
}

BENCHMARK(BM_Describe)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Query)->Arg(20)->Arg(500)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_CompareScanContexts)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_Prepare)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Register)->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_SearchAround)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_Verify)->Unit(benchmark::kMillisecond);

const bool kRegistered = [] {
  const std::vector<std::pair<std::string, std::string>> sensors{{"vlp16", "vlp16"},
                                                                 {"hdl32e", "hdl32e"},
                                                                 {"os1_64", "os1_64"},
                                                                 {"mid360", "mid360"},
                                                                 {"vlp16", "mid360"}};
  for (const Scene& scene : scenes()) {
    for (const auto& [old_sensor, new_sensor] : sensors) {
      for (const bool reverse : {false, true}) {
        for (const double offset : {0.0, 5.0, 10.0}) {
          const std::string name = fmt::format("Recall/{}/{}/{}/{}/{:.0f}m", scene.name, old_sensor,
                                               new_sensor, reverse ? "opposite" : "same", offset);
          benchmark::RegisterBenchmark(name.c_str(), BM_Recall,
                                       Revisit{scene, old_sensor, new_sensor, reverse, offset})
              ->Iterations(1)
              ->Unit(benchmark::kSecond);
        }
      }
    }
  }
  return true;
}();

}  // namespace
}  // namespace mmlins

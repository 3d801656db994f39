// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "mmlins/math/random.hpp"
#include "mmlins/place/fft.hpp"
#include "mmlins/place/place_database.hpp"
#include "mmlins/place/scan_context.hpp"
#include "tests/place/simulated_submaps.hpp"

namespace mmlins::place {
namespace {

using keyframe::Submap;
using math::SE3;
using math::Vector3d;

constexpr double kDeg = M_PI / 180.0;
const IsEligible kAll = [](const PlaceId&) { return true; };

/// A field of posts and walls at random; every seed is a place of its own.
std::vector<Vector3d> random_place(std::uint64_t seed) {
  math::Random random(seed);
  std::vector<Vector3d> points;
  for (int i = 0; i < 30; ++i) {
    const double x = random.uniform(-35, 35), y = random.uniform(-35, 35), turn = random.uniform(0, M_PI);
    const double length = random.uniform(0.5, 12.0);
    for (double s = 0.0; s < length; s += 0.25) {
      for (double z = 0.0; z < 3.0; z += 0.25)
        points.emplace_back(x + s * std::cos(turn), y + s * std::sin(turn), z);
    }
  }
  return points;
}

Submap seen_from(const std::vector<Vector3d>& points_world, const SE3& T_world_submap) {
  Submap submap;
  submap.T_map_submap = T_world_submap;
  for (const Vector3d& p : points_world)
    submap.points.push_back((T_world_submap.inverse() * p).cast<float>());
  return submap;
}

SE3 level_pose(double x, double y, double yaw_deg) {
  return {math::so3_exp({0, 0, yaw_deg * kDeg}), {x, y, 0.0}};
}

double yaw_of(const SE3& T) { return std::atan2(T.R(1, 0), T.R(0, 0)); }

TEST(SquareFft, IsTheDiscreteFourierTransform) {
  math::Random random(1);
  const int n = 8;
  std::vector<Complex> image(n * n);
  for (Complex& c : image) c = {static_cast<float>(random.uniform()), static_cast<float>(random.uniform())};
  std::vector<Complex> spectrum = image;
  SquareFft(n).forward(spectrum);
  for (int v = 0; v < n; ++v) {
    for (int u = 0; u < n; ++u) {
      std::complex<double> sum = 0.0;
      for (int y = 0; y < n; ++y) {
        for (int x = 0; x < n; ++x) {
          sum += std::complex<double>(image[static_cast<std::size_t>(y * n + x)]) *
                 std::polar(1.0, -2.0 * M_PI * (u * x + v * y) / n);
        }
      }
      // Sums of 64 numbers below 1.5 in single precision.
      EXPECT_LT(std::abs(std::complex<double>(spectrum[static_cast<std::size_t>(v * n + u)]) - sum), 1e-4);
    }
  }
  SquareFft(n).inverse(spectrum);
  for (std::size_t i = 0; i < image.size(); ++i) EXPECT_LT(std::abs(spectrum[i] / 64.0F - image[i]), 1e-5F);
}

TEST(ScanContext, HoldsTheHighestPointOfEachRingAndSector) {
  const ScanContextConfig config{.num_rings = 20, .num_sectors = 60, .max_range = 80.0, .sensor_height = 2.0};
  const std::vector<Eigen::Vector3f> points{
      {10.5F, 0.1F, 1.0F}, {10.6F, 0.2F, 3.0F}, {-0.1F, -50.0F, -1.0F}, {90, 0, 5}};
  const ScanContext context = make_scan_context(points, config);
  EXPECT_FLOAT_EQ(context.heights(2, 0), 5.0F);
  EXPECT_FLOAT_EQ(context.heights(12, 44), 1.0F);  // 269.9 degrees
  EXPECT_EQ((context.heights.array() > 0.0F).count(), 2);
  EXPECT_FLOAT_EQ(context.ring_key(2), 1.0F / 60.0F);
}

TEST(ScanContext, ATurnOnTheSpotChangesNothingButTheYaw) {
  const auto points = random_place(4);
  const ScanContext place = make_scan_context(seen_from(points, {}).points, {});
  // 90 degrees are 15 sectors; the frame of the query is turned to the left.
  const ScanContext query = make_scan_context(seen_from(points, level_pose(0, 0, 90)).points, {});
  const ContextMatch match = compare(query, place, {});
  EXPECT_LT(match.distance, 0.02);  // a few points change sides of a sector by rounding
  EXPECT_NEAR(match.yaw, 90 * kDeg, 1e-9);
  EXPECT_LT((query.ring_key - place.ring_key).norm(), 0.02);
  EXPECT_GT(compare(make_scan_context(seen_from(random_place(5), {}).points, {}), place, {}).distance, 0.3);
}

TEST(PlaceDescriptor, KeyStaysTheSameWhenThePlaceIsSeenFromElsewhere) {
  const auto points = random_place(4);
  const auto here = make_descriptor(seen_from(points, {}), {});
  const auto there = make_descriptor(seen_from(points, level_pose(6, -4, 77)), {});
  const auto other = make_descriptor(seen_from(random_place(5), {}), {});
  // Cells do not fall on the same points twice: nearer than another place by far, but not the same.
  EXPECT_LT((here.key - there.key).norm(), 0.7F * (here.key - other.key).norm());
}

TEST(Compare, FindsTheTruePoseForEveryHeading) {
  const auto points = random_place(4);
  const auto place = make_descriptor(seen_from(points, level_pose(2, 1, 10)), {});
  for (int k = 0; k < 12; ++k) {
    const SE3 T_world_query = level_pose(-5, 4, 31 * k);
    const SE3 truth = level_pose(2, 1, 10).inverse() * T_world_query;
    const Candidate found = compare(make_descriptor(seen_from(points, T_world_query), {}), place, {});
    const SE3 apart = found.T_place_query.inverse() * truth;
    EXPECT_GT(found.score, 0.6);
    EXPECT_LT(apart.t.head<2>().norm(), 1.0) << k;      // a cell
    EXPECT_LT(std::abs(yaw_of(apart)), 2 * kDeg) << k;  // a division of the rose
  }
}

TEST(PlaceDatabase, PutsTheRightPlaceFirstAndKeepsToThoseEligible) {
  PlaceDatabase database({});
  for (int i = 0; i < 40; ++i) {
    const auto seed = static_cast<std::uint64_t>(i);
    database.add({i % 2, i}, make_descriptor(seen_from(random_place(seed), {}), {}));
  }
  const auto query = make_descriptor(seen_from(random_place(17), level_pose(5, 3, 200)), {});
  const auto candidates = database.query(query, 3, kAll);
  ASSERT_EQ(candidates.size(), 3U);
  EXPECT_EQ(candidates[0].id, (PlaceId{1, 17}));
  EXPECT_GT(candidates[0].score, 1.5 * candidates[1].score);
  for (const auto& c : database.query(query, 40, [](const PlaceId& id) { return id.map_id == 0; })) {
    EXPECT_EQ(c.id.map_id, 0);
  }
  database.remove_map(1);
  EXPECT_EQ(database.size(), 20U);
}

TEST(PlaceDatabase, OrderOfInsertionChangesNothing) {
  PlaceDatabase forwards({}), backwards({});
  for (int i = 0; i < 10; ++i) {
    const auto add = [](PlaceDatabase& database, int id) {
      database.add({0, id},
                   make_descriptor(seen_from(random_place(static_cast<std::uint64_t>(id % 5)), {}), {}));
    };
    add(forwards, i);
    add(backwards, 9 - i);
  }
  const auto query = make_descriptor(seen_from(random_place(3), level_pose(1, 2, 30)), {});
  const auto a = forwards.query(query, 10, kAll), b = backwards.query(query, 10, kAll);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].score, b[i].score);
  }
}

TEST(PlaceDescriptor, SurvivesAnEmptySubmap) {
  PlaceDatabase database({});
  const auto nothing = make_descriptor(Submap{}, {});
  database.add({0, 0}, nothing);
  EXPECT_TRUE(nothing.key.allFinite() && nothing.rose.allFinite());
  EXPECT_EQ(database.query(nothing, 1, kAll).at(0).score, 0.0);
}

// Grounds with buildings, driven along again: by another scanner, six metres to the side, the other way.
TEST(PlaceDatabase, KnowsSimulatedGroundsTheOtherWayBesideTheOldTrackByAnotherScanner) {
  const place_test::Site site(sim::SceneKind::kCampus, 1, 4.0);
  const auto old_map = site.submaps({.sensor = "vlp16", .duration = 16, .seed = 1});
  PlaceDatabase database({});
  for (const Submap& submap : old_map) database.add({0, submap.id}, make_descriptor(submap, {}));
  const auto new_map = site.submaps(
      {.sensor = "mid360", .reverse = true, .offset = 6.0, .from = 2, .duration = 12, .seed = 2});
  int asked = 0;
  for (const Submap& query : new_map) {
    const auto near = [&](const Submap& place) { return place_test::true_T(place, query).t.norm() < 10.0; };
    if (std::none_of(old_map.begin(), old_map.end(), near)) continue;
    ++asked;
    const Candidate best = database.query(make_descriptor(query, {}), 1, kAll).at(0);
    const auto place = std::find_if(old_map.begin(), old_map.end(),
                                    [&](const Submap& s) { return s.id == best.id.submap_id; });
    const SE3 apart = best.T_place_query.inverse() * place_test::true_T(*place, query);
    EXPECT_LT(apart.t.head<2>().norm(), 2.0);  // two cells of the image
    EXPECT_LT(std::abs(yaw_of(apart)), 4 * kDeg);
  }
  EXPECT_GE(asked, 2);
}

}  // namespace
}  // namespace mmlins::place

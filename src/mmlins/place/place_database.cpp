// SPDX-License-Identifier: MIT
#include "mmlins/place/place_database.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "mmlins/base/parallel.hpp"
#include "mmlins/place/structure_image.hpp"

namespace mmlins::place {

namespace {

constexpr double kPi = std::numbers::pi;

/// Headings of the query in the frame of the place at which their spectra agree best; half a turn is left
/// open.
std::vector<double> likely_headings(const PlaceDescriptor& query, const PlaceDescriptor& place, int count) {
  const Eigen::Index n = query.rose.cols();
  std::vector<float> agreement(static_cast<std::size_t>(n));
  for (Eigen::Index shift = 0; shift < n; ++shift) {
    // What the query has at angle a the place has at a + shift; half a turn on, magnitudes repeat.
    const Eigen::Index split = n - shift;
    agreement[static_cast<std::size_t>(shift)] =
        query.rose.leftCols(split).cwiseProduct(place.rose.rightCols(split)).sum() +
        query.rose.rightCols(shift).cwiseProduct(place.rose.leftCols(shift)).sum();
  }
  std::vector<std::pair<float, int>> peaks;
  for (int i = 0; i < n; ++i) {
    const auto at = [&](int k) { return agreement[static_cast<std::size_t>((k + n) % n)]; };
    if (at(i) >= at(i - 1) && at(i) > at(i + 1)) peaks.emplace_back(-at(i), i);
  }
  std::sort(peaks.begin(), peaks.end());
  std::vector<double> headings;
  for (std::size_t k = 0; k < std::min(peaks.size(), static_cast<std::size_t>(count)); ++k) {
    const int i = peaks[k].second;
    const auto at = [&](int j) {
      return static_cast<double>(agreement[static_cast<std::size_t>((j + n) % n)]);
    };
    const double curvature = at(i - 1) - 2.0 * at(i) + at(i + 1);
    const double between = curvature < 0.0 ? 0.5 * (at(i - 1) - at(i + 1)) / curvature : 0.0;
    headings.push_back((i + between) * kPi / static_cast<double>(n));
  }
  return headings;
}

struct Peak {
  float value = 0.0F;
  int x = 0, y = 0;  // shift of the query [cells]
};

template <typename Part>
Peak highest(const std::vector<Complex>& correlation, int size, const Part& part) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < correlation.size(); ++i) {
    if (part(correlation[i]) > part(correlation[best])) best = i;
  }
  const int x = static_cast<int>(best) % size, y = static_cast<int>(best) / size;
  return {part(correlation[best]), x >= size / 2 ? x - size : x, y >= size / 2 ? y - size : y};
}

double energy(const std::vector<float>& image) {
  double sum = 0.0;
  for (const float value : image) sum += static_cast<double>(value) * static_cast<double>(value);
  return sum;
}

/// The place as a filter: its image, transformed once for all headings of the query.
struct Filter {
  SquareFft fft;
  std::vector<Complex> spectrum;
  double energy = 0.0;
};

Filter make_filter(const PlaceDescriptor& place, const PlaceConfig& config) {
  const std::vector<float> image = structure_image(place.footprint, 0.0, config);
  Filter filter{SquareFft(config.image_size), to_complex(image, {}), energy(image)};
  filter.fft.forward(filter.spectrum);
  return filter;
}

/// Correlates the query in one heading and its opposite at once: both images are real, and share a transform.
void correlate(const Filter& filter, const PlaceDescriptor& query, double heading, const PlaceConfig& config,
               Candidate& best) {
  const std::vector<float> image = structure_image(query.footprint, heading, config);
  const std::vector<float> opposite = structure_image(query.footprint, heading + kPi, config);
  std::vector<Complex> product = to_complex(image, opposite);
  filter.fft.forward(product);
  // place * conj(query) would conjugate the packing; query * conj(place) keeps it and negates the shift.
  for (std::size_t i = 0; i < product.size(); ++i) product[i] *= std::conj(filter.spectrum[i]);
  filter.fft.inverse(product);
  const int size = config.image_size;
  const auto scale = static_cast<double>(size) * size;
  const auto consider = [&](const Peak& peak, double yaw, double energy_of_query) {
    const double norm = std::sqrt(filter.energy * energy_of_query) * scale;
    const double score = norm > 0.0 ? static_cast<double>(peak.value) / norm : 0.0;
    if (score <= best.score) return;
    best.score = score;
    best.T_place_query.R = math::so3_exp(math::Vector3d(0.0, 0.0, yaw));
    best.T_place_query.t = {-peak.x * config.cell, -peak.y * config.cell, best.T_place_query.t.z()};
  };
  consider(highest(product, size, [](const Complex& c) { return c.real(); }), heading, energy(image));
  consider(highest(product, size, [](const Complex& c) { return c.imag(); }), heading + kPi,
           energy(opposite));
}

}  // namespace

Candidate compare(const PlaceDescriptor& query, const PlaceDescriptor& place, const PlaceConfig& config) {
  Candidate best;
  best.T_place_query.t.z() =
      static_cast<double>(place.footprint.ground) - static_cast<double>(query.footprint.ground);
  const Filter filter = make_filter(place, config);
  for (const double heading : likely_headings(query, place, config.num_headings)) {
    correlate(filter, query, heading, config, best);
  }
  return best;
}

PlaceDatabase::PlaceDatabase(const PlaceConfig& config) : config_(config) {}

void PlaceDatabase::add(const PlaceId& id, PlaceDescriptor descriptor) {
  places_.push_back({id, std::move(descriptor)});
}

void PlaceDatabase::remove_map(int map_id) {
  std::erase_if(places_, [&](const Place& place) { return place.id.map_id == map_id; });
}

std::vector<const PlaceDatabase::Place*> PlaceDatabase::shortlist(const PlaceDescriptor& query,
                                                                  const IsEligible& is_eligible) const {
  std::vector<std::tuple<float, PlaceId, const Place*>> ranked;
  for (const Place& place : places_) {
    if (!is_eligible(place.id)) continue;
    ranked.emplace_back((place.descriptor.key - query.key).squaredNorm(), place.id, &place);
  }
  std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) {
    return std::tie(std::get<0>(a), std::get<1>(a)) < std::tie(std::get<0>(b), std::get<1>(b));
  });
  std::vector<const Place*> nearest;
  const std::size_t count = std::min(ranked.size(), static_cast<std::size_t>(config_.num_compared));
  for (std::size_t i = 0; i < count; ++i) nearest.push_back(std::get<2>(ranked[i]));
  return nearest;
}

std::vector<Candidate> PlaceDatabase::query(const PlaceDescriptor& query, std::size_t max_candidates,
                                            const IsEligible& is_eligible) const {
  const std::vector<const Place*> nearest = shortlist(query, is_eligible);
  std::vector<Candidate> candidates(nearest.size());
  parallel::for_each_chunk(nearest.size(), [&](std::size_t i) {
    candidates[i] = compare(query, nearest[i]->descriptor, config_);
    candidates[i].id = nearest[i]->id;
  });
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score > b.score : a.id < b.id;
  });
  if (candidates.size() > max_candidates) candidates.resize(max_candidates);
  return candidates;
}

}  // namespace mmlins::place

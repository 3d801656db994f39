// SPDX-License-Identifier: MIT
#include "mmlins/report/decimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mmlins/base/check.hpp"

namespace mmlins::report {
namespace {

/// What stays of the samples from `begin` to `end`: smallest, largest, first gap, in order, each once.
std::vector<std::size_t> kept_of(std::span<const double> y, std::size_t begin, std::size_t end) {
  std::size_t smallest = end;
  std::size_t largest = end;
  std::size_t gap = end;
  for (std::size_t i = begin; i < end; ++i) {
    if (std::isnan(y[i])) {
      if (gap == end) gap = i;
      continue;
    }
    if (smallest == end || y[i] < y[smallest]) smallest = i;
    if (largest == end || y[i] > y[largest]) largest = i;
  }
  std::vector<std::size_t> kept{smallest, largest, gap};
  if (begin == 0) kept.push_back(0);
  if (end == y.size()) kept.push_back(end - 1);
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  if (kept.back() == end) kept.pop_back();
  return kept;
}

}  // namespace

Curve decimate(std::span<const double> t, std::span<const double> y, std::size_t max_samples) {
  MMLINS_CHECK(t.size() == y.size() && max_samples >= 3);
  if (y.size() <= max_samples) return {{t.begin(), t.end()}, {y.begin(), y.end()}};
  const std::size_t num_stretches = max_samples / 3;
  Curve curve;
  for (std::size_t k = 0; k < num_stretches; ++k) {
    for (const std::size_t i : kept_of(y, k * y.size() / num_stretches, (k + 1) * y.size() / num_stretches)) {
      curve.t.push_back(t[i]);
      curve.y.push_back(y[i]);
    }
  }
  return curve;
}

Histogram histogram_of(std::vector<double> values, int num_bins) {
  MMLINS_CHECK(num_bins >= 2);
  Histogram histogram;
  if (values.empty()) return histogram;
  std::sort(values.begin(), values.end());
  const double reach = std::max(values[std::min(values.size() - 1, values.size() * 995 / 1000)], 1e-6);
  const double least = reach / num_bins;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    histogram.step = factor * power;
    if (histogram.step > least) break;
  }
  const auto size = static_cast<std::size_t>(std::min<double>(num_bins, std::floor(values.back() / histogram.step) + 1.0));
  histogram.counts.assign(size, 0);
  for (const double value : values) {
    const auto bin = static_cast<std::size_t>(std::max(0.0, value / histogram.step));
    ++histogram.counts[std::min(bin, size - 1)];
  }
  return histogram;
}

}  // namespace mmlins::report

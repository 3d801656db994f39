// SPDX-License-Identifier: MIT
#pragma once
// Curves of an hour, thinned so that what stands out stays.

#include <cstddef>
#include <span>
#include <vector>

namespace mmlins::report {

/// Samples of one quantity over time.
struct Curve {
  std::vector<double> t;  ///< [s]
  std::vector<double> y;  ///< NaN where there is nothing: the line is interrupted
};

/// At most about `max_samples` of the samples: of each stretch the smallest and the largest value stay, at the times at
/// which they were, and so does a gap (NaN). The first and the last sample stay. Fewer samples are returned as they are.
/// @pre t and y have the same length; max_samples >= 3
[[nodiscard]] Curve decimate(std::span<const double> t, std::span<const double> y, std::size_t max_samples);

/// How many values fall between edges of equal steps from 0 on. The last bin holds all that is larger as well.
struct Histogram {
  double step = 1.0;
  std::vector<int> counts;
};

/// A histogram with a round step (1, 2 or 5 times a power of ten) and `num_bins` bins, or fewer if that is enough,
/// that reaches at least to the 99.5 % quantile.
/// @pre num_bins >= 2
[[nodiscard]] Histogram histogram_of(std::vector<double> values, int num_bins);

}  // namespace mmlins::report

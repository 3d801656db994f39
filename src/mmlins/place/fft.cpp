// SPDX-License-Identifier: MIT
#include "mmlins/place/fft.hpp"

#include <bit>
#include <cmath>
#include <numbers>
#include <utility>

#include "mmlins/base/check.hpp"

namespace mmlins::place {

namespace {

void transpose(std::vector<Complex>& image, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) std::swap(image[i * n + j], image[j * n + i]);
  }
}

/// Without the test for infinities that operator* makes.
Complex times(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace

SquareFft::SquareFft(int size) : size_(size) {
  MMLINS_CHECK(size >= 2 && std::has_single_bit(static_cast<unsigned>(size)));
  const int bits = std::countr_zero(static_cast<unsigned>(size));
  for (int k = 0; k < size; ++k) {
    const double angle = -2.0 * std::numbers::pi * k / size;
    twiddles_.emplace_back(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    int reversed = 0;
    for (int b = 0; b < bits; ++b) reversed |= (k >> b & 1) << (bits - 1 - b);
    bit_reversed_.push_back(reversed);
  }
}

void SquareFft::transform_row(Complex* row, bool inverse) const {
  for (int i = 0; i < size_; ++i) {
    const int j = bit_reversed_[static_cast<std::size_t>(i)];
    if (i < j) std::swap(row[i], row[j]);
  }
  for (int half = 1; half < size_; half *= 2) {
    const int stride = size_ / (2 * half);
    for (int k = 0; k < half; ++k) {
      const Complex forward = twiddles_[static_cast<std::size_t>(k * stride)];
      const Complex w = inverse ? std::conj(forward) : forward;
      for (int i = k; i < size_; i += 2 * half) {
        const Complex odd = times(w, row[i + half]);
        row[i + half] = row[i] - odd;
        row[i] += odd;
      }
    }
  }
}

void SquareFft::transform(std::vector<Complex>& image, bool inverse) const {
  const auto n = static_cast<std::size_t>(size_);
  MMLINS_CHECK(image.size() == n * n);
  for (int pass = 0; pass < 2; ++pass) {
    for (std::size_t i = 0; i < n; ++i) transform_row(&image[i * n], inverse);
    transpose(image, n);
  }
}

}  // namespace mmlins::place

// SPDX-License-Identifier: MIT
#pragma once
// Fast Fourier transform of square images whose edge is a power of two.

#include <complex>
#include <vector>

namespace mmlins::place {

using Complex = std::complex<float>;

class SquareFft {
 public:
  /// @param size  edge of the image, a power of two
  explicit SquareFft(int size);

  [[nodiscard]] int size() const { return size_; }
  /// In place, row by row, not scaled: inverse(forward(x)) = size^2 x.
  void forward(std::vector<Complex>& image) const { transform(image, false); }
  void inverse(std::vector<Complex>& image) const { transform(image, true); }

 private:
  void transform(std::vector<Complex>& image, bool inverse) const;
  void transform_row(Complex* row, bool inverse) const;

  int size_;
  std::vector<Complex> twiddles_;  // exp(-2 pi i k / size)
  std::vector<int> bit_reversed_;
};

}  // namespace mmlins::place

// SPDX-License-Identifier: MIT
#include "mmlins/place/place_descriptor.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "mmlins/place/structure_image.hpp"

namespace mmlins::place {

namespace {

constexpr double kGroundRadius = 15.0;  // around the origin [m]
constexpr double kFullAmount = 65535.0;
constexpr double kPi = std::numbers::pi;

float ground_of(const std::vector<keyframe::Column>& columns) {
  std::vector<float> heights;
  for (const keyframe::Column& column : columns) {
    if (column.place.norm() < static_cast<float>(kGroundRadius)) heights.push_back(column.lowest);
  }
  if (heights.empty()) return 0.0F;
  // The floor is what most columns go down to; below shelves and roofs it is not seen.
  const auto low = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 4);
  std::nth_element(heights.begin(), low, heights.end());
  return *low;
}

/// Magnitude of a spectrum between its entries.
float magnitude_at(const std::vector<float>& magnitudes, int size, double u, double v) {
  const double u0 = std::floor(u), v0 = std::floor(v);
  const auto at = [&](int du, int dv) {
    const int i = (static_cast<int>(u0) + du + size) % size, j = (static_cast<int>(v0) + dv + size) % size;
    return static_cast<double>(magnitudes[static_cast<std::size_t>(j * size + i)]);
  };
  const double a = u - u0, b = v - v0;
  return static_cast<float>((1 - a) * ((1 - b) * at(0, 0) + b * at(0, 1)) +
                            a * ((1 - b) * at(1, 0) + b * at(1, 1)));
}

Eigen::MatrixXf rose_of(const Footprint& footprint, const PlaceConfig& config) {
  const std::vector<float> image = structure_image(footprint, 0.0, config);
  std::vector<Complex> spectrum = to_complex(image, {});
  SquareFft(config.image_size).forward(spectrum);
  std::vector<float> magnitudes;
  magnitudes.reserve(spectrum.size());
  for (const Complex& c : spectrum) magnitudes.push_back(std::log1p(std::abs(c)));
  Eigen::MatrixXf rose(config.num_radii, config.num_angles);
  for (int r = 0; r < config.num_radii; ++r) {
    for (int a = 0; a < config.num_angles; ++a) {
      const double angle = kPi * a / config.num_angles;
      rose(r, a) =
          magnitude_at(magnitudes, config.image_size, (r + 2) * std::cos(angle), (r + 2) * std::sin(angle));
    }
  }
  return rose;
}

/// Magnitudes of the first harmonics of each ring of the spectrum.
Eigen::VectorXf key_of(const Eigen::MatrixXf& rose, int num_harmonics) {
  Eigen::VectorXf key(rose.rows() * num_harmonics);
  for (Eigen::Index r = 0; r < rose.rows(); ++r) {
    for (int k = 1; k <= num_harmonics; ++k) {
      std::complex<double> sum = 0.0;
      for (Eigen::Index a = 0; a < rose.cols(); ++a) {
        const double angle = 2.0 * kPi * k * static_cast<double>(a) / static_cast<double>(rose.cols());
        sum += static_cast<double>(rose(r, a)) * std::polar(1.0, angle);
      }
      key(r * num_harmonics + k - 1) = static_cast<float>(std::abs(sum));
    }
  }
  return key;
}

}  // namespace

Fields PlaceConfig::fields() {
  return {
      group("view", view, "the view from above"),
      field("cell", cell, "m", {0.1, 10.0}, "edge of a cell of the image that is transformed"),
      field("image_size", image_size, "", {16.0, 1024.0}, "cells along an edge of the image, a power of two"),
      field("num_radii", num_radii, "", {4.0, 500.0}, "rings of the spectrum"),
      field("num_angles", num_angles, "", {16.0, 720.0}, "divisions of half a turn"),
      field("num_harmonics", num_harmonics, "", {1.0, 90.0}, "of each ring that make the key"),
      field("num_compared", num_compared, "", {1.0, 10000.0},
            "places with the nearest keys that are compared"),
      field("num_headings", num_headings, "", {1.0, 20.0}, "that are tried for each, and their opposites"),
  };
}

Footprint make_footprint(const keyframe::Submap& submap, const PlaceConfig& config) {
  const std::vector<keyframe::Column> columns = keyframe::columns_of(submap, config.view);
  Footprint footprint;
  footprint.ground = ground_of(columns);
  for (const keyframe::Column& column : columns) {
    if (column.structure <= 0.0F) continue;
    footprint.structure.push_back({static_cast<std::int16_t>(std::lround(100.0F * column.place.x())),
                                   static_cast<std::int16_t>(std::lround(100.0F * column.place.y())),
                                   static_cast<std::uint16_t>(std::lround(kFullAmount * column.structure))});
  }
  return footprint;
}

PlaceDescriptor make_descriptor(Footprint footprint, const PlaceConfig& config) {
  PlaceDescriptor descriptor;
  descriptor.rose = rose_of(footprint, config);
  descriptor.rose.colwise() -= descriptor.rose.rowwise().mean().eval();
  const float norm = descriptor.rose.norm();
  if (norm > 0.0F) descriptor.rose /= norm;
  descriptor.key = key_of(descriptor.rose, config.num_harmonics);
  descriptor.key.normalize();
  descriptor.footprint = std::move(footprint);
  return descriptor;
}

PlaceDescriptor make_descriptor(const keyframe::Submap& submap, const PlaceConfig& config) {
  return make_descriptor(make_footprint(submap, config), config);
}

std::vector<float> structure_image(const Footprint& footprint, double yaw, const PlaceConfig& config) {
  const auto size = static_cast<std::size_t>(config.image_size);
  std::vector<float> image(size * size, 0.0F);
  const double cosine = std::cos(yaw) / (100.0 * config.cell), sine = std::sin(yaw) / (100.0 * config.cell);
  const double middle = 0.5 * config.image_size;
  for (const StructurePoint& p : footprint.structure) {
    const double x = middle + cosine * p.x_cm - sine * p.y_cm, y = middle + sine * p.x_cm + cosine * p.y_cm;
    if (x < 0.0 || y < 0.0 || x >= config.image_size - 1.0 || y >= config.image_size - 1.0) continue;
    const double x0 = std::floor(x), y0 = std::floor(y);
    const double a = x - x0, b = y - y0, amount = p.amount / kFullAmount;
    float* corner = &image[static_cast<std::size_t>(y0) * size + static_cast<std::size_t>(x0)];
    corner[0] += static_cast<float>(amount * (1 - a) * (1 - b));
    corner[1] += static_cast<float>(amount * a * (1 - b));
    corner[size] += static_cast<float>(amount * (1 - a) * b);
    corner[size + 1] += static_cast<float>(amount * a * b);
  }
  return image;
}

std::vector<Complex> to_complex(const std::vector<float>& real, const std::vector<float>& imaginary) {
  std::vector<Complex> image(real.size());
  for (std::size_t i = 0; i < real.size(); ++i) image[i] = {real[i], imaginary.empty() ? 0.0F : imaginary[i]};
  return image;
}

}  // namespace mmlins::place

// SPDX-License-Identifier: MIT
#include "mmlins/report/map_picture.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace mmlins::report {
namespace {

constexpr double kFarOff = 0.003;  // share of the points on either side that need not be on the picture
constexpr double kMargin = 0.02;   // of the longer side

/// Values below which the given shares lie.
template <typename T>
std::pair<double, double> quantiles(std::vector<T> values, double low, double high) {
  if (values.empty()) return {0.0, 0.0};
  const auto at = [&](double share) {
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return static_cast<double>(*nth);
  };
  const double first = at(low);
  return {first, at(high)};
}

std::vector<float> axis_of(std::span<const Eigen::Vector3f> points, int axis) {
  std::vector<float> values;
  values.reserve(points.size());
  for (const Eigen::Vector3f& p : points) values.push_back(p(axis));
  return values;
}

Eigen::AlignedBox2d bounds_of(std::span<const Eigen::Vector3f> points, std::span<const Eigen::Vector3d> path) {
  Eigen::AlignedBox2d bounds;
  if (!points.empty()) {
    const auto [min_x, max_x] = quantiles(axis_of(points, 0), kFarOff, 1.0 - kFarOff);
    const auto [min_y, max_y] = quantiles(axis_of(points, 1), kFarOff, 1.0 - kFarOff);
    bounds.extend(Eigen::Vector2d(min_x, min_y));
    bounds.extend(Eigen::Vector2d(max_x, max_y));
  }
  for (const Eigen::Vector3d& p : path) bounds.extend(Eigen::Vector2d(p.head<2>()));
  return bounds;
}

/// What has been drawn so far, per pixel.
struct Canvas {
  int width = 0;
  int height = 0;
  std::vector<float> amount;
  std::vector<float> height_sum;

  void add(int x, int y, float share, float z) {
    if (share <= 0.0F || x < 0 || y < 0 || x >= width || y >= height) return;
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    amount[i] += share;
    height_sum[i] += share * z;
  }
};

// A point is shared among the four pixels around it, so that walls have no steps.
void draw(Canvas& canvas, const MapPicture& frame, std::span<const Eigen::Vector3f> points) {
  for (const Eigen::Vector3f& p : points) {
    const double u = (static_cast<double>(p.x()) - frame.min_x) / frame.metres_per_pixel - 0.5;
    const double v = (frame.max_y - static_cast<double>(p.y())) / frame.metres_per_pixel - 0.5;
    // Also keeps what is far outside, or no number, from overflowing an int.
    if (!(u > -1.0 && v > -1.0 && u < canvas.width && v < canvas.height)) continue;
    const int x = static_cast<int>(std::floor(u));
    const int y = static_cast<int>(std::floor(v));
    const auto du = static_cast<float>(u - x);
    const auto dv = static_cast<float>(v - y);
    canvas.add(x, y, (1.0F - du) * (1.0F - dv), p.z());
    canvas.add(x + 1, y, du * (1.0F - dv), p.z());
    canvas.add(x, y + 1, (1.0F - du) * dv, p.z());
    canvas.add(x + 1, y + 1, du * dv, p.z());
  }
}

std::uint8_t byte_of(double share) { return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(share, 0.0, 1.0))); }

// Logarithmic: a wall must not make the floor invisible.
std::vector<std::uint8_t> to_pixels(const Canvas& canvas, double low, double high) {
  std::vector<float> drawn;
  for (const float amount : canvas.amount) {
    if (amount > 0.05F) drawn.push_back(amount);
  }
  const double full = std::max(quantiles(std::move(drawn), 0.0, 0.98).second, 2.0);
  std::vector<std::uint8_t> pixels;
  pixels.reserve(2 * canvas.amount.size());
  for (std::size_t i = 0; i < canvas.amount.size(); ++i) {
    const double amount = canvas.amount[i];
    const double z = amount > 0.0 ? static_cast<double>(canvas.height_sum[i]) / amount : low;
    const std::uint8_t alpha = byte_of(std::log1p(amount) / std::log1p(full));
    pixels.push_back(alpha == 0 ? 0 : byte_of((z - low) / std::max(high - low, 1e-3)));
    pixels.push_back(alpha);
  }
  return pixels;
}

}  // namespace

MapPicture draw_from_above(std::span<const Eigen::Vector3f> points_map, std::span<const Eigen::Vector3d> path_map,
                           const PictureSize& size) {
  MapPicture picture;
  const Eigen::AlignedBox2d bounds = bounds_of(points_map, path_map);
  if (bounds.isEmpty()) return picture;
  const double longer = std::max(bounds.sizes().maxCoeff(), 1.0);
  const Eigen::Vector2d extent = bounds.sizes() + Eigen::Vector2d::Constant(2.0 * kMargin * longer);
  picture.metres_per_pixel = std::max(extent.maxCoeff() / size.max_pixels, size.min_metres_per_pixel);
  const auto pixels_of = [&](double metres) {
    return std::clamp(static_cast<int>(std::ceil(metres / picture.metres_per_pixel - 1e-9)), 1, size.max_pixels);
  };
  picture.image.width = pixels_of(extent.x());
  picture.image.height = pixels_of(extent.y());
  picture.min_x = bounds.min().x() - kMargin * longer;
  picture.max_y = bounds.max().y() + kMargin * longer;
  std::tie(picture.low, picture.high) = quantiles(axis_of(points_map, 2), 0.02, 0.98);
  const auto num_pixels = static_cast<std::size_t>(picture.image.width) * static_cast<std::size_t>(picture.image.height);
  Canvas canvas{picture.image.width, picture.image.height, std::vector<float>(num_pixels), std::vector<float>(num_pixels)};
  draw(canvas, picture, points_map);
  picture.image.pixels = to_pixels(canvas, picture.low, picture.high);
  return picture;
}

}  // namespace mmlins::report

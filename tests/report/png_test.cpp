// SPDX-License-Identifier: MIT
#include "mmlins/report/png.hpp"

#include <gtest/gtest.h>
#include <png.h>

#include <string_view>

#include "mmlins/report/map_picture.hpp"

namespace mmlins::report {
namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

// The examples of RFC 4648, section 10.
TEST(Base64, IsThatOfTheStandard) {
  EXPECT_EQ(base64({}), "");
  EXPECT_EQ(base64(bytes_of("f")), "Zg==");
  EXPECT_EQ(base64(bytes_of("fo")), "Zm8=");
  EXPECT_EQ(base64(bytes_of("foo")), "Zm9v");
  EXPECT_EQ(base64(bytes_of("foob")), "Zm9vYg==");
  EXPECT_EQ(base64(bytes_of("fooba")), "Zm9vYmE=");
  EXPECT_EQ(base64(bytes_of("foobar")), "Zm9vYmFy");
}

TEST(Base64, KnowsAllBytes) {
  const std::vector<std::uint8_t> bytes{0xFB, 0xFF, 0xBF, 0x00};
  EXPECT_EQ(base64(bytes), "+/+/AA==");
}

GrayAlphaImage decoded(const std::vector<std::uint8_t>& bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  EXPECT_NE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()), 0);
  png.format = PNG_FORMAT_GA;
  GrayAlphaImage image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.pixels.resize(PNG_IMAGE_SIZE(png));
  EXPECT_NE(png_image_finish_read(&png, nullptr, image.pixels.data(), 0, nullptr), 0);
  return image;
}

TEST(Png, DecodesToTheSamePixels) {
  GrayAlphaImage image{37, 11, {}};
  for (int i = 0; i < 2 * 37 * 11; ++i) image.pixels.push_back(static_cast<std::uint8_t>((i * 97 + i / 7) % 256));
  const auto bytes = encode_png(image);
  ASSERT_TRUE(bytes.ok());
  const GrayAlphaImage again = decoded(*bytes);
  EXPECT_EQ(again.width, image.width);
  EXPECT_EQ(again.height, image.height);
  EXPECT_EQ(again.pixels, image.pixels);
  EXPECT_EQ(*bytes, *encode_png(image));
}

TEST(Png, AnImageWithoutPixelsIsAnError) {
  EXPECT_FALSE(encode_png({}).ok());
  EXPECT_FALSE(encode_png({2, 2, {1, 2, 3}}).ok());
}

std::uint8_t opacity_at(const MapPicture& picture, double x, double y) {
  const int column = static_cast<int>((x - picture.min_x) / picture.metres_per_pixel);
  const int row = static_cast<int>((picture.max_y - y) / picture.metres_per_pixel);
  return picture.image.pixels.at(static_cast<std::size_t>(2 * (row * picture.image.width + column) + 1));
}

TEST(MapPicture, PointsAreWhereTheirCoordinatesSay) {
  std::vector<Eigen::Vector3f> points(9, Eigen::Vector3f(30.0F, 10.0F, 1.0F));  // a wall at one spot
  points.emplace_back(0.0F, 0.0F, 0.0F);
  const MapPicture picture = draw_from_above(points, {}, {.min_metres_per_pixel = 0.5});
  EXPECT_EQ(picture.metres_per_pixel, 0.5);
  EXPECT_GT(opacity_at(picture, 30.0, 10.0), 100);
  EXPECT_GT(opacity_at(picture, 30.0, 10.0), opacity_at(picture, 0.0, 0.0));
  EXPECT_GT(opacity_at(picture, 0.0, 0.0), 0);
  EXPECT_EQ(opacity_at(picture, 15.0, 5.0), 0);
  EXPECT_EQ(opacity_at(picture, 0.0, 10.0), 0);  // y is up
}

TEST(MapPicture, HasAllOfThePathAndNoMorePixelsThanAllowed) {
  const std::vector<Eigen::Vector3f> points(100, Eigen::Vector3f::Zero());
  const std::vector<Eigen::Vector3d> path{{-500.0, 20.0, 0.0}, {1500.0, 120.0, 0.0}};
  const MapPicture picture = draw_from_above(points, path, {.max_pixels = 400});
  EXPECT_LE(picture.image.width, 400);
  EXPECT_LE(picture.image.height, 400);
  EXPECT_LE(picture.min_x, -500.0);
  EXPECT_GE(picture.min_x + picture.image.width * picture.metres_per_pixel, 1500.0);
  EXPECT_GE(picture.max_y, 120.0);
  EXPECT_LE(picture.max_y - picture.image.height * picture.metres_per_pixel, 0.0);
}

TEST(MapPicture, AFewPointsFarOffDoNotShrinkTheRest) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 10000; ++i) points.emplace_back(static_cast<float>(i % 100), static_cast<float>(i) / 100.0F, 0.0F);
  points.emplace_back(1e7F, 1e7F, 0.0F);
  const MapPicture picture = draw_from_above(points, {}, {});
  EXPECT_LT(picture.image.width * picture.metres_per_pixel, 120.0);
}

TEST(MapPicture, OfNothingIsEmpty) { EXPECT_EQ(draw_from_above({}, {}, {}).image.width, 0); }

}  // namespace
}  // namespace mmlins::report

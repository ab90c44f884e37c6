// SPDX-License-Identifier: Apache-2.0
#include "perception/image/decode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <string>

#include "core/grid/files/png_codec.h"
#include "perception/image/image_header.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/perception/image/scenes.h"

namespace enfilade::perception {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string Encode(const cv::Mat& image, const std::string& extension) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

// OpenCV keeps colours as B, G, R.
cv::Mat OneColor(int red, int green, int blue) { return {48, 64, CV_8UC3, cv::Scalar(blue, green, red)}; }

// 0.299 R + 0.587 G + 0.114 B.
TEST(DecodeTest, WeighsColorsByRec601InEveryFormat) {
  const cv::Mat red = OneColor(255, 0, 0);
  const cv::Mat blue = OneColor(0, 0, 255);
  for (const std::string extension : {".png", ".jpg"}) {
    ASSERT_OK_AND_ASSIGN(const GreyFrame of_red, DecodeGrey(Encode(red, extension)));
    ASSERT_OK_AND_ASSIGN(const GreyFrame of_blue, DecodeGrey(Encode(blue, extension)));
    EXPECT_EQ(of_red.width, 64);
    EXPECT_EQ(of_red.height, 48);
    EXPECT_NEAR(of_red.pixels[100], 76, 1) << extension;
    EXPECT_NEAR(of_blue.pixels[100], 29, 1) << extension;
  }
}

// `image` as OpenCV's own decoder has it.
cv::Mat ByOpenCv(const std::string& encoded, int flags) {
  const cv::Mat bytes(1, static_cast<int>(encoded.size()), CV_8U, const_cast<char*>(encoded.data()));
  cv::Mat image = cv::imdecode(bytes, flags);
  if (image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2RGB);
  return image;
}

// A place of 61 x 47 pixels: no multiple of JPEG's blocks.
cv::Mat ColorPlace() {
  cv::Mat image, grey = testing::Place(3, {61, 47});
  cv::applyColorMap(grey, image, cv::COLORMAP_JET);
  return image;
}

std::string WithOrientation(std::string jpeg, char orientation) {
  std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0\x2A\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x00\0\0\0\0\0\0",
      36);
  exif[29] = orientation;
  return jpeg.insert(2, exif);
}

void ExpectAsByOpenCv(const std::string& encoded) {
  ASSERT_OK_AND_ASSIGN(const GreyFrame grey, DecodeGrey(encoded));
  const cv::Mat grey_expected = ByOpenCv(encoded, cv::IMREAD_GRAYSCALE);
  EXPECT_EQ(cv::Size(grey.width, grey.height), grey_expected.size());
  EXPECT_TRUE(std::equal(grey.pixels.begin(), grey.pixels.end(), grey_expected.begin<std::uint8_t>()));
  ASSERT_OK_AND_ASSIGN(const ColorFrame color, DecodeColor(encoded));
  const cv::Mat color_expected = ByOpenCv(encoded, cv::IMREAD_COLOR);
  EXPECT_EQ(cv::Size(color.width, color.height), color_expected.size());
  EXPECT_TRUE(std::equal(color.samples.begin(), color.samples.end(), color_expected.ptr()));
}

TEST(DecodeTest, ReadsJpegsAsOpenCvDoes) {
  for (const cv::Mat& image : {ColorPlace(), testing::Place(4, {61, 47})}) {
    for (const int progressive : {0, 1}) {
      std::vector<std::uint8_t> bytes;
      cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_PROGRESSIVE, progressive, cv::IMWRITE_JPEG_QUALITY, 80});
      ExpectAsByOpenCv({bytes.begin(), bytes.end()});
    }
  }
}

TEST(DecodeTest, TurnsJpegsAsTheySay) {
  const std::string upright = Encode(ColorPlace(), ".jpg");
  for (char orientation = 0; orientation <= 9; ++orientation) {  // 0 and 9 mean nothing
    SCOPED_TRACE(static_cast<int>(orientation));
    ExpectAsByOpenCv(WithOrientation(upright, orientation));
  }
}

// A camera that writes bytes between the blocks of its image makes a JPEG that can be read.
TEST(DecodeTest, ReadsJpegsWithStrayBytes) {
  std::string jpeg = Encode(ColorPlace(), ".jpg");
  jpeg.insert(jpeg.size() - 2, std::string(5, '\0'));
  ExpectAsByOpenCv(jpeg);
}

TEST(DecodeTest, ScalesSixteenBitsToEight) {
  const cv::Mat deep = (cv::Mat_<std::uint16_t>(1, 4) << 0, 128, 129, 65535);
  ASSERT_OK_AND_ASSIGN(const GreyFrame frame, DecodeGrey(Encode(deep, ".png")));
  EXPECT_THAT(frame.pixels, ::testing::ElementsAre(0, 0, 1, 255));
}

TEST(DecodeTest, DecodesColorsAsRgb) {
  ASSERT_OK_AND_ASSIGN(const ColorFrame frame, DecodeColor(Encode(OneColor(200, 100, 50), ".png")));
  EXPECT_THAT(std::vector<int>(frame.samples.begin(), frame.samples.begin() + 3), ::testing::ElementsAre(200, 100, 50));
}

TEST(DecodeTest, RefusesFiftyMegapixelsBeforeDecodingThem) {
  grid::PixelImage huge{
      .width = 10000, .height = 5000, .channels = 1, .samples = std::vector<std::uint8_t>(50'000'000)};
  ASSERT_OK_AND_ASSIGN(const std::string png, grid::EncodePng(huge));
  EXPECT_STATUS(DecodeGrey(png), absl::StatusCode::kInvalidArgument,
                AllOf(HasSubstr("10000x5000"), HasSubstr("50.0 Mpx"), HasSubstr("25.0 Mpx")));
  ASSERT_OK_AND_ASSIGN(const GreyFrame frame, DecodeGrey(png, {.max_pixels = 50'000'000}));
  EXPECT_EQ(frame.width, 10000);
}

TEST(DecodeTest, RefusesCmyk) {
  std::string jpeg = Encode(OneColor(1, 2, 3), ".jpg");
  const std::size_t frame_header = jpeg.find("\xFF\xC0");
  ASSERT_NE(frame_header, std::string::npos);
  jpeg[frame_header + 9] = 4;  // components
  EXPECT_STATUS(DecodeGrey(jpeg), absl::StatusCode::kInvalidArgument, HasSubstr("CMYK"));
}

TEST(DecodeTest, RefusesDamagedImages) {
  const cv::Mat image = testing::Place(1);
  for (const std::string extension : {".png", ".jpg"}) {
    const std::string bytes = Encode(image, extension);
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{10}, std::size_t{40}, bytes.size() / 2}) {
      EXPECT_CODE(DecodeGrey(std::string_view(bytes).substr(0, size)), absl::StatusCode::kInvalidArgument)
          << extension << " of " << size << " bytes";
    }
  }
  EXPECT_STATUS(DecodeGrey("GIF89a and so on"), absl::StatusCode::kInvalidArgument, HasSubstr("neither PNG nor JPEG"));
}

// No changed byte may crash or hang the decoder.
TEST(DecodeTest, SurvivesEveryFlippedHeaderByte) {
  for (const std::string extension : {".png", ".jpg"}) {
    const std::string bytes = Encode(testing::Place(2, {40, 40}), extension);
    for (std::size_t i = 0; i < std::min<std::size_t>(bytes.size(), 400); ++i) {
      for (const int flip : {0x01, 0x80, 0xFF}) {
        std::string damaged = bytes;
        damaged[i] = static_cast<char>(damaged[i] ^ flip);
        const auto frame = DecodeGrey(damaged);
        if (frame.ok()) {
          EXPECT_OK(Validate(*frame));
        }
      }
    }
  }
}

TEST(DecodeTest, ReadsDepthInMetres) {
  cv::Mat depth(2, 3, CV_16U, cv::Scalar(1500));
  depth.at<std::uint16_t>(0, 1) = 0;
  ASSERT_OK_AND_ASSIGN(const DepthFrame frame, DecodeDepth(Encode(depth, ".png")));
  EXPECT_THAT(frame.metres, ::testing::Pointwise(::testing::FloatEq(), {1.5F, 0.0F, 1.5F, 1.5F, 1.5F, 1.5F}));
  EXPECT_STATUS(DecodeDepth(Encode(testing::Place(1), ".png")), absl::StatusCode::kInvalidArgument,
                HasSubstr("16-bit"));
}

TEST(ImageHeaderTest, ReadsSizeAndChannels) {
  const cv::Mat color = OneColor(1, 2, 3);
  ASSERT_OK_AND_ASSIGN(const ImageHeader png, ReadImageHeader(Encode(color, ".png")));
  EXPECT_EQ(png.format, ImageFormat::kPng);
  EXPECT_EQ(png.width, 64);
  EXPECT_EQ(png.components, 3);
  ASSERT_OK_AND_ASSIGN(const ImageHeader jpeg, ReadImageHeader(Encode(color, ".jpg")));
  EXPECT_EQ(jpeg.format, ImageFormat::kJpeg);
  EXPECT_EQ(jpeg.height, 48);
  EXPECT_EQ(jpeg.bit_depth, 8);
}

}  // namespace
}  // namespace enfilade::perception

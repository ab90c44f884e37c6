// SPDX-License-Identifier: Apache-2.0
// Images of a robot's cameras: PNG, JPEG and depth.
#include "opencv2/imgcodecs.hpp"
#include "perception/image/decode.h"
#include "perception/image/image_header.h"
#include "tests/fuzz/decoder.h"
#include "tests/fuzz/png_repair.h"

namespace enfilade::fuzz {
namespace {

constexpr perception::DecodeLimits kLimits{.max_pixels = 1'000'000};

bool DecodeOne(std::string_view bytes) {
  const auto header = perception::ReadImageHeader(bytes);
  const auto grey = perception::DecodeGrey(bytes, kLimits);
  if (grey.ok()) {
    Expect(header.ok(), "an image that is decoded has a header");
    Expect(perception::Validate(*grey).ok(), "as many pixels as the size says");
    Expect(header->width * header->height == std::int64_t{grey->width} * grey->height, "the size of the header");
  }
  const auto color = perception::DecodeColor(bytes, kLimits);
  if (color.ok()) Expect(perception::Validate(*color).ok(), "as many samples as the size says");
  const auto depth = perception::DecodeDepth(bytes, 0.001, kLimits);
  if (depth.ok()) Expect(perception::Validate(*depth).ok(), "as many depths as the size says");
  return grey.ok() || depth.ok();
}

std::string EncodeBy(const std::string& extension, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(extension, image, bytes);
  return {bytes.begin(), bytes.end()};
}

}  // namespace

std::vector<std::string> Seeds() {
  cv::Mat grey(12, 16, CV_8U);
  for (int i = 0; i < 192; ++i) grey.data[i] = static_cast<std::uint8_t>(i * 5);
  const cv::Mat color(8, 8, CV_8UC3, cv::Scalar(10, 100, 200));
  const cv::Mat depth(8, 8, CV_16U, cv::Scalar(1500));
  return {EncodeBy(".png", grey), EncodeBy(".png", color), EncodeBy(".png", depth), EncodeBy(".jpg", grey),
          EncodeBy(".jpg", color)};
}

bool Decode(std::string_view bytes) {
  if (!bytes.empty() && bytes.front() == '\x89') (void)DecodeOne(WithValidChecksums(bytes));
  return DecodeOne(bytes);
}

}  // namespace enfilade::fuzz

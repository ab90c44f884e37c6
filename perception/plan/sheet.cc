// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/pgm_codec.h"
#include "core/grid/files/png_codec.h"
#include "perception/image/image_header.h"
#include "perception/image/jpeg.h"
#include "perception/image/opencv_guard.h"
#include "perception/plan/opencv_sheet.h"

namespace enfilade::perception {
namespace {

// RGB over white. A drawing that would vanish there, white ink that only the transparency shows, lies over black.
cv::Mat OverBackground(const cv::Mat& rgba) {
  std::vector<cv::Mat> channels;
  cv::split(rgba, channels);
  const cv::Mat alpha = channels[3];
  const auto over = [&](double background) {
    std::vector<cv::Mat> mixed;
    for (int i = 0; i < 3; ++i) {
      cv::Mat front, back;
      cv::multiply(channels[i], alpha, front, 1.0 / 255, CV_32F);
      cv::subtract(cv::Scalar(255), alpha, back);
      back.convertTo(back, CV_32F, background / 255);
      cv::Mat sum = front + back;
      sum.convertTo(sum, CV_8U);
      mixed.push_back(sum);
    }
    cv::Mat merged;
    cv::merge(mixed, merged);
    return merged;
  };
  cv::Mat white = over(255);
  double least = 0, most = 0;
  cv::minMaxLoc(white.reshape(1), &least, &most);
  return most - least < 16 ? over(0) : white;
}

Sheet SheetFrom(const cv::Mat& decoded) {
  cv::Mat image = decoded;
  if (image.channels() == 2) {
    std::vector<cv::Mat> c;
    cv::split(image, c);
    cv::merge(std::vector<cv::Mat>{c[0], c[0], c[0], c[1]}, image);
  }
  if (image.channels() == 4) image = OverBackground(image);
  if (image.channels() == 1) return {image.clone(), {}};
  Sheet sheet;
  cv::cvtColor(image, sheet.brightness, cv::COLOR_RGB2GRAY);
  std::vector<cv::Mat> c;
  cv::split(image, c);
  sheet.colour = cv::max(c[0], cv::max(c[1], c[2])) - cv::min(c[0], cv::min(c[1], c[2]));
  return sheet;
}

absl::Status CheckSheetSize(std::int64_t width, std::int64_t height) {
  if (width > 0 && height > 0 && width <= kMaxSheetPixels && height <= kMaxSheetPixels / width) return absl::OkStatus();
  return InvalidArgument("the picture has {}x{} pixels, more than the limit of {} Mpx: scale it down", width, height,
                         kMaxSheetPixels / 1'000'000);
}

absl::StatusOr<Sheet> DecodePgmSheet(std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(const grid::PgmImage pgm, grid::DecodePgm(bytes));
  ENFILADE_RETURN_IF_ERROR(CheckSheetSize(pgm.width, pgm.height));
  const cv::Mat rows(pgm.height, pgm.width, CV_8U, const_cast<std::uint8_t*>(pgm.pixels.data()));
  cv::Mat upright;
  cv::flip(rows, upright, 0);
  upright.convertTo(upright, CV_8U, 255.0 / pgm.max_value);
  return Sheet{upright, {}};
}

absl::StatusOr<grid::PixelImage> DecodePixels(std::string_view bytes, const ImageHeader& header) {
  if (header.format == ImageFormat::kPng) return grid::DecodePng(bytes, grid::SixteenBits::kScaled);
  return DecodeJpeg(bytes, header.components == 1 ? JpegColors::kGrey : JpegColors::kRgb);
}

}  // namespace

cv::Mat ShrunkTo(const cv::Mat& image, double diagonal) {
  const double scale = diagonal / std::hypot(image.cols, image.rows);
  if (scale >= 1) return image;
  cv::Mat small;
  cv::resize(image, small, {}, scale, scale, cv::INTER_AREA);
  return small;
}

absl::StatusOr<Sheet> DecodeSheet(std::string_view bytes) {
  return GuardOpenCv("decoding a plan", [&]() -> absl::StatusOr<Sheet> {
    if (bytes.substr(0, 2) == "P5" || bytes.substr(0, 2) == "P2") return DecodePgmSheet(bytes);
    ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, ReadImageHeader(bytes));
    ENFILADE_RETURN_IF_ERROR(CheckSheetSize(header.width, header.height));
    ENFILADE_ASSIGN_OR_RETURN(const grid::PixelImage image, DecodePixels(bytes, header));
    return SheetFrom(
        cv::Mat(image.height, image.width, CV_8UC(image.channels), const_cast<std::uint8_t*>(image.samples.data())));
  });
}

}  // namespace enfilade::perception

// SPDX-License-Identifier: Apache-2.0
#include "perception/image/decode.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/sensor/record.h"
#include "perception/image/image_header.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

absl::Status CheckSize(std::int64_t width, std::int64_t height, const DecodeLimits& limits) {
  if (width <= 0 || height <= 0)
    return InvalidArgument("the image has {}x{} pixels: expected at least one", width, height);
  if (width > limits.max_pixels || height > limits.max_pixels / width) {
    return InvalidArgument("the image has {}x{} pixels ({:.1f} Mpx), more than the limit of {:.1f} Mpx: scale it down",
                           width, height, static_cast<double>(width) * static_cast<double>(height) * 1e-6,
                           static_cast<double>(limits.max_pixels) * 1e-6);
  }
  return absl::OkStatus();
}

absl::StatusOr<cv::Mat> Decode(std::string_view bytes, int flags, const ImageHeader& header) {
  // OpenCV's decoder does not write to its input, although its interface takes a mutable pointer.
  const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  cv::Mat image = cv::imdecode(encoded, flags);
  const char* name = header.format == ImageFormat::kPng ? "PNG" : "JPEG";
  if (image.empty()) return InvalidArgument("the {} is damaged or truncated ({} bytes)", name, bytes.size());
  if (header.format == ImageFormat::kJpeg && bytes.rfind("\xFF\xD9") == std::string_view::npos) {
    // OpenCV silently fills missing pixels with grey.
    return InvalidArgument("the JPEG is truncated ({} bytes, no end marker)", bytes.size());
  }
  return image;
}

absl::StatusOr<ImageHeader> CheckHeader(std::string_view bytes, const DecodeLimits& limits) {
  if (static_cast<std::int64_t>(bytes.size()) > sensor::kMaxBlobBytes) {
    return InvalidArgument("the image has {} bytes, more than the limit of {}", bytes.size(), sensor::kMaxBlobBytes);
  }
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, ReadImageHeader(bytes));
  ENFILADE_RETURN_IF_ERROR(CheckSize(header.width, header.height, limits));
  if (header.format == ImageFormat::kJpeg && header.components != 1 && header.components != 3) {
    return InvalidArgument("the JPEG has {} colour components ({}): send grey or RGB (YCbCr) images", header.components,
                           header.components == 4 ? "CMYK" : "unknown");
  }
  return header;
}

// Whether core's PNG reader applies: it reports errors that OpenCV only prints to standard error, but reads no 16-bit
// PNG.
bool IsPlainPng(const ImageHeader& header) { return header.format == ImageFormat::kPng && header.bit_depth <= 8; }

std::uint8_t Luma(int red, int green, int blue) {
  return static_cast<std::uint8_t>((299 * red + 587 * green + 114 * blue + 500) / 1000);
}

GreyFrame GreyFrom(const grid::PixelImage& image) {
  GreyFrame grey{image.width, image.height, {}};
  const auto channels = static_cast<std::size_t>(image.channels);
  grey.pixels.resize(image.samples.size() / channels);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
    const std::uint8_t* sample = &image.samples[i * channels];
    grey.pixels[i] = channels < 3 ? sample[0] : Luma(sample[0], sample[1], sample[2]);
  }
  return grey;
}

ColorFrame ColorFrom(const grid::PixelImage& image) {
  ColorFrame color{image.width, image.height, {}};
  const auto channels = static_cast<std::size_t>(image.channels);
  color.samples.reserve(image.samples.size() / channels * 3);
  for (std::size_t i = 0; i < image.samples.size(); i += channels) {
    for (std::size_t k = 0; k < 3; ++k) color.samples.push_back(image.samples[i + (channels < 3 ? 0 : k)]);
  }
  return color;
}

template <typename Sample>
std::vector<Sample> Samples(const cv::Mat& image) {
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  const auto* first = whole.ptr<Sample>();
  return std::vector<Sample>(first, first + whole.total() * static_cast<std::size_t>(whole.channels()));
}

}  // namespace

absl::StatusOr<GreyFrame> DecodeGrey(std::string_view bytes, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, CheckHeader(bytes, limits));
  if (IsPlainPng(header)) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::PixelImage image, grid::DecodePng(bytes));
    return GreyFrom(image);
  }
  return GuardOpenCv("decoding an image", [&]() -> absl::StatusOr<GreyFrame> {
    ENFILADE_ASSIGN_OR_RETURN(const cv::Mat image, Decode(bytes, cv::IMREAD_GRAYSCALE, header));
    return GreyFrame{image.cols, image.rows, Samples<std::uint8_t>(image)};
  });
}

absl::StatusOr<ColorFrame> DecodeColor(std::string_view bytes, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, CheckHeader(bytes, limits));
  if (IsPlainPng(header)) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::PixelImage image, grid::DecodePng(bytes));
    return ColorFrom(image);
  }
  return GuardOpenCv("decoding an image", [&]() -> absl::StatusOr<ColorFrame> {
    ENFILADE_ASSIGN_OR_RETURN(const cv::Mat bgr, Decode(bytes, cv::IMREAD_COLOR, header));
    cv::Mat rgb;
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    return ColorFrame{rgb.cols, rgb.rows, Samples<std::uint8_t>(rgb)};
  });
}

absl::StatusOr<DepthFrame> DecodeDepth(std::string_view bytes, double metres_per_unit, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, CheckHeader(bytes, limits));
  if (header.format != ImageFormat::kPng || header.components != 1 || header.bit_depth != 16) {
    return InvalidArgument("a depth image is a PNG of one 16-bit channel: this is a {} of {} channels of {} bits",
                           header.format == ImageFormat::kPng ? "PNG" : "JPEG", header.components, header.bit_depth);
  }
  return GuardOpenCv("decoding a depth image", [&]() -> absl::StatusOr<DepthFrame> {
    ENFILADE_ASSIGN_OR_RETURN(const cv::Mat image, Decode(bytes, cv::IMREAD_UNCHANGED, header));
    cv::Mat metres;
    image.convertTo(metres, CV_32F, metres_per_unit);
    return DepthFrame{metres.cols, metres.rows, Samples<float>(metres)};
  });
}

}  // namespace enfilade::perception

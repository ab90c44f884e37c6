// SPDX-License-Identifier: Apache-2.0
#include "perception/image/decode.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/files/png_codec.h"
#include "core/sensor/record.h"
#include "perception/image/image_header.h"
#include "perception/image/jpeg.h"

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

// With one channel or more, alpha last.
absl::StatusOr<grid::PixelImage> DecodePixels(std::string_view bytes, JpegColors colors, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, CheckHeader(bytes, limits));
  if (header.format == ImageFormat::kPng) return grid::DecodePng(bytes, grid::SixteenBits::kScaled);
  return DecodeJpeg(bytes, colors);
}

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

}  // namespace

absl::StatusOr<GreyFrame> DecodeGrey(std::string_view bytes, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(grid::PixelImage image, DecodePixels(bytes, JpegColors::kGrey, limits));
  if (image.channels == 1) return GreyFrame{image.width, image.height, std::move(image.samples)};
  return GreyFrom(image);
}

absl::StatusOr<ColorFrame> DecodeColor(std::string_view bytes, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(grid::PixelImage image, DecodePixels(bytes, JpegColors::kRgb, limits));
  if (image.channels == 3) return ColorFrame{image.width, image.height, std::move(image.samples)};
  return ColorFrom(image);
}

absl::StatusOr<DepthFrame> DecodeDepth(std::string_view bytes, double metres_per_unit, const DecodeLimits& limits) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, CheckHeader(bytes, limits));
  if (header.format != ImageFormat::kPng || header.components != 1 || header.bit_depth != 16) {
    return InvalidArgument("a depth image is a PNG of one 16-bit channel: this is a {} of {} channels of {} bits",
                           header.format == ImageFormat::kPng ? "PNG" : "JPEG", header.components, header.bit_depth);
  }
  ENFILADE_ASSIGN_OR_RETURN(const grid::PixelImage image, grid::DecodePng(bytes, grid::SixteenBits::kKept));
  DepthFrame depth{image.width, image.height, {}};
  const std::size_t sample_bytes = 2 * static_cast<std::size_t>(image.channels);  // a second channel is transparency
  depth.metres.reserve(image.samples.size() / sample_bytes);
  for (std::size_t i = 0; i < image.samples.size(); i += sample_bytes) {
    const int units = 256 * image.samples[i] + image.samples[i + 1];
    depth.metres.push_back(static_cast<float>(units * metres_per_unit));
  }
  return depth;
}

}  // namespace enfilade::perception

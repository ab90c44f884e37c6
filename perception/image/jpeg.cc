// SPDX-License-Identifier: Apache-2.0
#include "perception/image/jpeg.h"

#include <libexif/exif-data.h>
#include <turbojpeg.h>

#include <memory>
#include <optional>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/image/image_header.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

constexpr int kUpright = 1;

const unsigned char* Bytes(std::string_view text) { return reinterpret_cast<const unsigned char*>(text.data()); }

// 1 to 8; kUpright where the file says nothing.
int OrientationOf(std::string_view jpeg) {
  const std::unique_ptr<ExifData, decltype(&exif_data_unref)> exif(
      exif_data_new_from_data(Bytes(jpeg), static_cast<unsigned>(jpeg.size())), &exif_data_unref);
  if (!exif) return kUpright;
  const ExifEntry* entry = exif_content_get_entry(exif->ifd[EXIF_IFD_0], EXIF_TAG_ORIENTATION);
  if (entry == nullptr || entry->format != EXIF_FORMAT_SHORT || entry->size < 2) return kUpright;
  const int orientation = exif_get_short(entry->data, exif_data_get_byte_order(exif.get()));
  return orientation >= 1 && orientation <= 8 ? orientation : kUpright;
}

// The values 5 to 8 are 1 to 4 of the image mirrored at its diagonal.
cv::Mat Turned(const cv::Mat& image, int orientation) {
  cv::Mat turned = image;
  const bool transposed = orientation > 4;
  if (transposed) cv::transpose(image, turned);
  const auto flip = [&]() -> std::optional<int> {
    switch (orientation) {
      case 2:
      case 6:
        return 1;  // left to right
      case 3:
      case 7:
        return -1;  // both
      case 4:
      case 8:
        return 0;  // top to bottom
      default:
        return std::nullopt;
    }
  }();
  if (flip) cv::flip(turned, turned, *flip);
  return turned;
}

// `jpeg`'s own size is at most `image`'s.
absl::Status Decompress(std::string_view jpeg, cv::Mat& image, TJPF format) {
  const std::unique_ptr<void, decltype(&tjDestroy)> decoder(tjInitDecompress(), &tjDestroy);
  if (!decoder) return ResourceExhausted("no memory to read a JPEG");
  // Without a limit of scans a small progressive file takes minutes.
  const int result = tjDecompress2(decoder.get(), Bytes(jpeg), jpeg.size(), image.data, image.cols,
                                   static_cast<int>(image.step[0]), image.rows, format, TJFLAG_LIMITSCANS);
  // A warning tells of bytes that were skipped, as cameras write them.
  if (result != 0 && tjGetErrorCode(decoder.get()) != TJERR_WARNING) {
    return InvalidArgument("the JPEG is damaged or truncated ({} bytes): {}", jpeg.size(),
                           tjGetErrorStr2(decoder.get()));
  }
  // Missing pixels are only a warning, too.
  if (jpeg.rfind("\xFF\xD9") == std::string_view::npos) {
    return InvalidArgument("the JPEG is truncated ({} bytes, no end marker)", jpeg.size());
  }
  return absl::OkStatus();
}

cv::Mat RgbFromInvertedCmyk(const cv::Mat& cmyk) {
  cv::Mat rgb(cmyk.size(), CV_8UC3);
  for (int row = 0; row < cmyk.rows; ++row) {
    for (int column = 0; column < cmyk.cols; ++column) {
      const auto& ink = cmyk.at<cv::Vec4b>(row, column);
      for (int i = 0; i < 3; ++i) rgb.at<cv::Vec3b>(row, column)[i] = static_cast<std::uint8_t>(ink[i] * ink[3] / 255);
    }
  }
  return rgb;
}

absl::StatusOr<cv::Mat> Decode(std::string_view bytes, const ImageHeader& header, JpegColors colors) {
  const bool cmyk = header.components == 4;
  if (cmyk && colors == JpegColors::kGrey) return InvalidArgument("the JPEG is CMYK: expected grey or RGB");
  const cv::Size size(static_cast<int>(header.width), static_cast<int>(header.height));
  cv::Mat image(size, cmyk ? CV_8UC4 : colors == JpegColors::kGrey ? CV_8U : CV_8UC3);
  ENFILADE_RETURN_IF_ERROR(Decompress(bytes, image,
                                      cmyk                          ? TJPF_CMYK
                                      : colors == JpegColors::kGrey ? TJPF_GRAY
                                                                    : TJPF_RGB));
  if (cmyk) image = RgbFromInvertedCmyk(image);
  return Turned(image, OrientationOf(bytes));
}

}  // namespace

absl::StatusOr<grid::PixelImage> DecodeJpeg(std::string_view bytes, JpegColors colors) {
  ENFILADE_ASSIGN_OR_RETURN(const ImageHeader header, ReadImageHeader(bytes));
  if (header.format != ImageFormat::kJpeg) return InvalidArgument("not a JPEG");
  return GuardOpenCv("decoding a JPEG", [&]() -> absl::StatusOr<grid::PixelImage> {
    ENFILADE_ASSIGN_OR_RETURN(const cv::Mat image, Decode(bytes, header, colors));
    const auto size = static_cast<std::ptrdiff_t>(image.total()) * image.channels();
    return grid::PixelImage{image.cols, image.rows, image.channels(), {image.data, image.data + size}};
  });
}

}  // namespace enfilade::perception

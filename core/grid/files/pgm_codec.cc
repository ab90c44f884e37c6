// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/pgm_codec.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/ascii.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/grid/map_raster.h"

namespace enfilade::grid {
namespace {

constexpr std::size_t kMaxMetadataBytes = std::size_t{64} * 1024;

bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

struct Header {
  bool is_plain = false;
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::int64_t max_value = 0;
  std::size_t size = 0;  // bytes up to the first pixel
};

class Scanner {
 public:
  explicit Scanner(std::string_view bytes) : bytes_(bytes) {}

  std::size_t position() const { return position_; }
  void Skip(std::size_t count) { position_ += count; }

  // The next number, after white space and comments. `what` names it in the error.
  absl::StatusOr<std::int64_t> Number(std::string_view what) {
    SkipSpaceAndComments();
    if (position_ == bytes_.size()) return InvalidArgument("the PGM file ends before its {}", what);
    std::int64_t value = 0;
    const std::size_t begin = position_;
    while (position_ < bytes_.size() && absl::ascii_isdigit(bytes_[position_]) && position_ - begin < 10) {
      value = value * 10 + (bytes_[position_++] - '0');
    }
    if (position_ == begin || (position_ < bytes_.size() && absl::ascii_isdigit(bytes_[position_]))) {
      return InvalidArgument("the PGM file's {} is not a number of up to 10 digits (byte {})", what, begin);
    }
    return value;
  }

  // The single white space (or comment) between header and pixels.
  absl::Status Separator() {
    if (position_ == bytes_.size()) return InvalidArgument("the PGM file ends after its header");
    if (bytes_[position_] == '#') {
      SkipComment();
    } else if (!IsSpace(bytes_[position_++])) {
      return InvalidArgument("the PGM file has no white space after its largest grey (byte {})", position_ - 1);
    }
    return absl::OkStatus();
  }

 private:
  void SkipComment() {
    const std::size_t end = bytes_.find_first_of("\r\n", position_);
    position_ = end == std::string_view::npos ? bytes_.size() : end + 1;
  }
  void SkipSpaceAndComments() {
    while (position_ < bytes_.size()) {
      if (bytes_[position_] == '#') {
        SkipComment();
      } else if (IsSpace(bytes_[position_])) {
        ++position_;
      } else {
        return;
      }
    }
  }

  std::string_view bytes_;
  std::size_t position_ = 0;
};

absl::StatusOr<Header> ReadHeader(std::string_view bytes) {
  if (bytes.size() < 3 || bytes[0] != 'P' || (!IsSpace(bytes[2]) && bytes[2] != '#')) {
    return InvalidArgument("not a PGM file: it does not start with P5 or P2");
  }
  if (bytes[1] != '5' && bytes[1] != '2') {
    return InvalidArgument("a P{} file is not a grey image: convert it to PGM (P5)", bytes.substr(1, 1));
  }
  Header header;
  header.is_plain = bytes[1] == '2';
  Scanner scanner(bytes);
  scanner.Skip(2);
  ENFILADE_ASSIGN_OR_RETURN(header.width, scanner.Number("width"));
  ENFILADE_ASSIGN_OR_RETURN(header.height, scanner.Number("height"));
  ENFILADE_ASSIGN_OR_RETURN(header.max_value, scanner.Number("largest grey"));
  ENFILADE_RETURN_IF_ERROR(scanner.Separator());
  header.size = scanner.position();
  return header;
}

absl::Status CheckHeader(const Header& header, std::size_t file_size) {
  if (header.width == 0 || header.height == 0) {
    return InvalidArgument("the PGM file has {} x {} pixels", header.width, header.height);
  }
  if (header.max_value == 0 || header.max_value > 65535) {
    return InvalidArgument("the PGM file's largest grey is {}: expected 1 to 255", header.max_value);
  }
  if (header.max_value > 255) {
    return InvalidArgument(
        "the PGM file has 16 bits a pixel (largest grey {}), which 8 bits cannot restore: convert it to 8 bits",
        header.max_value);
  }
  if (header.width > kMaxRasterCells / header.height) {
    return InvalidArgument("the PGM file announces {} x {} pixels: more than {} are not supported", header.width,
                           header.height, kMaxRasterCells);
  }
  // A plain pixel takes a digit and, except for the last, a space.
  const auto pixels = static_cast<std::size_t>(header.width * header.height);
  const std::size_t needed = header.is_plain ? 2 * pixels - 1 : pixels;
  if (file_size - header.size < needed) {
    return InvalidArgument(
        "the PGM file is truncated: it announces {} x {} pixels, but only {} bytes follow its header", header.width,
        header.height, file_size - header.size);
  }
  if (header.size > kMaxMetadataBytes) return InvalidArgument("the PGM file's header is {} bytes long", header.size);
  return absl::OkStatus();
}

absl::Status ReadPlainPixels(std::string_view bytes, const Header& header, PgmImage& image) {
  Scanner scanner(bytes);
  scanner.Skip(header.size);
  for (int row = image.height - 1; row >= 0; --row) {
    std::uint8_t* const pixels = image.pixels.data() + static_cast<std::ptrdiff_t>(row) * image.width;
    for (int column = 0; column < image.width; ++column) {
      ENFILADE_ASSIGN_OR_RETURN(const std::int64_t value, scanner.Number("next pixel"));
      pixels[column] = static_cast<std::uint8_t>(std::min<std::int64_t>(value, 255));
      if (value > image.max_value) {
        return InvalidArgument(
            "the PGM file's pixel in column {}, row {} from the top is {}, above its largest grey {}", column,
            image.height - 1 - row, value, image.max_value);
      }
    }
  }
  return absl::OkStatus();
}

absl::Status ReadBinaryPixels(std::string_view bytes, const Header& header, PgmImage& image) {
  const auto width = static_cast<std::size_t>(image.width);
  const std::string_view raster = bytes.substr(header.size, image.pixels.size());
  const std::string_view trailer = bytes.substr(header.size + raster.size());
  if (trailer.size() > kMaxMetadataBytes) {
    return InvalidArgument("{} bytes follow the PGM file's {} x {} pixels", trailer.size(), image.width, image.height);
  }
  for (std::size_t row = 0; row < static_cast<std::size_t>(image.height); ++row) {
    std::memcpy(image.pixels.data() + image.pixels.size() - (row + 1) * width, raster.data() + row * width, width);
  }
  image.header = bytes.substr(0, header.size);
  image.trailer = trailer;
  if (image.max_value == 255) return absl::OkStatus();
  const auto above = std::find_if(raster.begin(), raster.end(),
                                  [&](char pixel) { return static_cast<std::uint8_t>(pixel) > image.max_value; });
  if (above == raster.end()) return absl::OkStatus();
  const std::size_t index = static_cast<std::size_t>(above - raster.begin());
  return InvalidArgument("the PGM file's pixel in column {}, row {} from the top is {}, above its largest grey {}",
                         index % width, index / width, static_cast<std::uint8_t>(*above), image.max_value);
}

bool HeaderFits(const PgmFrame& frame) {
  const absl::StatusOr<Header> header = ReadHeader(frame.header);
  return header.ok() && !header->is_plain && header->size == frame.header.size() && header->width == frame.width &&
         header->height == frame.height && header->max_value == frame.max_value;
}

}  // namespace

absl::StatusOr<PgmImage> DecodePgm(std::string_view bytes) {
  ENFILADE_ASSIGN_OR_RETURN(const Header header, ReadHeader(bytes));
  ENFILADE_RETURN_IF_ERROR(CheckHeader(header, bytes.size()));
  PgmImage image;
  image.width = static_cast<int>(header.width);
  image.height = static_cast<int>(header.height);
  image.max_value = static_cast<int>(header.max_value);
  image.pixels.resize(static_cast<std::size_t>(header.width * header.height));
  ENFILADE_RETURN_IF_ERROR(header.is_plain ? ReadPlainPixels(bytes, header, image)
                                           : ReadBinaryPixels(bytes, header, image));
  return image;
}

std::string EncodePgm(const PgmFrame& frame, std::span<const std::uint8_t> pixels) {
  const std::string plain = fmt::format("P5\n{} {}\n{}\n", frame.width, frame.height, frame.max_value);
  const bool fits = HeaderFits(frame);
  const std::string_view header = fits ? frame.header : std::string_view(plain);
  const std::string_view trailer = fits ? frame.trailer : std::string_view();
  std::string bytes;
  bytes.reserve(header.size() + pixels.size() + trailer.size());
  bytes.append(header);
  const auto width = static_cast<std::size_t>(frame.width);
  for (std::size_t row = static_cast<std::size_t>(frame.height); row-- > 0;) {
    bytes.append(reinterpret_cast<const char*>(pixels.data()) + row * width, width);
  }
  bytes.append(trailer);
  return bytes;
}

}  // namespace enfilade::grid

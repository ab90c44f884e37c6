// SPDX-License-Identifier: Apache-2.0
#include "core/grid/files/png_codec.h"

#include <png.h>

#include <csetjmp>
#include <cstring>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"

// libpng reports errors by longjmp. The functions marked "jumps" below hold no object with a destructor across a call
// into libpng; what must be destroyed lives in a Session, which outlives the jump.

namespace enfilade::grid {
namespace {

// Maps have long runs of few values: higher levels take much longer and shrink files little.
constexpr int kPngCompressionLevel = 4;
constexpr int kMaxSide = 1'000'000;  // libpng's own default limit

struct Session {
  std::string error;
  std::string_view input;
  std::size_t position = 0;
  std::vector<std::uint8_t> pixels;  // one row, or all of an interlaced image
  std::string output;
};

void OnError(png_structp png, png_const_charp message) {
  static_cast<Session*>(png_get_error_ptr(png))->error = message;
  png_longjmp(png, 1);
}

void OnWarning(png_structp, png_const_charp) {}

void OnRead(png_structp png, png_bytep target, std::size_t size) {
  Session& session = *static_cast<Session*>(png_get_io_ptr(png));
  if (size > session.input.size() - session.position) png_error(png, "the file ends within the image");
  std::memcpy(target, session.input.data() + session.position, size);
  session.position += size;
}

void OnWrite(png_structp png, png_bytep bytes, std::size_t size) {
  static_cast<Session*>(png_get_io_ptr(png))->output.append(reinterpret_cast<const char*>(bytes), size);
}

void OnFlush(png_structp) {}

// Jumps. deflate packs at most 1032 bytes into one (zlib's technical details).
void CheckSize(png_structp png, png_infop info, std::size_t file_size) {
  const std::int64_t height = png_get_image_height(png, info);
  if (png_get_image_width(png, info) * height > kMaxImagePixels) png_error(png, "the image is too large");
  const std::size_t unpacked = png_get_rowbytes(png, info) * static_cast<std::size_t>(height);
  if (unpacked / 1032 > file_size) png_error(png, "the file is too short for so many pixels");
}

// Jumps.
void ReadHeader(png_structp png, png_infop info, Session& session, SixteenBits sixteen_bits) {
  png_set_user_limits(png, kMaxSide, kMaxSide);
  png_read_info(png, info);
  const bool deep = png_get_bit_depth(png, info) == 16;
  if (deep && sixteen_bits == SixteenBits::kRefused) {
    png_error(png, "16-bit samples are not supported, because 8 bits cannot restore them: convert to 8 bits");
  }
  if (!deep && sixteen_bits == SixteenBits::kKept) png_error(png, "the samples do not have 16 bits");
  if (deep && sixteen_bits == SixteenBits::kScaled) png_set_scale_16(png);
  CheckSize(png, info, session.input.size());
  png_set_expand(png);  // palettes, fewer than 8 bits, transparent colours
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
}

// Jumps.
void ReadRows(png_structp png, png_infop info, Session& session, PixelReceiver& receiver) {
  const auto height = static_cast<int>(png_get_image_height(png, info));
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  receiver.Begin(static_cast<int>(png_get_image_width(png, info)), height, png_get_channels(png, info));
  if (png_get_interlace_type(png, info) == PNG_INTERLACE_NONE) {
    session.pixels.resize(row_bytes);
    for (int row = 0; row < height; ++row) {
      png_read_row(png, session.pixels.data(), nullptr);
      receiver.Row(row, session.pixels.data());
    }
  } else {
    session.pixels.resize(row_bytes * static_cast<std::size_t>(height));
    for (int pass = 0; pass < PNG_INTERLACE_ADAM7_PASSES; ++pass) {
      for (int row = 0; row < height; ++row) {
        png_read_row(png, session.pixels.data() + static_cast<std::size_t>(row) * row_bytes, nullptr);
      }
    }
    for (int row = 0; row < height; ++row) {
      receiver.Row(row, session.pixels.data() + static_cast<std::size_t>(row) * row_bytes);
    }
  }
  png_read_end(png, nullptr);
}

// Jumps back into itself.
bool Decode(png_structp png, png_infop info, Session& session, SixteenBits sixteen_bits, PixelReceiver& receiver) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_read_fn(png, &session, &OnRead);
  ReadHeader(png, info, session, sixteen_bits);
  ReadRows(png, info, session, receiver);
  return true;
}

class ImageReceiver : public PixelReceiver {
 public:
  explicit ImageReceiver(int sample_bytes) : sample_bytes_(sample_bytes) {}
  void Begin(int width, int height, int channels) override {
    image_.width = width;
    image_.height = height;
    image_.channels = channels;
    image_.samples.reserve(static_cast<std::size_t>(height) * RowBytes());
  }
  void Row(int /*row*/, const std::uint8_t* samples) override {
    image_.samples.insert(image_.samples.end(), samples, samples + RowBytes());
  }
  PixelImage& image() { return image_; }

 private:
  std::size_t RowBytes() const {
    return static_cast<std::size_t>(image_.width) * static_cast<std::size_t>(image_.channels * sample_bytes_);
  }

  int sample_bytes_;
  PixelImage image_;
};

int ColorTypeOf(int channels) {
  constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                            PNG_COLOR_TYPE_RGB_ALPHA};
  return kTypes[channels - 1];
}

// Jumps back into itself.
bool Encode(png_structp png, png_infop info, const PixelRows& rows, Session& session) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, &session, &OnWrite, &OnFlush);
  png_set_compression_level(png, kPngCompressionLevel);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);
  png_set_IHDR(png, info, static_cast<png_uint_32>(rows.width), static_cast<png_uint_32>(rows.height), rows.bit_depth,
               ColorTypeOf(rows.channels), PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int row = 0; row < rows.height; ++row) png_write_row(png, rows.top_row + row * rows.stride);
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

absl::Status ReadPng(std::string_view png_bytes, PixelReceiver& receiver, SixteenBits sixteen_bits) {
  constexpr std::size_t kSignatureSize = 8;
  if (png_bytes.size() < kSignatureSize ||
      png_sig_cmp(reinterpret_cast<png_const_bytep>(png_bytes.data()), 0, kSignatureSize) != 0) {
    return InvalidArgument("not a PNG image: it does not start with the PNG signature");
  }
  Session session;
  session.input = png_bytes;
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &session, &OnError, &OnWarning);
  if (png == nullptr) return ResourceExhausted("no memory to read a PNG image");
  png_infop info = png_create_info_struct(png);
  const bool done = info != nullptr && Decode(png, info, session, sixteen_bits, receiver);
  const png_uint_32 width = info != nullptr ? png_get_image_width(png, info) : 0;
  const png_uint_32 height = info != nullptr ? png_get_image_height(png, info) : 0;
  png_destroy_read_struct(&png, &info, nullptr);
  if (done) return absl::OkStatus();
  return InvalidArgument("cannot read the PNG image ({} x {} pixels): {}", width, height, session.error);
}

absl::StatusOr<PixelImage> DecodePng(std::string_view png, SixteenBits sixteen_bits) {
  ImageReceiver receiver(sixteen_bits == SixteenBits::kKept ? 2 : 1);
  ENFILADE_RETURN_IF_ERROR(ReadPng(png, receiver, sixteen_bits));
  return std::move(receiver.image());
}

absl::StatusOr<std::string> EncodePng(const PixelRows& rows) {
  if (rows.width <= 0 || rows.height <= 0 || rows.width > kMaxSide || rows.height > kMaxSide || rows.channels < 1 ||
      rows.channels > 4 || (rows.bit_depth != 8 && rows.bit_depth != 16)) {
    return InvalidArgument("cannot write a PNG image of {} x {} pixels with {} channels of {} bits", rows.width,
                           rows.height, rows.channels, rows.bit_depth);
  }
  Session session;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &session, &OnError, &OnWarning);
  if (png == nullptr) return ResourceExhausted("no memory to write a PNG image");
  png_infop info = png_create_info_struct(png);
  const bool done = info != nullptr && Encode(png, info, rows, session);
  png_destroy_write_struct(&png, &info);
  if (!done) return Internal("cannot write the PNG image: {}", session.error);
  return std::move(session.output);
}

absl::StatusOr<std::string> EncodePng(const PixelImage& image) {
  return EncodePng(PixelRows{.width = image.width,
                             .height = image.height,
                             .channels = image.channels,
                             .top_row = image.samples.data(),
                             .stride = std::ptrdiff_t{image.width} * image.channels});
}

}  // namespace enfilade::grid

// SPDX-License-Identifier: Apache-2.0
#include "perception/image/image_header.h"

#include <cstddef>

#include "core/base/error.h"

namespace enfilade::perception {
namespace {

constexpr std::string_view kPngSignature("\x89PNG\r\n\x1a\n", 8);

std::uint32_t ByteAt(std::string_view bytes, std::size_t index) { return static_cast<unsigned char>(bytes[index]); }
std::uint32_t Word16(std::string_view bytes, std::size_t index) {
  return ByteAt(bytes, index) << 8 | ByteAt(bytes, index + 1);
}
std::uint32_t Word32(std::string_view bytes, std::size_t index) {
  return Word16(bytes, index) << 16 | Word16(bytes, index + 2);
}

absl::StatusOr<ImageHeader> ReadPngHeader(std::string_view bytes) {
  if (bytes.size() < 33 || bytes.substr(12, 4) != "IHDR") {
    return InvalidArgument("the PNG ends or is damaged before its header is complete ({} bytes)", bytes.size());
  }
  ImageHeader header{.format = ImageFormat::kPng,
                     .width = Word32(bytes, 16),
                     .height = Word32(bytes, 20),
                     .components = 0,
                     .bit_depth = static_cast<int>(ByteAt(bytes, 24))};
  switch (ByteAt(bytes, 25)) {
    case 0:
      header.components = 1;
      break;
    case 2:
    case 3:  // palette
      header.components = 3;
      break;
    case 4:
      header.components = 2;
      break;
    case 6:
      header.components = 4;
      break;
    default:
      return InvalidArgument("the PNG's colour type {} does not exist", ByteAt(bytes, 25));
  }
  return header;
}

// SOF0..SOF15 without DHT (C4), JPG (C8) and DAC (CC).
bool IsFrameHeader(std::uint32_t marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

absl::StatusOr<ImageHeader> ReadJpegHeader(std::string_view bytes) {
  std::size_t position = 2;
  while (position + 4 <= bytes.size()) {
    if (ByteAt(bytes, position) != 0xFF) return InvalidArgument("the JPEG has no marker at byte {}", position);
    const std::uint32_t marker = ByteAt(bytes, position + 1);
    if (marker == 0xFF) {  // fill byte
      ++position;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {  // without content
      position += 2;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA) break;  // the end, or pixels without a frame
    const std::size_t length = Word16(bytes, position + 2);
    if (length < 2)
      return InvalidArgument("the JPEG's segment at byte {} has the impossible length {}", position, length);
    if (IsFrameHeader(marker)) {
      if (position + 10 > bytes.size()) break;
      return ImageHeader{.format = ImageFormat::kJpeg,
                         .width = Word16(bytes, position + 7),
                         .height = Word16(bytes, position + 5),
                         .components = static_cast<int>(ByteAt(bytes, position + 9)),
                         .bit_depth = static_cast<int>(ByteAt(bytes, position + 4))};
    }
    position += 2 + length;
  }
  return InvalidArgument("the JPEG ends before its frame header ({} bytes)", bytes.size());
}

}  // namespace

absl::StatusOr<ImageHeader> ReadImageHeader(std::string_view bytes) {
  if (bytes.empty()) return InvalidArgument("the image is empty (0 bytes)");
  if (bytes.substr(0, kPngSignature.size()) == kPngSignature) return ReadPngHeader(bytes);
  if (bytes.size() >= 3 && ByteAt(bytes, 0) == 0xFF && ByteAt(bytes, 1) == 0xD8 && ByteAt(bytes, 2) == 0xFF) {
    return ReadJpegHeader(bytes);
  }
  return InvalidArgument("the image is neither PNG nor JPEG ({} bytes)", bytes.size());
}

}  // namespace enfilade::perception

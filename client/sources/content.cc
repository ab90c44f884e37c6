#include "client/sources/content.h"

#include <openssl/sha.h>

#include <charconv>
#include <fstream>
#include <system_error>

#include "core/base/error.h"

namespace enfilade::sources {

namespace fs = std::filesystem;

absl::StatusOr<std::string> ReadContent(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) return NotFound("{}: no such file", path.string());
  if (status.type() != fs::file_type::regular) return InvalidArgument("{}: is no regular file", path.string());
  const auto size = fs::file_size(path, error);
  if (error) return InvalidArgument("{}: {}", path.string(), error.message());
  if (size < 1 || size > static_cast<std::uintmax_t>(kMaxBlobBytes)) {
    return InvalidArgument("{}: has {} bytes: expected 1 to {}", path.string(), size, kMaxBlobBytes);
  }
  std::string content(size, '\0');
  std::ifstream file(path, std::ios::binary);
  if (!file.read(content.data(), static_cast<std::streamsize>(size))) {
    return InvalidArgument("{}: cannot be read", path.string());
  }
  return content;
}

BlobRef RefOf(std::string_view content) {
  BlobRef ref;
  ref.sha256.resize(SHA256_DIGEST_LENGTH);
  SHA256(reinterpret_cast<const unsigned char*>(content.data()), content.size(),
         reinterpret_cast<unsigned char*>(ref.sha256.data()));
  ref.size = static_cast<std::int64_t>(content.size());
  return ref;
}

std::string ToHex(std::string_view bytes) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  hex.reserve(bytes.size() * 2);
  for (const char byte : bytes) {
    hex.push_back(kDigits[static_cast<unsigned char>(byte) >> 4]);
    hex.push_back(kDigits[static_cast<unsigned char>(byte) & 15]);
  }
  return hex;
}

std::string FromHex(std::string_view hex) {
  if (hex.size() % 2 != 0) return {};
  std::string bytes;
  for (std::size_t i = 0; i < hex.size(); i += 2) {
    unsigned char byte = 0;
    const auto [stop, error] = std::from_chars(hex.data() + i, hex.data() + i + 2, byte, 16);
    if (error != std::errc() || stop != hex.data() + i + 2) return {};
    bytes.push_back(static_cast<char>(byte));
  }
  return bytes;
}

}  // namespace enfilade::sources

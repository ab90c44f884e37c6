#include "server/rpc/paging.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "core/base/error.h"

namespace enfilade::server {
namespace {

// In front of the key, so that other base64 is not taken for a token.
constexpr char kMark[] = "p1:";

}  // namespace

absl::StatusOr<int> PageSize(std::int32_t requested) {
  if (requested < 0) return InvalidArgument("page_size is {}: it must not be negative", requested);
  return requested == 0 ? 100 : std::min(requested, 1000);
}

std::string ToPageToken(const std::string& last_key) { return absl::WebSafeBase64Escape(kMark + last_key); }

absl::StatusOr<std::string> FromPageToken(const std::string& token) {
  if (token.empty()) return std::string();
  std::string key;
  if (!absl::WebSafeBase64Unescape(token, &key) || key.rfind(kMark, 0) != 0) {
    return InvalidArgument("page_token \"{}\" is not from this server", token.substr(0, 100));
  }
  return key.substr(sizeof(kMark) - 1);
}

}  // namespace enfilade::server

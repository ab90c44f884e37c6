// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/paging.h"

#include <algorithm>
#include <charconv>

#include "absl/strings/escaping.h"
#include "core/base/error.h"
#include "core/base/excerpt.h"
#include "core/base/status_macros.h"

namespace enfilade::server {
namespace {

// Precedes the key, so that other base64 is not accepted as a token.
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
    return InvalidArgument("page_token \"{}\" is not from this server", Excerpt(token, 100));
  }
  return key.substr(sizeof(kMark) - 1);
}

absl::StatusOr<std::int64_t> FromNumericPageToken(const std::string& token, std::int64_t first) {
  if (token.empty()) return first;
  ENFILADE_ASSIGN_OR_RETURN(const std::string key, FromPageToken(token));
  std::int64_t number = 0;
  const auto parsed = std::from_chars(key.data(), key.data() + key.size(), number);
  if (parsed.ec == std::errc() && parsed.ptr == key.data() + key.size()) return number;
  return InvalidArgument("page_token is not from this call");
}

}  // namespace enfilade::server

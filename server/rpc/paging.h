// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"

namespace enfilade::server {

// A page token is the key of the last row of the page before, made opaque: the server keeps nothing between pages.

// 0 means 100, and more than 1000 means 1000. INVALID_ARGUMENT if negative.
absl::StatusOr<int> PageSize(std::int32_t requested);

std::string ToPageToken(const std::string& last_key);
// Empty for the first page. INVALID_ARGUMENT if the server did not make `token`.
absl::StatusOr<std::string> FromPageToken(const std::string& token);

// The same for lists whose key is a number; `first` for the first page.
absl::StatusOr<std::int64_t> FromNumericPageToken(const std::string& token, std::int64_t first);

// Cuts `rows`, which has one row more than the page if there is another page, to the page. True if more follow.
template <typename Rows>
bool CutToPage(Rows& rows, int page_size) {
  if (rows.size() <= static_cast<std::size_t>(page_size)) return false;
  rows.resize(static_cast<std::size_t>(page_size));
  return true;
}

}  // namespace enfilade::server

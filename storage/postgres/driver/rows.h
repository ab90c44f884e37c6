// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "storage/etag.h"
#include "storage/postgres/driver/error.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/request_id.h"

namespace enfilade::storage::postgres {

// Bound as NULL if empty.
inline std::optional<std::string_view> NullIfEmpty(const std::string& text) {
  return text.empty() ? std::nullopt : std::optional<std::string_view>(text);
}

// The columns of a creation's request: its id and the digest of what it asked for.
inline std::optional<std::string_view> IdOrNull(const RequestId& request) { return NullIfEmpty(request.value); }
inline std::optional<Bytes> DigestOrNull(const RequestId& request) {
  if (request.empty() || request.payload_sha256.empty()) return std::nullopt;
  return Bytes{request.payload_sha256};
}
// Ends the columns of a statement that looks for an earlier request, whose digest is parameter `digest`.
#define ENFILADE_SAME_REQUEST(digest) ", coalesce(request_sha256 = " digest ", true)"

// All rows of `result`, each through `read(Row&)`.
template <typename Read>
auto ReadRows(const Result& result, const Read& read) -> absl::StatusOr<std::vector<std::invoke_result_t<Read, Row&>>> {
  std::vector<std::invoke_result_t<Read, Row&>> values;
  values.reserve(static_cast<std::size_t>(result.rows()));
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    values.push_back(read(row));
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return values;
}

// The first row, or NOT_FOUND saying that `name` does not exist.
template <typename Read>
auto ReadOne(const Result& result, const Read& read, const std::string& name)
    -> absl::StatusOr<std::invoke_result_t<Read, Row&>> {
  if (result.rows() == 0) return NotFound("{} does not exist", name);
  Row row(result, 0);
  auto value = read(row);
  ENFILADE_RETURN_IF_ERROR(row.status());
  return value;
}

// What an earlier request has created. `result`: its columns and ENFILADE_SAME_REQUEST.
template <typename Read>
auto ReadRequested(const Result& result, const Read& read, const std::string& name)
    -> absl::StatusOr<std::invoke_result_t<Read, Row&>> {
  bool same = false;
  auto value = ReadOne(
      result,
      [&](Row& row) {
        auto created = read(row);
        same = row.Bool();
        return created;
      },
      name);
  if (value.ok()) ENFILADE_RETURN_IF_ERROR(CheckSameRequest(same));
  return value;
}

using storage::StaleEtag;

}  // namespace enfilade::storage::postgres

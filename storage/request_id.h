// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "absl/status/status.h"
#include "core/base/error.h"

namespace enfilade::storage {

// Makes a creation safe to repeat (AIP-155): if an earlier call with the same id has created something, that is
// returned and nothing is created. INVALID_ARGUMENT if the earlier call asked for something else.
struct RequestId {
  RequestId() = default;
  RequestId(std::string id) : value(std::move(id)) {}  // NOLINT(google-explicit-constructor)
  RequestId(const char* id) : value(id) {}             // NOLINT(google-explicit-constructor)
  RequestId(std::string id, std::string digest) : value(std::move(id)), payload_sha256(std::move(digest)) {}

  bool empty() const { return value.empty(); }

  std::string value;           // empty: the call is not repeated
  std::string payload_sha256;  // of all that the call asks for, 32 bytes; empty: not compared
};

// Whether a repeated call asks for the same as the one that was `stored`.
inline bool IsSameRequest(const RequestId& stored, const RequestId& repeated) {
  return stored.payload_sha256.empty() || repeated.payload_sha256.empty() ||
         stored.payload_sha256 == repeated.payload_sha256;
}
inline absl::Status CheckSameRequest(bool same) {
  if (same) return absl::OkStatus();
  return InvalidArgument("request_id was used before, to create something else: choose another one");
}

}  // namespace enfilade::storage

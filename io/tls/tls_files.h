// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "absl/status/statusor.h"

namespace enfilade::io {

// What one side of a TLS connection has, as paths of PEM files or as their content. Empty: none.
struct TlsParts {
  std::string certificate;  // its own, followed by those of the authorities between it and the root
  std::string key;          // of `certificate`, not encrypted
  std::string authorities;  // certificates of those whose word is taken for who the other side is

  bool empty() const { return certificate.empty() && key.empty() && authorities.empty(); }
  friend bool operator==(const TlsParts&, const TlsParts&) = default;
};

struct CheckedTls {
  TlsParts content;
  // When the own certificate ends; the end of time without one.
  std::chrono::system_clock::time_point expires = std::chrono::system_clock::time_point::max();
};

// Reads the files. INVALID_ARGUMENT, with the path: a certificate without its key or a key without its certificate, a
// file that has no certificate or key, a key of another certificate, an own certificate that is no longer valid.
// Otherwise as ReadFile.
absl::StatusOr<CheckedTls> ReadTlsFiles(const TlsParts& paths);

}  // namespace enfilade::io

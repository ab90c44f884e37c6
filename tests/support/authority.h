// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "io/tls/tls_files.h"

namespace enfilade::testing {

// A certificate authority of a test's own, and what it issues, in PEM format.
class Authority {
 public:
  explicit Authority(const std::string& name);
  ~Authority();

  std::string pem() const;
  // A certificate of the name for localhost and 127.0.0.1, with its key. `life` may be negative: it has ended.
  io::TlsParts Issue(const std::string& name, std::chrono::seconds life = std::chrono::hours(1));
  // Revokes what has been issued last.
  void RevokeLast() { revoked_.push_back(serial_); }
  // Writes the list of revoked certificates into the folder, under the name that OpenSSL looks for.
  void WriteRevoked(const std::filesystem::path& folder) const;

 private:
  EVP_PKEY* key_;
  X509* certificate_;
  long serial_ = 1;
  std::vector<long> revoked_;
};

// Writes the parts that are set to files NAME.pem, NAME.key and NAME.authorities of the folder, as somebody who
// replaces them does. Returns their paths.
io::TlsParts WriteTls(const std::filesystem::path& folder, const std::string& name, const io::TlsParts& content);

}  // namespace enfilade::testing

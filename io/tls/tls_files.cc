// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_files.h"

#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>

#include <ctime>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"

namespace enfilade::io {
namespace {

template <auto kFree>
struct Free {
  template <typename T>
  void operator()(T* pointer) const {
    kFree(pointer);
  }
};
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Bytes = std::unique_ptr<BIO, Free<BIO_free_all>>;

Bytes Open(const std::string& pem) { return Bytes(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()))); }

// An encrypted key has no passphrase here: asking at the terminal would block.
int NoPassphrase(char* /*buffer*/, int /*size*/, int /*writes*/, void* /*data*/) { return -1; }

std::vector<Certificate> ReadCertificates(const std::string& pem) {
  const Bytes bytes = Open(pem);
  std::vector<Certificate> all;
  while (X509* one = PEM_read_bio_X509(bytes.get(), nullptr, NoPassphrase, nullptr)) all.emplace_back(one);
  ERR_clear_error();  // the end of the file is one, too
  return all;
}

std::chrono::system_clock::time_point EndOf(const X509& certificate) {
  std::tm utc = {};
  if (ASN1_TIME_to_tm(X509_get0_notAfter(&certificate), &utc) != 1) return {};
  return std::chrono::system_clock::from_time_t(timegm(&utc));
}

absl::StatusOr<std::string> ReadIfNamed(const std::string& path) {
  if (path.empty()) return std::string();
  return ReadFile(path);
}

absl::Status CheckOwn(const TlsParts& paths, CheckedTls& tls) {
  const std::vector<Certificate> chain = ReadCertificates(tls.content.certificate);
  if (chain.empty()) return InvalidArgument("{} has no certificate in PEM format", paths.certificate);
  const Bytes bytes = Open(tls.content.key);
  const Key key(PEM_read_bio_PrivateKey(bytes.get(), nullptr, NoPassphrase, nullptr));
  const bool fits = key != nullptr && X509_check_private_key(chain.front().get(), key.get()) == 1;
  ERR_clear_error();
  if (key == nullptr) return InvalidArgument("{} has no private key in PEM format, or it is encrypted", paths.key);
  if (!fits) return InvalidArgument("the key in {} is not that of the certificate in {}", paths.key, paths.certificate);
  tls.expires = EndOf(*chain.front());
  if (tls.expires <= std::chrono::system_clock::now()) {
    return InvalidArgument("the certificate in {} is no longer valid", paths.certificate);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<CheckedTls> ReadTlsFiles(const TlsParts& paths) {
  if (paths.certificate.empty() != paths.key.empty()) {
    return InvalidArgument("a certificate and its key go together: {} was given alone",
                           paths.key.empty() ? paths.certificate : paths.key);
  }
  CheckedTls tls;
  ENFILADE_ASSIGN_OR_RETURN(tls.content.certificate, ReadIfNamed(paths.certificate));
  ENFILADE_ASSIGN_OR_RETURN(tls.content.key, ReadIfNamed(paths.key));
  ENFILADE_ASSIGN_OR_RETURN(tls.content.authorities, ReadIfNamed(paths.authorities));
  if (!paths.certificate.empty()) ENFILADE_RETURN_IF_ERROR(CheckOwn(paths, tls));
  if (!paths.authorities.empty() && ReadCertificates(tls.content.authorities).empty()) {
    return InvalidArgument("{} has no certificate in PEM format", paths.authorities);
  }
  return tls;
}

}  // namespace enfilade::io

// SPDX-License-Identifier: Apache-2.0
#include "tests/support/authority.h"

#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/x509v3.h>

#include <stdexcept>
#include <utility>

#include "fmt/format.h"
#include "io/file.h"

namespace enfilade::testing {
namespace {

template <typename Write>
std::string ToPem(Write&& write) {
  BIO* out = BIO_new(BIO_s_mem());
  if (write(out) != 1) throw std::runtime_error("OpenSSL cannot write PEM");
  char* data = nullptr;
  const long size = BIO_get_mem_data(out, &data);
  std::string pem(data, static_cast<std::size_t>(size));
  BIO_free(out);
  return pem;
}

std::string ToPem(X509* certificate) {
  return ToPem([&](BIO* out) { return PEM_write_bio_X509(out, certificate); });
}

void AddExtension(X509* certificate, X509* issuer, int kind, const std::string& value) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, certificate, nullptr, nullptr, 0);
  X509_EXTENSION* extension = X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str());
  if (extension == nullptr) throw std::runtime_error("OpenSSL does not know the extension " + value);
  X509_add_ext(certificate, extension, -1);
  X509_EXTENSION_free(extension);
}

X509* NewCertificate(const std::string& name, long serial, EVP_PKEY* key, std::chrono::seconds life) {
  X509* certificate = X509_new();
  X509_set_version(certificate, 2);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate), serial);
  X509_gmtime_adj(X509_getm_notBefore(certificate), -86'400);
  X509_gmtime_adj(X509_getm_notAfter(certificate), static_cast<long>(life.count()));
  X509_set_pubkey(certificate, key);
  X509_NAME_add_entry_by_txt(X509_get_subject_name(certificate), "CN", MBSTRING_UTF8,
                             reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1, 0);
  return certificate;
}

void Write(const std::filesystem::path& path, const std::string& content) {
  const absl::Status written = io::WriteFile(path, content);
  if (!written.ok()) throw std::runtime_error(written.ToString());
}

}  // namespace

Authority::Authority(const std::string& name)
    : key_(EVP_EC_gen("P-256")), certificate_(NewCertificate(name, serial_, key_, std::chrono::hours(24))) {
  X509_set_issuer_name(certificate_, X509_get_subject_name(certificate_));
  AddExtension(certificate_, certificate_, NID_basic_constraints, "critical,CA:TRUE");
  AddExtension(certificate_, certificate_, NID_key_usage, "critical,keyCertSign,cRLSign");
  X509_sign(certificate_, key_, EVP_sha256());
}

Authority::~Authority() {
  X509_free(certificate_);
  EVP_PKEY_free(key_);
}

std::string Authority::pem() const { return ToPem(certificate_); }

io::TlsParts Authority::Issue(const std::string& name, std::chrono::seconds life) {
  EVP_PKEY* key = EVP_EC_gen("P-256");
  X509* certificate = NewCertificate(name, ++serial_, key, life);
  X509_set_issuer_name(certificate, X509_get_subject_name(certificate_));
  AddExtension(certificate, certificate_, NID_basic_constraints, "critical,CA:FALSE");
  AddExtension(certificate, certificate_, NID_subject_alt_name, "DNS:" + name + ",DNS:localhost,IP:127.0.0.1");
  X509_sign(certificate, key_, EVP_sha256());
  io::TlsParts issued;
  issued.certificate = ToPem(certificate);
  issued.key =
      ToPem([&](BIO* out) { return PEM_write_bio_PKCS8PrivateKey(out, key, nullptr, nullptr, 0, nullptr, nullptr); });
  X509_free(certificate);
  EVP_PKEY_free(key);
  return issued;
}

void Authority::WriteRevoked(const std::filesystem::path& folder) const {
  X509_CRL* list = X509_CRL_new();
  X509_CRL_set_version(list, 1);
  X509_CRL_set_issuer_name(list, X509_get_subject_name(certificate_));
  ASN1_TIME* time = X509_gmtime_adj(nullptr, 0);
  X509_CRL_set1_lastUpdate(list, time);
  X509_gmtime_adj(time, 86'400);
  X509_CRL_set1_nextUpdate(list, time);
  ASN1_TIME_free(time);
  for (const long serial : revoked_) {
    X509_REVOKED* one = X509_REVOKED_new();
    ASN1_INTEGER* number = ASN1_INTEGER_new();
    ASN1_INTEGER_set(number, serial);
    X509_REVOKED_set_serialNumber(one, number);
    ASN1_INTEGER_free(number);
    ASN1_TIME* when = X509_gmtime_adj(nullptr, -60);
    X509_REVOKED_set_revocationDate(one, when);
    ASN1_TIME_free(when);
    X509_CRL_add0_revoked(list, one);
  }
  X509_CRL_sort(list);
  X509_CRL_sign(list, key_, EVP_sha256());
  const unsigned long hash = X509_NAME_hash_ex(X509_get_subject_name(certificate_), nullptr, nullptr, nullptr);
  Write(folder / fmt::format("{:08x}.r0", hash), ToPem([&](BIO* out) { return PEM_write_bio_X509_CRL(out, list); }));
  X509_CRL_free(list);
}

io::TlsParts WriteTls(const std::filesystem::path& folder, const std::string& name, const io::TlsParts& content) {
  io::TlsParts paths;
  const auto write = [&](const std::string& part, const char* suffix, std::string& path) {
    if (part.empty()) return;
    path = folder / (name + suffix);
    Write(path, part);
  };
  write(content.certificate, ".pem", paths.certificate);
  write(content.key, ".key", paths.key);
  write(content.authorities, ".authorities", paths.authorities);
  return paths;
}

}  // namespace enfilade::testing

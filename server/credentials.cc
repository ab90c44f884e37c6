// SPDX-License-Identifier: Apache-2.0
#include "server/credentials.h"

#include <utility>

#include "core/base/status_macros.h"
#include "grpcpp/security/tls_certificate_provider.h"
#include "grpcpp/security/tls_credentials_options.h"
#include "spdlog/spdlog.h"

namespace enfilade::server {
namespace {

// Newer API of gRPC, still called experimental in 1.51; the stable one cannot read files again.
namespace tls = grpc::experimental;

constexpr unsigned kRefreshSeconds = 1;

io::ReloadedTlsFiles::OnReload Report(Metrics& metrics) {
  return [&metrics](const absl::StatusOr<io::CheckedTls>& files) {
    if (files.ok()) {
      metrics.SetCertificateEnd(files->expires);
      spdlog::info("the TLS files have changed: new connections get them");
    } else {
      metrics.CountTlsReloadFailure();
      spdlog::error("the TLS files have changed, and are not used: {}. The ones before stay",
                    std::string(files.status().message()));
    }
  };
}

}  // namespace

absl::StatusOr<ListenCredentials> MakeListenCredentials(const ServerOptions::Listen& options, Metrics& metrics) {
  ListenCredentials made;
  if (options.tls_certificate.empty() || options.address.starts_with("unix:")) {
    made.credentials = grpc::InsecureServerCredentials();
    return made;
  }
  const io::TlsParts sources = {
      .certificate = options.tls_certificate, .key = options.tls_key, .authorities = options.tls_client_authorities};
  ENFILADE_ASSIGN_OR_RETURN(made.files,
                            io::ReloadedTlsFiles::Open(sources, options.tls_revoked_directory, Report(metrics)));
  metrics.SetCertificateEnd(made.files->expires());
  const io::TlsParts copies = made.files->paths();
  tls::TlsServerCredentialsOptions given(std::make_shared<tls::FileWatcherCertificateProvider>(
      copies.key, copies.certificate, copies.authorities, kRefreshSeconds));
  given.watch_identity_key_cert_pairs();
  if (!copies.authorities.empty()) {
    given.watch_root_certs();
    given.set_cert_request_type(GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  }
  if (!options.tls_revoked_directory.empty()) given.set_crl_directory(options.tls_revoked_directory);
  made.credentials = tls::TlsServerCredentials(given);
  return made;
}

}  // namespace enfilade::server

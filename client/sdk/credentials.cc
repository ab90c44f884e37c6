// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/credentials.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "grpcpp/security/tls_certificate_provider.h"
#include "grpcpp/security/tls_credentials_options.h"

namespace enfilade::client {
namespace {

// Newer API of gRPC, still called experimental in 1.51; the stable one cannot read files again.
namespace tls = grpc::experimental;

constexpr unsigned kRefreshSeconds = 1;

}  // namespace

absl::StatusOr<Credentials> Credentials::Tls(const io::TlsParts& files, io::ReloadedTlsFiles::OnReload on_reload) {
  if (files.authorities.empty())
    return InvalidArgument("TLS needs the file of the authorities whose servers are trusted");
  Credentials made;
  ENFILADE_ASSIGN_OR_RETURN(made.files_, io::ReloadedTlsFiles::Open(files, "", std::move(on_reload)));
  const io::TlsParts copies = made.files_->paths();
  tls::TlsChannelCredentialsOptions options;
  options.set_certificate_provider(std::make_shared<tls::FileWatcherCertificateProvider>(
      copies.key, copies.certificate, copies.authorities, kRefreshSeconds));
  options.watch_root_certs();
  if (!copies.certificate.empty()) options.watch_identity_key_cert_pairs();
  made.channel_ = tls::TlsCredentials(options);
  return made;
}

std::shared_ptr<grpc::ChannelCredentials> Credentials::For(const std::string& address) const {
  if (channel_ == nullptr || address.starts_with("unix:")) return grpc::InsecureChannelCredentials();
  return channel_;
}

}  // namespace enfilade::client

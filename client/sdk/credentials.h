// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "grpcpp/security/credentials.h"
#include "io/tls/reloaded_tls_files.h"

namespace enfilade::client {

// What a client shows to its server, and by what it knows the server. Copyable; copies share the files, which are
// looked at as long as one of them lives: new connections get what has changed.
class Credentials {
 public:
  // Without TLS.
  Credentials() = default;

  // TLS to servers whose certificate comes from `files.authorities`, which must be set, and names the host. With
  // `files.certificate` and `files.key` the client shows its own. `on_reload`, in another thread: what becomes of
  // changes of the files. INVALID_ARGUMENT, or the error of the file.
  static absl::StatusOr<Credentials> Tls(const io::TlsParts& files, io::ReloadedTlsFiles::OnReload on_reload = {});

  // For a server at host:port, or at unix:/path, which is never by TLS.
  std::shared_ptr<grpc::ChannelCredentials> For(const std::string& address) const;

 private:
  std::shared_ptr<io::ReloadedTlsFiles> files_;  // null: without TLS
  std::shared_ptr<grpc::ChannelCredentials> channel_;
};

}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "grpcpp/security/server_credentials.h"
#include "io/tls/reloaded_tls_files.h"
#include "server/app/runtime/metrics.h"
#include "server/config/server_options.h"

namespace enfilade::server {

// What the server listens with: TLS by the files of the options (1.2 or newer, the only versions that gRPC speaks), or
// nothing at a Unix socket and without files. Keep it as long as the server: the files are looked at while it runs. New
// connections get what has changed, open ones go on.
struct ListenCredentials {
  std::unique_ptr<io::ReloadedTlsFiles> files;  // null: no TLS
  std::shared_ptr<grpc::ServerCredentials> credentials;
};

// INVALID_ARGUMENT, or the error of the file, if the files are not what they should be.
absl::StatusOr<ListenCredentials> MakeListenCredentials(const ServerOptions::Listen& options, Metrics& metrics);

}  // namespace enfilade::server

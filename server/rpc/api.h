// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "grpcpp/server_builder.h"
#include "server/app/services.h"

namespace enfilade::server {

// The gRPC services of enfilade.v1: a list of the RPCs, one line each. The handlers that do the work are in the folders
// beside this one, a file for each RPC. See docs/adding-an-rpc.md.
class Api {
 public:
  // `services` must outlive the server that is built.
  explicit Api(const Services& services);
  ~Api();
  Api(const Api&) = delete;
  Api& operator=(const Api&) = delete;

  void RegisterWith(grpc::ServerBuilder& builder);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::server

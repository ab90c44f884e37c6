// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "grpcpp/server_builder.h"
#include "server/app/services.h"

namespace enfilade::server {

// The gRPC services of enfilade.v1. Each method only names the handler that does the work: one file per RPC in the
// folders beside this one.
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

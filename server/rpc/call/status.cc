// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/status.h"

#include <string>

namespace enfilade::server {

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const auto code = status.code() == absl::StatusCode::kUnknown ? absl::StatusCode::kInternal : status.code();
  // gRPC's codes are the canonical ones, number by number.
  return {static_cast<grpc::StatusCode>(code), std::string(status.message().data(), status.message().size())};
}

}  // namespace enfilade::server

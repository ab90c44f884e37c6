// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/status.h"

#include <algorithm>
#include <string>

namespace enfilade::server {

namespace {

constexpr char kActorKey[] = "enfilade-actor";
constexpr std::size_t kMaxActorBytes = 200;

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const auto code = status.code() == absl::StatusCode::kUnknown ? absl::StatusCode::kInternal : status.code();
  // gRPC's codes are the canonical ones, number by number.
  return {static_cast<grpc::StatusCode>(code), std::string(status.message().data(), status.message().size())};
}

storage::CallContext ContextOf(const grpc::CallbackServerContext& call, std::chrono::duration<double> otherwise) {
  using std::chrono::steady_clock;
  using std::chrono::system_clock;
  const auto fallback = std::chrono::duration_cast<steady_clock::duration>(otherwise);
  // A call without deadline reports one beyond all times.
  const auto until = call.deadline();
  const auto now = system_clock::now();
  storage::CallContext context = until > now + std::chrono::hours(24)
                                     ? storage::CallContext::WithTimeout(fallback)
                                     : storage::CallContext::WithTimeout(std::max<steady_clock::duration>(
                                           until - now, steady_clock::duration::zero()));
  const auto actor = call.client_metadata().find(kActorKey);
  if (actor != call.client_metadata().end()) {
    context.actor = std::string(actor->second.data(), std::min(actor->second.size(), kMaxActorBytes));
  }
  return context;
}

}  // namespace enfilade::server

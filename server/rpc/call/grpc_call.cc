// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/grpc_call.h"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/app/runtime/retry_hint.h"
#include "server/rpc/call/request_id.h"
#include "server/rpc/call/status.h"

namespace enfilade::server {
namespace {

constexpr char kActorKey[] = "enfilade-actor";
constexpr char kRequestIdKey[] = "x-request-id";
constexpr char kGraphVersionKey[] = "enfilade-graph-version";
constexpr char kRetryPushbackKey[] = "grpc-retry-pushback-ms";
constexpr char kMinGraphVersionKey[] = "enfilade-min-graph-version";

std::string_view MetadataOf(const grpc::CallbackServerContext& context, const char* key) {
  const auto found = context.client_metadata().find(key);
  if (found == context.client_metadata().end()) return {};
  return {found->second.data(), found->second.size()};
}

std::vector<std::string> AllMetadataOf(const grpc::CallbackServerContext& context, const char* key) {
  std::vector<std::string> values;
  const auto [begin, end] = context.client_metadata().equal_range(key);
  for (auto found = begin; found != end; ++found) values.emplace_back(found->second.data(), found->second.size());
  return values;
}

// Of a client that the handshake has authenticated: the first SPIFFE id, else DNS name or common name of its
// certificate, as gRPC chooses.
std::string CertificateNameOf(const grpc::CallbackServerContext& context) {
  const auto auth = context.auth_context();
  if (auth == nullptr || !auth->IsPeerAuthenticated()) return {};
  const std::vector<grpc::string_ref> spiffe = auth->FindPropertyValues("peer_spiffe_id");
  const std::vector<grpc::string_ref> names = spiffe.empty() ? auth->GetPeerIdentity() : spiffe;
  return names.empty() ? std::string() : std::string(names.front().data(), names.front().size());
}

// A call without a deadline reports one far beyond all times.
std::optional<std::chrono::steady_clock::time_point> DeadlineOf(const grpc::CallbackServerContext& context) {
  const auto left = context.deadline() - std::chrono::system_clock::now();
  if (left > std::chrono::hours(24)) return std::nullopt;
  return std::chrono::steady_clock::now() + left;
}

}  // namespace

IncomingCall ReadIncomingCall(const CallEntry& entry) {
  return {.rpc = entry.rpc,
          .peer = entry.context.peer(),
          .request_id = MetadataOf(entry.context, kRequestIdKey),
          .actor = MetadataOf(entry.context, kActorKey),
          .min_graph_versions = AllMetadataOf(entry.context, kMinGraphVersionKey),
          .deadline = DeadlineOf(entry.context)};
}

Call BeginCall(const CallEntry& entry) {
  IncomingCall incoming = ReadIncomingCall(entry);
  const std::string request_id = RequestIdOrNew(incoming.request_id);
  incoming.request_id = request_id;
  const std::string certificate = CertificateNameOf(entry.context);
  incoming.certificate = certificate;
  entry.context.AddInitialMetadata(kRequestIdKey, request_id);
  return Call(entry.environment, incoming);
}

grpc::Status FinishCall(const Call& call, grpc::CallbackServerContext& context, const absl::Status& status) {
  call.Finish(status);
  if (const auto after = RetryHintOf(status)) {
    context.AddTrailingMetadata(kRetryPushbackKey, std::to_string(after->count()));
  }
  return ToGrpcStatus(status);
}

void TellGraphVersion(grpc::CallbackServerContext& context, const std::string& site, std::int64_t version) {
  context.AddTrailingMetadata(kGraphVersionKey, "sites/" + site + "=" + std::to_string(version));
}

}  // namespace enfilade::server

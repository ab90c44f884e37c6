// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "client/sdk/credentials.h"
#include "client/sdk/graph_versions.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace enfilade::client {

// A channel to the server at host:port or unix:/path, with keepalive (a dead connection is noticed within 20 s) and for
// messages of up to 66 MiB. It connects when first used, and reconnects.
std::shared_ptr<grpc::Channel> Connect(const std::string& address, const Credentials& credentials = {});

// The same code and message. UNAVAILABLE: the message names `address`.
absl::Status FromGrpcStatus(const grpc::Status& status, const std::string& address = "");

// How one client calls: its channel, the deadline of a call, and the actor. It reads its own changes of graphs, also if
// several servers answer at its address. Copyable, thread-safe.
class Connection {
 public:
  // `timeout`: of a unary call. `actor`: for the audit trail; characters that are not printable ASCII are sent as "?".
  Connection(std::string address, std::chrono::duration<double> timeout, const std::string& actor = "",
             Credentials credentials = {});

  const std::string& address() const { return address_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // A unary call: connection.Call(&v1::SiteService::Stub::GetSite, request). Sets deadline and actor.
  template <typename Service, typename Request, typename Response>
  absl::StatusOr<Response> Call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                                const Request& request) const {
    Service stub(channel_);
    grpc::ClientContext context;
    SetDeadline(context);
    SetActor(context);
    SetMinGraphVersions(context);
    Response response;
    const grpc::Status status = (stub.*method)(&context, request, &response);
    if (status.ok()) graph_versions_->Note(context);
    if (!status.ok()) return FromGrpcStatus(status, address_);
    return response;
  }

  // For streams, some of which have no deadline.
  void SetDeadline(grpc::ClientContext& context) const {
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::duration_cast<std::chrono::system_clock::duration>(timeout_));
  }
  void SetActor(grpc::ClientContext& context) const {
    if (!actor_.empty()) context.AddMetadata("enfilade-actor", actor_);
  }

  // For streams that answer from graphs: what this client has changed is in the answer, whichever server gives it.
  void SetMinGraphVersions(grpc::ClientContext& context) const { graph_versions_->Send(context); }

  // Another server of the same service, for the same client: what it has changed through one it sees through the other.
  Connection To(std::string address) const;

 private:
  std::string address_;
  std::chrono::duration<double> timeout_;
  std::string actor_;
  Credentials credentials_;
  std::shared_ptr<grpc::Channel> channel_;
  std::shared_ptr<GraphVersions> graph_versions_ = std::make_shared<GraphVersions>();
};

}  // namespace enfilade::client

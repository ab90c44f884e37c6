// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "grpcpp/channel.h"
#include "grpcpp/client_context.h"
#include "grpcpp/support/status.h"

namespace enfilade::client {

// A channel to the server at host:port or unix:/path, with keepalive, so that a dead connection is noticed within 20 s,
// and room for messages of 66 MiB. Connects when first used, and again by itself.
std::shared_ptr<grpc::Channel> Connect(const std::string& address);

// The same code and message; where the server could not be reached the message names `address`.
absl::Status FromGrpcStatus(const grpc::Status& status, const std::string& address = "");

// Calls of one client: its channel, how long a unary call may take, and in whose name it is made. Copyable,
// thread-safe.
class Connection {
 public:
  // `actor`: for the audit trail; anything but printable ASCII in it is sent as "?".
  Connection(std::string address, std::chrono::duration<double> timeout, const std::string& actor = "");

  const std::string& address() const { return address_; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  // connection.Call(&v1::SiteService::Stub::GetSite, request), with the service's stub made for the call.
  template <typename Service, typename Request, typename Response>
  absl::StatusOr<Response> Call(grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
                                const Request& request) const {
    Service stub(channel_);
    grpc::ClientContext context;
    SetDeadline(context);
    SetActor(context);
    Response response;
    const grpc::Status status = (stub.*method)(&context, request, &response);
    if (!status.ok()) return FromGrpcStatus(status, address_);
    return response;
  }

  void SetDeadline(grpc::ClientContext& context) const {
    context.set_deadline(std::chrono::system_clock::now() +
                         std::chrono::duration_cast<std::chrono::system_clock::duration>(timeout_));
  }

  // Call does both; streams decide for themselves.
  void SetActor(grpc::ClientContext& context) const {
    if (!actor_.empty()) context.AddMetadata("enfilade-actor", actor_);
  }

 private:
  std::string address_;
  std::chrono::duration<double> timeout_;
  std::string actor_;
  std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace enfilade::client

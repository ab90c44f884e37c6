// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/connection.h"

#include <algorithm>

#include "core/base/error.h"
#include "grpcpp/create_channel.h"
#include "grpcpp/security/credentials.h"
#include "grpcpp/support/channel_arguments.h"

namespace enfilade::client {

std::shared_ptr<grpc::Channel> Connect(const std::string& address, const Credentials& credentials) {
  constexpr int kMaxMessageBytes = 66 << 20;
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 200);
  // In spite of its name this is how long an attempt to connect may take: a busy server or a slow network needs time.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 10'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 5'000);
  return grpc::CreateCustomChannel(address, credentials.For(address), arguments);
}

Connection::Connection(std::string address, std::chrono::duration<double> timeout, const std::string& actor,
                       Credentials credentials)
    : address_(std::move(address)),
      timeout_(timeout),
      actor_(actor),
      credentials_(std::move(credentials)),
      channel_(Connect(address_, credentials_)) {
  // What gRPC allows in a metadata value.
  std::replace_if(
      actor_.begin(), actor_.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
}

Connection Connection::To(std::string address) const {
  Connection other = *this;
  other.channel_ = Connect(address, credentials_);
  other.address_ = std::move(address);
  return other;
}

absl::Status FromGrpcStatus(const grpc::Status& status, const std::string& address) {
  if (status.ok()) return absl::OkStatus();
  const auto code = static_cast<absl::StatusCode>(status.error_code());
  if (code == absl::StatusCode::kUnavailable && !address.empty()) {
    return Unavailable("the server at {} cannot be reached or is not ready ({})", address, status.error_message());
  }
  return absl::Status(code, status.error_message());
}

}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/status.h"

#include <cstddef>

#include "fmt/format.h"

namespace enfilade::server {

namespace {

// gRPC sends a message as metadata, of which clients accept 8 KiB; bytes beyond ASCII are sent as three.
constexpr std::size_t kMaxMessageBytes = 2000;

bool ContinuesCharacter(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

}  // namespace

std::string BoundedMessage(const absl::Status& status) {
  std::string message(status.message().data(), status.message().size());
  if (message.size() <= kMaxMessageBytes) return message;
  const std::size_t whole = message.size();
  std::size_t cut = kMaxMessageBytes;
  while (cut > 0 && ContinuesCharacter(message[cut])) --cut;
  message.resize(cut);
  return fmt::format("{}... ({} bytes)", message, whole);
}

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const auto code = status.code() == absl::StatusCode::kUnknown ? absl::StatusCode::kInternal : status.code();
  // gRPC's codes are the canonical ones, number by number.
  return {static_cast<grpc::StatusCode>(code), BoundedMessage(status)};
}

}  // namespace enfilade::server

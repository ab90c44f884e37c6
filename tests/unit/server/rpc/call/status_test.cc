// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/call/status.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "server/rpc/call/principal.h"

namespace enfilade::server {
namespace {

TEST(ToGrpcStatus, KeepsTheCodeByNameAndTheMessage) {
  const std::pair<absl::StatusCode, grpc::StatusCode> codes[] = {
      {absl::StatusCode::kCancelled, grpc::StatusCode::CANCELLED},
      {absl::StatusCode::kInvalidArgument, grpc::StatusCode::INVALID_ARGUMENT},
      {absl::StatusCode::kDeadlineExceeded, grpc::StatusCode::DEADLINE_EXCEEDED},
      {absl::StatusCode::kNotFound, grpc::StatusCode::NOT_FOUND},
      {absl::StatusCode::kAlreadyExists, grpc::StatusCode::ALREADY_EXISTS},
      {absl::StatusCode::kPermissionDenied, grpc::StatusCode::PERMISSION_DENIED},
      {absl::StatusCode::kResourceExhausted, grpc::StatusCode::RESOURCE_EXHAUSTED},
      {absl::StatusCode::kFailedPrecondition, grpc::StatusCode::FAILED_PRECONDITION},
      {absl::StatusCode::kAborted, grpc::StatusCode::ABORTED},
      {absl::StatusCode::kOutOfRange, grpc::StatusCode::OUT_OF_RANGE},
      {absl::StatusCode::kUnimplemented, grpc::StatusCode::UNIMPLEMENTED},
      {absl::StatusCode::kInternal, grpc::StatusCode::INTERNAL},
      {absl::StatusCode::kUnavailable, grpc::StatusCode::UNAVAILABLE},
      {absl::StatusCode::kDataLoss, grpc::StatusCode::DATA_LOSS},
      {absl::StatusCode::kUnauthenticated, grpc::StatusCode::UNAUTHENTICATED},
  };
  for (const auto& [code, expected] : codes) {
    const grpc::Status status = ToGrpcStatus(absl::Status(code, "why \xC3\xA9"));
    EXPECT_EQ(status.error_code(), expected) << absl::StatusCodeToString(code);
    EXPECT_EQ(status.error_message(), "why \xC3\xA9");
  }
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
}

TEST(ToGrpcStatus, CallsAnUnclassifiedErrorInternal) {
  const grpc::Status status = ToGrpcStatus(absl::UnknownError("what was that"));
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INTERNAL);
  EXPECT_EQ(status.error_message(), "what was that");
}

// Longer ones do not fit into the metadata of a response: the client would see another error, and other calls of its
// connection, too.
TEST(ToGrpcStatus, CutsAMessageThatQuotesTooMuch) {
  std::string quoted;
  for (int i = 0; i < 200'000; ++i) quoted += "\xC3\xA9";
  const std::string message = ToGrpcStatus(absl::InvalidArgumentError("token " + quoted)).error_message();
  EXPECT_LE(message.size(), 2100U);
  EXPECT_EQ(message.substr(0, 8), "token \xC3\xA9");
  EXPECT_EQ(message.substr(message.find('.')), "... (400006 bytes)");
  EXPECT_EQ(message.find('.') % 2, 0U) << "a character is cut in two";
  EXPECT_EQ(ToGrpcStatus(absl::InvalidArgumentError(std::string(2000, 'a'))).error_message(), std::string(2000, 'a'));
}

TEST(Principal, IsWhatTheCallerSaysAndBounded) {
  EXPECT_EQ(IdentifyPrincipal("", "ann").name, "ann");
  EXPECT_FALSE(IdentifyPrincipal("", "ann").authenticated);
  EXPECT_EQ(IdentifyPrincipal("", "").name, "");
  EXPECT_EQ(IdentifyPrincipal("", std::string(200, 'a')).name.size(), 200U);
  EXPECT_EQ(IdentifyPrincipal("", std::string(100'000, 'a')).name.size(), 200U);
  EXPECT_EQ(IdentifyPrincipal("robot-7", "").name, "robot-7");
  EXPECT_EQ(IdentifyPrincipal("robot-7", "robot-7").name, "robot-7");
  EXPECT_EQ(IdentifyPrincipal("robot-7", "root").name, "robot-7 (says: root)");
  EXPECT_TRUE(IdentifyPrincipal("robot-7", "root").authenticated);
  EXPECT_EQ(IdentifyPrincipal("robot-7", std::string(1000, 'a')).name.size(), 200U);
}

}  // namespace
}  // namespace enfilade::server

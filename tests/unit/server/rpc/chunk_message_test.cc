// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/chunk_message.h"

#include <algorithm>
#include <string>

#include "enfilade/v1/map_service.grpc.pb.h"
#include "gtest/gtest.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

v1::ExportMapResponse Decode(grpc::ByteBuffer bytes) {
  v1::ExportMapResponse message;
  EXPECT_TRUE(grpc::SerializationTraits<v1::ExportMapResponse>::Deserialize(&bytes, &message).ok());
  return message;
}

// Sizes and offsets on both sides of where varints grow by a byte.
class EncodeChunkMessageTest : public ::testing::TestWithParam<std::size_t> {};

TEST_P(EncodeChunkMessageTest, IsReadBackAsTheMessage) {
  std::string data(GetParam(), '\0');
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<char>(i * 31 % 251);
  const std::int64_t offset = std::int64_t{1} << 40;
  const auto encoded = EncodeChunkMessage(3, offset, data.size(), [&](char* out) {
    std::copy(data.begin(), data.end(), out);
    return absl::OkStatus();
  });
  ASSERT_OK(encoded);
  const v1::ExportMapResponse message = Decode(*encoded);
  ASSERT_TRUE(message.has_chunk());
  EXPECT_EQ(message.chunk().file(), 3);
  EXPECT_EQ(message.chunk().offset(), offset);
  EXPECT_EQ(message.chunk().data(), data);
}

INSTANTIATE_TEST_SUITE_P(Sizes, EncodeChunkMessageTest,
                         ::testing::Values(0, 1, 127, 128, 16383, 16384, (1U << 20) - 1, 1U << 20));

TEST(EncodeChunkMessage, GivesTheFillersError) {
  const auto encoded =
      EncodeChunkMessage(0, 0, 10, [](char*) { return absl::DataLossError("the file has become shorter"); });
  EXPECT_EQ(encoded.status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/ingest/batch.h"

#include <gtest/gtest.h>

#include "core/base/sha256.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

v1::BlobChunk Chunk(const std::string& whole, std::size_t offset, std::size_t size) {
  v1::BlobChunk chunk;
  chunk.mutable_blob()->set_sha256(Sha256(whole));
  chunk.mutable_blob()->set_size_bytes(static_cast<std::int64_t>(whole.size()));
  chunk.set_offset(static_cast<std::int64_t>(offset));
  chunk.set_data(whole.substr(offset, size));
  return chunk;
}

TEST(BlobAssembly, PutsBlobsTogetherOneAfterTheOther) {
  BlobAssembly assembly;
  for (const std::string whole : {"abcdef", "x", "abcdef"}) {
    for (std::size_t offset = 0; offset < whole.size(); offset += 4) {
      const absl::StatusOr<bool> complete = assembly.Add(Chunk(whole, offset, 4));
      ASSERT_OK(complete);
      EXPECT_EQ(*complete, offset + 4 >= whole.size());
    }
    EXPECT_EQ(assembly.Take().data, whole);
  }
}

TEST(BlobAssembly, RefusesChunksThatDoNotFollow) {
  const std::string whole = "abcdef";
  EXPECT_CODE(BlobAssembly().Add(Chunk(whole, 2, 2)), absl::StatusCode::kInvalidArgument) << "not the first";
  BlobAssembly gap;
  ASSERT_OK(gap.Add(Chunk(whole, 0, 2)));
  EXPECT_CODE(gap.Add(Chunk(whole, 4, 2)), absl::StatusCode::kInvalidArgument);
  BlobAssembly other;
  ASSERT_OK(other.Add(Chunk(whole, 0, 2)));
  EXPECT_CODE(other.Add(Chunk("ABcdef", 2, 2)), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk empty = Chunk(whole, 0, 2);
  empty.clear_data();
  EXPECT_CODE(BlobAssembly().Add(empty), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk long_chunk = Chunk(whole, 0, 6);
  long_chunk.mutable_blob()->set_size_bytes(3);
  EXPECT_CODE(BlobAssembly().Add(long_chunk), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk lying = Chunk(whole, 0, 6);
  lying.mutable_blob()->set_sha256(std::string(32, 'x'));
  EXPECT_CODE(BlobAssembly().Add(lying), absl::StatusCode::kDataLoss);
}

TEST(ReadBatch, IsBoundedInRecordsAndBytes) {
  v1::RecordBatch many;
  for (int i = 0; i <= kMaxBatchRecords; ++i) many.add_records()->set_sequence(i + 1);
  EXPECT_TRUE(std::holds_alternative<Refusal>(ReadBatch(many)));
  v1::RecordBatch heavy;
  for (int i = 0; i < 2; ++i) {
    v1::Record& record = *heavy.add_records();
    record.set_sequence(i + 1);
    record.mutable_withheld()->set_reason(std::string(3 << 20, 'x'));
  }
  EXPECT_TRUE(std::holds_alternative<Refusal>(ReadBatch(heavy)));
}

}  // namespace
}  // namespace enfilade::server

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

UploadSpace blob_space({.directory = ::testing::TempDir(), .memory_bytes = 1 << 20, .disk_bytes = 1 << 20});

TEST(BlobAssembly, PutsBlobsTogetherOneAfterTheOther) {
  BlobAssembly assembly(blob_space);
  for (const std::string whole : {"abcdef", "x", "abcdef"}) {
    for (std::size_t offset = 0; offset < whole.size(); offset += 4) {
      const absl::StatusOr<bool> complete = assembly.Add(Chunk(whole, offset, 4));
      ASSERT_OK(complete);
      EXPECT_EQ(*complete, offset + 4 >= whole.size());
    }
    EXPECT_EQ(*assembly.Take().data.Take(), whole);
  }
}

TEST(BlobAssembly, RefusesChunksThatDoNotFollow) {
  const std::string whole = "abcdef";
  EXPECT_CODE(BlobAssembly(blob_space).Add(Chunk(whole, 2, 2)), absl::StatusCode::kInvalidArgument) << "not the first";
  BlobAssembly gap(blob_space);
  ASSERT_OK(gap.Add(Chunk(whole, 0, 2)));
  EXPECT_CODE(gap.Add(Chunk(whole, 4, 2)), absl::StatusCode::kInvalidArgument);
  BlobAssembly other(blob_space);
  ASSERT_OK(other.Add(Chunk(whole, 0, 2)));
  EXPECT_CODE(other.Add(Chunk("ABcdef", 2, 2)), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk empty = Chunk(whole, 0, 2);
  empty.clear_data();
  EXPECT_CODE(BlobAssembly(blob_space).Add(empty), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk long_chunk = Chunk(whole, 0, 6);
  long_chunk.mutable_blob()->set_size_bytes(3);
  EXPECT_CODE(BlobAssembly(blob_space).Add(long_chunk), absl::StatusCode::kInvalidArgument);
  v1::BlobChunk lying = Chunk(whole, 0, 6);
  lying.mutable_blob()->set_sha256(std::string(32, 'x'));
  EXPECT_CODE(BlobAssembly(blob_space).Add(lying), absl::StatusCode::kDataLoss);
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

v1::RecordBatch OdometryBatch(std::int64_t first, int count) {
  v1::RecordBatch batch;
  for (int i = 0; i < count; ++i) {
    v1::Record& record = *batch.add_records();
    record.set_sequence(first + i);
    record.mutable_odometry()->mutable_time()->set_seconds(1'700'000'000 + i);
    record.mutable_odometry()->mutable_pose_odom_robot()->set_x(i);
  }
  return batch;
}

TEST(ReadBatch, KeepsOrderAndContent) {
  const IngestItem item = ReadBatch(OdometryBatch(41, 3));
  const auto* batch = std::get_if<IngestBatch>(&item);
  ASSERT_NE(batch, nullptr);
  ASSERT_EQ(batch->records.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(batch->records[i].sequence, 41 + i);
    EXPECT_EQ(std::get<sensor::Odometry>(batch->records[i].payload).T_odom_robot.x, i);
  }
}

TEST(ReadBatch, TakesABatchOfTheGreatestSize) {
  EXPECT_TRUE(std::holds_alternative<IngestBatch>(ReadBatch(OdometryBatch(1, kMaxBatchRecords))));
}

TEST(ReadBatch, NamesTheRecordAtFaultAndTheBatchesFirst) {
  struct Case {
    const char* message;
    std::int64_t sequence;
    Refusal::Reason reason;
    void (*change)(v1::RecordBatch&);
  };
  using Reason = Refusal::Reason;
  for (const Case& test : {
           Case{"sequences must increase by one from 5", 0, Reason::kInvalidBatch,
                [](v1::RecordBatch& b) { b.mutable_records(2)->set_sequence(9); }},
           Case{"sequences must increase by one from 5", 0, Reason::kInvalidBatch,
                [](v1::RecordBatch& b) { b.mutable_records(2)->set_sequence(6); }},
           Case{"record 6: payload is not set", 6, Reason::kInvalidRecord,
                [](v1::RecordBatch& b) { b.mutable_records(1)->clear_payload(); }},
           Case{"record 7: odometry.pose_odom_robot is not set", 7, Reason::kInvalidRecord,
                [](v1::RecordBatch& b) { b.mutable_records(2)->mutable_odometry()->clear_pose_odom_robot(); }},
       }) {
    v1::RecordBatch batch = OdometryBatch(5, 3);
    test.change(batch);
    const IngestItem item = ReadBatch(batch);
    const auto* refusal = std::get_if<Refusal>(&item);
    ASSERT_NE(refusal, nullptr) << test.message;
    EXPECT_EQ(refusal->first_sequence, 5);
    EXPECT_EQ(refusal->sequence, test.sequence);
    EXPECT_EQ(refusal->reason, test.reason);
    EXPECT_THAT(refusal->message, ::testing::HasSubstr(test.message));
  }
  const IngestItem empty = ReadBatch(v1::RecordBatch());
  EXPECT_EQ(std::get<Refusal>(empty).first_sequence, 0);
}

TEST(BlobAssembly, BeginsAnewWithAChunkAtTheStart) {
  BlobAssembly assembly(blob_space);
  ASSERT_OK(assembly.Add(Chunk("abandoned", 0, 3)));
  for (const std::size_t offset : {0, 4}) ASSERT_OK(assembly.Add(Chunk("abcdefgh", offset, 4)));
  EXPECT_EQ(*assembly.Take().data.Take(), "abcdefgh");
}

TEST(BlobAssembly, BoundsDigestSizeAndChunk) {
  struct Case {
    const char* message;
    void (*change)(v1::BlobChunk&);
  };
  for (const Case& test :
       {Case{"SHA-256 of 32 bytes", [](v1::BlobChunk& c) { c.mutable_blob()->set_sha256("short"); }},
        Case{"size of 1", [](v1::BlobChunk& c) { c.mutable_blob()->set_size_bytes(0); }},
        Case{"size of 1", [](v1::BlobChunk& c) { c.mutable_blob()->set_size_bytes(-6); }},
        Case{"size of 1", [](v1::BlobChunk& c) { c.mutable_blob()->set_size_bytes(sensor::kMaxBlobBytes + 1); }},
        Case{"blob_chunk.data", [](v1::BlobChunk& c) { c.set_data(std::string(kMaxChunkBytes + 1, 'x')); }},
        Case{"does not follow", [](v1::BlobChunk& c) { c.set_offset(-1); }}}) {
    v1::BlobChunk chunk = Chunk("abcdef", 0, 6);
    test.change(chunk);
    EXPECT_STATUS(BlobAssembly(blob_space).Add(chunk), absl::StatusCode::kInvalidArgument,
                  ::testing::HasSubstr(test.message));
  }
}

}  // namespace
}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/chunk_message.h"

#include <algorithm>
#include <string>

#include "enfilade/v1/map_service.pb.h"
#include "google/protobuf/io/coded_stream.h"
#include "google/protobuf/wire_format_lite.h"
#include "grpc/slice.h"
#include "grpcpp/support/slice.h"

namespace enfilade::server {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedOutputStream;

// Of a field with a length: its tag and the length.
std::string Prefix(int field, std::size_t length) {
  std::uint8_t buffer[20];
  std::uint8_t* end = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED), buffer);
  end = CodedOutputStream::WriteVarint64ToArray(length, end);
  return {reinterpret_cast<const char*>(buffer), static_cast<std::size_t>(end - buffer)};
}

// All that comes before the chunk's data, which is the last field.
std::string Header(std::int32_t file, std::int64_t offset, std::size_t size) {
  v1::FileChunk chunk;
  chunk.set_file(file);
  chunk.set_offset(offset);
  const std::string fields = chunk.SerializeAsString() + Prefix(v1::FileChunk::kDataFieldNumber, size);
  return Prefix(v1::ExportMapResponse::kChunkFieldNumber, fields.size() + size) + fields;
}

}  // namespace

absl::StatusOr<grpc::ByteBuffer> EncodeChunkMessage(std::int32_t file, std::int64_t offset, std::size_t size,
                                                    const ChunkFiller& fill) {
  const std::string header = Header(file, offset, size);
  grpc_slice bytes = grpc_slice_malloc(header.size() + size);
  auto* const begin = reinterpret_cast<char*>(GRPC_SLICE_START_PTR(bytes));  // inside `bytes` if they are few
  std::copy(header.begin(), header.end(), begin);
  const absl::Status filled = fill(begin + header.size());
  const grpc::Slice owner(bytes, grpc::Slice::STEAL_REF);
  if (!filled.ok()) return filled;
  return grpc::ByteBuffer(&owner, 1);
}

}  // namespace enfilade::server

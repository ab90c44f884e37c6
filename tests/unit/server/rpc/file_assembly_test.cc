// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/file_assembly.h"

#include <gtest/gtest.h>

#include "core/base/sha256.h"
#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

google::protobuf::RepeatedPtrField<v1::FileEntry> Entries(
    const std::vector<std::pair<std::string, std::string>>& files) {
  google::protobuf::RepeatedPtrField<v1::FileEntry> entries;
  for (const auto& [name, bytes] : files) {
    v1::FileEntry& entry = *entries.Add();
    entry.set_name(name);
    entry.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
    entry.set_sha256(Sha256(bytes));
  }
  return entries;
}

v1::FileChunk Chunk(int file, std::int64_t offset, const std::string& data) {
  v1::FileChunk chunk;
  chunk.set_file(file);
  chunk.set_offset(offset);
  chunk.set_data(data);
  return chunk;
}

TEST(FileAssembly, PutsFilesTogether) {
  FileAssembly assembly;
  ASSERT_OK(assembly.Begin(Entries({{"a.yaml", "hello"}, {"a.pgm", "wo"}}), 100));
  ASSERT_OK(assembly.Add(Chunk(0, 0, "hel")));
  ASSERT_OK(assembly.Add(Chunk(0, 3, "lo")));
  ASSERT_OK(assembly.Add(Chunk(1, 0, "wo")));
  ASSERT_OK_AND_ASSIGN(const std::vector<grid::MapFile> files, assembly.Finish());
  EXPECT_EQ(files[0].bytes, "hello");
  EXPECT_EQ(files[1].name, "a.pgm");
}

TEST(FileAssembly, RefusesTooMuchAndWhatDoesNotFollow) {
  EXPECT_STATUS(FileAssembly().Begin(Entries({{"a", std::string(60, 'x')}, {"b", std::string(60, 'x')}}), 100),
                absl::StatusCode::kInvalidArgument, HasSubstr("\"b\""));
  EXPECT_FALSE(FileAssembly().Begin({}, 100).ok());
  FileAssembly assembly;
  ASSERT_OK(assembly.Begin(Entries({{"a", "hello"}}), 100));
  EXPECT_FALSE(assembly.Add(Chunk(0, 1, "h")).ok());
  EXPECT_FALSE(assembly.Add(Chunk(1, 0, "h")).ok());
  EXPECT_FALSE(assembly.Add(Chunk(0, 0, "hello world")).ok());
  ASSERT_OK(assembly.Add(Chunk(0, 0, "hell")));
  EXPECT_STATUS(assembly.Finish(), absl::StatusCode::kInvalidArgument, HasSubstr("4 of 5"));
  ASSERT_OK(assembly.Add(Chunk(0, 4, "x")));
  EXPECT_STATUS(assembly.Finish(), absl::StatusCode::kDataLoss, HasSubstr("\"a\""));
  EXPECT_FALSE(assembly.Add(Chunk(0, 5, "x")).ok()) << "all files are complete";
}

}  // namespace
}  // namespace enfilade::server

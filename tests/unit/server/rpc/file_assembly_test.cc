// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/map/file_assembly.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

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

UploadSpace file_space({.directory = ::testing::TempDir(), .memory_bytes = 1 << 20, .disk_bytes = 1 << 20});

TEST(FileAssembly, PutsFilesTogether) {
  FileAssembly assembly(file_space);
  ASSERT_OK(assembly.Begin(Entries({{"a.yaml", "hello"}, {"a.pgm", "wo"}}), 100));
  ASSERT_OK(assembly.Add(Chunk(0, 0, "hel")));
  ASSERT_OK(assembly.Add(Chunk(0, 3, "lo")));
  ASSERT_OK(assembly.Add(Chunk(1, 0, "wo")));
  ASSERT_OK_AND_ASSIGN(const std::vector<grid::MapFile> files, assembly.Finish());
  EXPECT_EQ(files[0].bytes, "hello");
  EXPECT_EQ(files[1].name, "a.pgm");
}

TEST(FileAssembly, RefusesTooMuchAndWhatDoesNotFollow) {
  EXPECT_STATUS(
      FileAssembly(file_space).Begin(Entries({{"a", std::string(60, 'x')}, {"b", std::string(60, 'x')}}), 100),
      absl::StatusCode::kInvalidArgument, HasSubstr("\"b\""));
  EXPECT_FALSE(FileAssembly(file_space).Begin({}, 100).ok());
  FileAssembly assembly(file_space);
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

// However files are cut into chunks, the same files come out.
TEST(FileAssembly, IsIndifferentToTheSizeOfChunks) {
  const std::vector<std::pair<std::string, std::string>> given = {
      {"a.yaml", "0123456789"}, {"b", "x"}, {"c.pgm", std::string(1000, 'p')}};
  for (std::size_t size = 1; size <= 11; ++size) {
    FileAssembly assembly(file_space);
    ASSERT_OK(assembly.Begin(Entries(given), 2000));
    for (std::size_t file = 0; file < given.size(); ++file) {
      const std::string& bytes = given[file].second;
      for (std::size_t offset = 0; offset < bytes.size(); offset += size) {
        ASSERT_OK(
            assembly.Add(Chunk(static_cast<int>(file), static_cast<std::int64_t>(offset), bytes.substr(offset, size))));
      }
    }
    ASSERT_OK_AND_ASSIGN(const std::vector<grid::MapFile> files, assembly.Finish());
    ASSERT_EQ(files.size(), given.size());
    for (std::size_t file = 0; file < given.size(); ++file) {
      EXPECT_EQ(files[file].name, given[file].first);
      EXPECT_EQ(files[file].bytes, given[file].second);
    }
  }
}

TEST(FileAssembly, BoundsTheManifest) {
  std::vector<std::pair<std::string, std::string>> files = {{"a", "1"}, {"b", "2"}, {"c", "3"}, {"d", "4"}};
  EXPECT_OK(FileAssembly(file_space).Begin(Entries(files), 4)) << "exactly as much as allowed";
  EXPECT_STATUS(FileAssembly(file_space).Begin(Entries(files), 3), absl::StatusCode::kInvalidArgument,
                HasSubstr("\"d\""));
  files.emplace_back("e", "5");
  EXPECT_STATUS(FileAssembly(file_space).Begin(Entries(files), 100), absl::StatusCode::kInvalidArgument,
                HasSubstr("5 entries"));
  auto entries = Entries({{"a", "1"}});
  entries[0].set_sha256("short");
  EXPECT_STATUS(FileAssembly(file_space).Begin(entries, 100), absl::StatusCode::kInvalidArgument, HasSubstr("sha256"));
  entries = Entries({{"a", "1"}, {"b", "2"}});
  entries[1].set_size_bytes(-5);
  EXPECT_STATUS(FileAssembly(file_space).Begin(entries, 100), absl::StatusCode::kInvalidArgument, HasSubstr("\"b\""));
  entries[1].set_size_bytes(std::numeric_limits<std::int64_t>::max());
  EXPECT_STATUS(FileAssembly(file_space).Begin(entries, 100), absl::StatusCode::kInvalidArgument, HasSubstr("\"b\""))
      << "the sum must not overflow";
}

TEST(FileAssembly, NeedsItsManifestFirst) {
  FileAssembly assembly(file_space);
  EXPECT_CODE(assembly.Add(Chunk(0, 0, "x")), absl::StatusCode::kInvalidArgument);
  EXPECT_STATUS(assembly.Finish(), absl::StatusCode::kInvalidArgument, HasSubstr("manifest"));
}

}  // namespace
}  // namespace enfilade::server

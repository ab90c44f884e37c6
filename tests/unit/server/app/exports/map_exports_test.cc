// SPDX-License-Identifier: Apache-2.0
#include "server/app/exports/map_exports.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <thread>
#include <vector>

#include "core/base/sha256.h"
#include "server/app/mapping/raster_revision.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string ReadAll(const ExportedFile& file) {
  std::string bytes(static_cast<std::size_t>(file.size), '\0');
  EXPECT_OK(file.content->Read(0, bytes.size(), bytes.data()));
  return bytes;
}

class MapExportsTest : public ::testing::Test {
 protected:
  MapExportsTest() {
    stores_.database.AddSite(site_);
    options_.cache_directory = directory_.path();
    NewMap("hall");
  }

  void NewMap(const std::string& id) { EXPECT_OK(stores_.maps.Create(Soon(), MakeMap(site_, id), "")); }
  void Start() {
    auto exports = MapExports::Create(options_, stores_.maps, {stores_.blobs, stores_.revisions});
    ASSERT_OK(exports);
    exports_ = *std::move(exports);
  }
  // A raster of 40 x 30 cells that differs by `value`.
  void Import(const std::string& map, std::uint8_t value) {
    grid::OccupancyGrid grid;
    grid.geometry.width = 40;
    grid.geometry.height = 30;
    grid.geometry.resolution = 0.05;
    grid.cells.assign(40 * 30, 1);
    grid.cells[0] = value;
    auto raster = ToRevision(grid::FromOccupancyGrid(grid));
    ASSERT_OK(raster);
    ASSERT_OK(PutTiles(Soon(), stores_.blobs, site_, *raster, {}));
    raster->revision.source = storage::RevisionSource::kImport;
    ASSERT_OK(stores_.revisions.Add(Soon(), site_, MapId(map), raster->revision, {}));
  }
  absl::StatusOr<ExportedMap> Export(const std::string& map, std::int64_t revision = 0,
                                     grid::MapFileFormat format = grid::MapFileFormat::kPgm) {
    std::promise<absl::StatusOr<ExportedMap>> exported;
    exports_->Get(Soon(), {{site_, MapId(map), revision}, format},
                  [&](absl::StatusOr<ExportedMap> given) { exported.set_value(std::move(given)); });
    return exported.get_future().get();
  }
  std::vector<fs::path> OwnFolders() const {
    std::vector<fs::path> folders;
    for (const auto& entry : fs::directory_iterator(directory_.path())) {
      if (entry.path().filename().string().starts_with("enfilade-cache-")) folders.push_back(entry.path());
    }
    return folders;
  }
  std::size_t CountFiles() const {
    std::size_t files = 0;
    for (const fs::path& folder : OwnFolders()) {
      files += static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    return files;
  }

  const SiteId site_{"campus"};
  testing::InMemoryStores stores_;
  const testing::TemporaryDirectory directory_;
  ServerOptions::Transfers options_;
  std::unique_ptr<MapExports> exports_;
};

TEST_F(MapExportsTest, RendersTheCurrentOrAnOlderRevision) {
  Start();
  Import("hall", 100);
  Import("hall", 50);
  ASSERT_OK_AND_ASSIGN(const ExportedMap current, Export("hall"));
  EXPECT_EQ(current.revision.number, 2);
  std::vector<std::string> names;
  for (const ExportedFile& file : current.files) {
    names.push_back(file.name);
    EXPECT_EQ(Sha256(ReadAll(file)), file.sha256);
  }
  EXPECT_THAT(names, ::testing::UnorderedElementsAre("Room-hall.pgm", "Room-hall.yaml"));
  ASSERT_OK_AND_ASSIGN(const ExportedMap first, Export("hall", 1));
  EXPECT_EQ(first.revision.number, 1);
  EXPECT_NE(first.files[0].sha256, current.files[0].sha256);
  ASSERT_OK_AND_ASSIGN(const ExportedMap json, Export("hall", 2, grid::MapFileFormat::kJson));
  ASSERT_EQ(json.files.size(), 1U);
  EXPECT_EQ(json.files[0].name, "Room-hall.json");
}

TEST_F(MapExportsTest, Errors) {
  Start();
  EXPECT_CODE(Export("nowhere"), absl::StatusCode::kNotFound);
  EXPECT_STATUS(Export("hall"), absl::StatusCode::kFailedPrecondition, HasSubstr("Room hall"));
  EXPECT_CODE(Export("hall", 1), absl::StatusCode::kNotFound);
}

TEST_F(MapExportsTest, ASecondDownloadIsNotRenderedAgain) {
  Start();
  Import("hall", 100);
  ASSERT_OK_AND_ASSIGN(const ExportedMap first, Export("hall"));
  ASSERT_OK_AND_ASSIGN(const ExportedMap second, Export("hall"));
  ASSERT_EQ(second.files.size(), first.files.size());
  for (std::size_t i = 0; i < first.files.size(); ++i) EXPECT_EQ(second.files[i].content, first.files[i].content);
  EXPECT_EQ(CountFiles(), 2U);
}

TEST_F(MapExportsTest, EqualContentIsRenderedOnceAndKeepsItsOwnRevision) {
  Start();
  Import("hall", 100);
  Import("hall", 50);
  Import("hall", 100);  // as revision 1
  ASSERT_OK_AND_ASSIGN(const ExportedMap first, Export("hall", 1));
  ASSERT_OK_AND_ASSIGN(const ExportedMap third, Export("hall", 3));
  EXPECT_EQ(third.revision.number, 3);
  EXPECT_EQ(third.files[0].content, first.files[0].content);
}

TEST_F(MapExportsTest, ARenamedMapGetsFilesOfItsNewName) {
  Start();
  Import("hall", 100);
  ASSERT_OK(Export("hall"));
  ASSERT_OK_AND_ASSIGN(storage::Map map, stores_.maps.Get(Soon(), site_, MapId("hall")));
  map.display_name = "Lobby";
  ASSERT_OK(stores_.maps.Update(Soon(), map));
  ASSERT_OK_AND_ASSIGN(const ExportedMap renamed, Export("hall"));
  EXPECT_THAT(renamed.files[0].name, HasSubstr("Lobby"));
}

TEST_F(MapExportsTest, TheLeastRecentlyUsedExportsAreRemovedFromAFullCache) {
  options_.cache_bytes = 1;  // only the newest one stays
  Start();
  Import("hall", 100);
  NewMap("room");
  Import("room", 50);
  ASSERT_OK_AND_ASSIGN(ExportedMap hall, Export("hall"));
  const std::string bytes = ReadAll(hall.files[0]);
  EXPECT_EQ(CountFiles(), 2U) << "the newest one stays, even if it is larger than the cache";
  ASSERT_OK(Export("room"));
  EXPECT_EQ(ReadAll(hall.files[0]), bytes) << "a download goes on from a removed export";
  ASSERT_OK_AND_ASSIGN(const ExportedMap again, Export("hall"));
  EXPECT_NE(again.files[0].content, hall.files[0].content);
  EXPECT_EQ(ReadAll(again.files[0]), bytes);
  hall = {};
  EXPECT_EQ(CountFiles(), 2U) << "the files go with the last download";
}

TEST_F(MapExportsTest, UsingAnExportKeepsItInTheCache) {
  Start();
  Import("hall", 100);
  ASSERT_OK_AND_ASSIGN(const ExportedMap hall, Export("hall"));
  std::int64_t size = 0;
  for (const ExportedFile& file : hall.files) size += file.size;
  options_.cache_bytes = 5 * size / 2;  // two of them
  exports_.reset();
  Start();
  NewMap("b");
  Import("b", 50);
  NewMap("c");
  Import("c", 60);
  ASSERT_OK_AND_ASSIGN(const ExportedMap first, Export("hall"));
  ASSERT_OK(Export("b"));
  ASSERT_OK(Export("hall"));  // now b is the least recently used
  ASSERT_OK(Export("c"));
  ASSERT_OK_AND_ASSIGN(const ExportedMap kept, Export("hall"));
  EXPECT_EQ(kept.files[0].content, first.files[0].content);
}

TEST_F(MapExportsTest, TheCacheKeepsNoFileOpen) {
  const auto count_open_files = [] {
    return std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator());
  };
  Start();
  Import("hall", 100);
  ASSERT_OK(Export("hall"));
  const auto before = count_open_files();
  for (int i = 0; i < 50; ++i) {
    const std::string map = "map" + std::to_string(i);
    NewMap(map);
    Import(map, static_cast<std::uint8_t>(i));
    ASSERT_OK_AND_ASSIGN(const ExportedMap exported, Export(map));
    EXPECT_EQ(Sha256(ReadAll(exported.files[0])), exported.files[0].sha256);
  }
  EXPECT_EQ(CountFiles(), 2U * 51U) << "all are in the cache";
  EXPECT_EQ(count_open_files(), before);
}

TEST_F(MapExportsTest, AFailedExportLeavesNoFiles) {
  Start();
  Import("hall", 100);
  // The second file of the export cannot be written.
  fs::create_directory(OwnFolders().at(0) / "1");
  EXPECT_FALSE(Export("hall").ok());
  EXPECT_EQ(CountFiles(), 1U) << "the folder that was in the way";
  EXPECT_OK(Export("hall")) << "the next one";
}

TEST_F(MapExportsTest, AnErrorOfTheStoreIsNotCached) {
  Start();
  Import("hall", 100);
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  EXPECT_CODE(Export("hall"), absl::StatusCode::kUnavailable);
  stores_.database.FailCalls(absl::OkStatus());
  EXPECT_OK(Export("hall"));
}

TEST_F(MapExportsTest, ConcurrentDownloadsShareOneRendering) {
  Start();
  Import("hall", 100);
  std::vector<std::thread> threads;
  std::vector<std::shared_ptr<const RenderedFile>> contents(8);
  for (auto& content : contents) {
    threads.emplace_back([this, &content] {
      const auto exported = Export("hall");
      ASSERT_OK(exported);
      content = exported->files[0].content;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(contents, ::testing::Each(contents[0]));
}

TEST_F(MapExportsTest, RemovesItsFolderAndThoseOfKilledServers) {
  const fs::path killed = directory_.path() / "enfilade-cache-killed";
  const fs::path other = directory_.path() / "somebody-elses";
  for (const fs::path& folder : {killed, other}) {
    fs::create_directories(folder);
    std::ofstream(folder / "0") << "a file";
  }
  Start();
  EXPECT_FALSE(fs::exists(killed));
  EXPECT_TRUE(fs::exists(other / "0"));
  EXPECT_EQ(OwnFolders().size(), 1U);
  exports_.reset();
  EXPECT_THAT(OwnFolders(), IsEmpty());
}

// As in containers, whose processes often have the same id and do not see one another.
TEST_F(MapExportsTest, ServersWithOneProcessIdKeepTheirFolders) {
  Import("hall", 100);
  Start();
  ASSERT_OK_AND_ASSIGN(const ExportedMap before, Export("hall"));
  const auto first = std::move(exports_);
  Start();
  EXPECT_EQ(OwnFolders().size(), 2U);
  EXPECT_EQ(CountFiles(), before.files.size());
  exports_.reset();
  EXPECT_EQ(OwnFolders().size(), 1U);
  EXPECT_EQ(CountFiles(), before.files.size());
}

TEST_F(MapExportsTest, AFolderThatCannotBeCreatedIsNamed) {
  options_.cache_directory = directory_.path() / "file";
  std::ofstream(options_.cache_directory) << "not a folder";
  EXPECT_STATUS(MapExports::Create(options_, stores_.maps, {stores_.blobs, stores_.revisions}),
                absl::StatusCode::kFailedPrecondition, HasSubstr(options_.cache_directory));
}

TEST_F(MapExportsTest, AFileThatIsTooShortIsDataLoss) {
  Start();
  Import("hall", 100);
  ASSERT_OK_AND_ASSIGN(const ExportedMap map, Export("hall"));
  std::string bytes(static_cast<std::size_t>(map.files[0].size) + 1, '\0');
  EXPECT_STATUS(map.files[0].content->Read(0, bytes.size(), bytes.data()), absl::StatusCode::kDataLoss,
                HasSubstr("1 bytes"));
}

}  // namespace
}  // namespace enfilade::server

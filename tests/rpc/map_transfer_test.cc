// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <map>
#include <thread>

#include "core/base/sha256.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;

using Files = std::map<std::string, std::string>;

// Of an upload.
struct Pace {
  std::chrono::milliseconds pause{0};  // before each chunk
  std::size_t chunk = 1U << 20;        // bytes
};

class MapTransferTest : public ServerTest {
 protected:
  absl::StatusOr<v1::MapRevision> Import(const Files& files, const std::string& wrong_hash_of = "", Pace pace = {}) {
    const auto stub = v1::MapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ImportMapResponse response;
    const auto writer = stub->ImportMap(&context, &response);
    v1::ImportMapRequest message;
    message.mutable_manifest()->set_parent("sites/s/maps/m");
    for (const auto& [name, bytes] : files) {
      v1::FileEntry& entry = *message.mutable_manifest()->add_files();
      entry.set_name(name);
      entry.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
      entry.set_sha256(Sha256(name == wrong_hash_of ? "something else" : bytes));
    }
    writer->Write(message);
    int index = 0;
    for (const auto& [name, bytes] : files) {
      for (std::size_t offset = 0; offset < bytes.size(); offset += pace.chunk) {
        std::this_thread::sleep_for(pace.pause);
        message.mutable_chunk()->set_file(index);
        message.mutable_chunk()->set_offset(static_cast<std::int64_t>(offset));
        message.mutable_chunk()->set_data(bytes.substr(offset, pace.chunk));
        writer->Write(message);
      }
      ++index;
    }
    writer->WritesDone();
    const absl::Status status = client::FromGrpcStatus(writer->Finish());
    if (!status.ok()) return status;
    return response.revision();
  }

  absl::StatusOr<Files> Export(const std::string& name, v1::MapFormat format) {
    const auto stub = v1::MapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ExportMapRequest request;
    request.set_name(name);
    request.set_format(format);
    const auto reader = stub->ExportMap(&context, request);
    v1::ExportMapResponse part;
    std::vector<std::string> contents;
    v1::ExportMapManifest manifest;
    while (reader->Read(&part)) {
      if (part.has_manifest()) {
        manifest = part.manifest();
        contents.resize(static_cast<std::size_t>(manifest.files_size()));
      } else {
        contents[static_cast<std::size_t>(part.chunk().file())] += part.chunk().data();
      }
    }
    const absl::Status status = client::FromGrpcStatus(reader->Finish());
    if (!status.ok()) return status;
    Files files;
    for (int i = 0; i < manifest.files_size(); ++i) {
      const std::string& content = contents[static_cast<std::size_t>(i)];
      EXPECT_EQ(Sha256(content), manifest.files(i).sha256());
      EXPECT_EQ(static_cast<std::int64_t>(content.size()), manifest.files(i).size_bytes());
      files[manifest.files(i).name()] = content;
    }
    return files;
  }
};

std::string Pgm(int width, int height) {
  std::string bytes = "P5\n# made by hand\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  for (int i = 0; i < width * height; ++i) bytes += static_cast<char>((i * 7) % 256);
  return bytes;
}

constexpr char kYaml[] =
    "image: hall.pgm\nresolution: 0.0125\norigin: [-1.23456789, 2.5, 0.1]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.196\n";

TEST_F(MapTransferTest, APgmComesBackBitForBit) {
  const Files files{{"hall.pgm", Pgm(1000, 700)}, {"hall.yaml", kYaml}};
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision revision, Import(files));
  EXPECT_EQ(revision.width(), 1000);
  EXPECT_EQ(revision.height(), 700);
  EXPECT_EQ(revision.resolution_m(), 0.0125);
  EXPECT_EQ(revision.pose_map_grid().x(), -1.23456789);
  EXPECT_EQ(revision.name(), "sites/s/maps/m/revisions/1");
  ASSERT_OK_AND_ASSIGN(const Files exported, Export("sites/s/maps/m", v1::MAP_FORMAT_PGM));
  ASSERT_EQ(exported.count("Map.pgm"), 1U);
  EXPECT_TRUE(exported.at("Map.pgm") == files.at("hall.pgm"));
  EXPECT_THAT(exported.at("Map.yaml"), HasSubstr("0.0125"));
  ASSERT_OK(Export("sites/s/maps/m", v1::MAP_FORMAT_PNG));
  ASSERT_OK(Export("sites/s/maps/m/revisions/1", v1::MAP_FORMAT_PGM));
  EXPECT_CODE(Export("sites/s/maps/m/revisions/2", v1::MAP_FORMAT_PGM), absl::StatusCode::kNotFound);
}

TEST_F(MapTransferTest, WhatViewersSeeOfAnImportIsMadeWithIt) {
  ASSERT_OK(Import({{"hall.pgm", Pgm(300, 300)}, {"hall.yaml", kYaml}}));
  EXPECT_EQ(database_.SqlValue("SELECT map_id || ' ' || revision FROM enfilade.raster_pyramids"), "m 1");
}

TEST_F(MapTransferTest, AnUploadMayTakeAsLongAsItMakesProgress) {
  server::ServerOptions options = Options();
  options.database.default_deadline_s = 1.5;
  Restart(options);
  const Files files{{"hall.pgm", Pgm(100, 100)}, {"hall.yaml", kYaml}};
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_OK(Import(files, "", {.pause = std::chrono::milliseconds(200), .chunk = 1000}));
  EXPECT_GT(std::chrono::steady_clock::now() - begin, std::chrono::milliseconds(1500));
  EXPECT_STATUS(Import(files, "", {.pause = std::chrono::seconds(3), .chunk = 6000}),
                absl::StatusCode::kDeadlineExceeded, HasSubstr("nothing came for 1.5 s"));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM map_revisions"), "1");
}

TEST_F(MapTransferTest, AnExportOfANewRevisionIsNotTheOldOnes) {
  ASSERT_OK(Import({{"hall.pgm", Pgm(10, 10)}, {"hall.yaml", kYaml}}));
  ASSERT_OK_AND_ASSIGN(const Files first, Export("sites/s/maps/m", v1::MAP_FORMAT_PGM));
  ASSERT_OK(Import({{"hall.pgm", Pgm(20, 10)}, {"hall.yaml", kYaml}}));
  ASSERT_OK_AND_ASSIGN(const Files second, Export("sites/s/maps/m", v1::MAP_FORMAT_PGM));
  EXPECT_NE(first.at("Map.pgm"), second.at("Map.pgm"));
}

TEST_F(MapTransferTest, JsonValuesComeBackExactly) {
  const std::string json =
      R"({"xmin": -1, "xmax": 1, "ymin": 0, "ymax": 1, "stepx": 1, "stepy": 1, "level": 10,
          "data": [0.1408478733304343, 0, 1, 0.29489240868472, 0.5, 0.3333333333333333]})";
  ASSERT_OK(Import({{"map.json", json}}));
  ASSERT_OK_AND_ASSIGN(const Files exported, Export("sites/s/maps/m", v1::MAP_FORMAT_JSON));
  EXPECT_THAT(exported.at("Map.json"), HasSubstr("0.1408478733304343"));
  EXPECT_THAT(exported.at("Map.json"), HasSubstr("0.3333333333333333"));
}

TEST_F(MapTransferTest, WhatIsWrongWithFilesIsSaidAndNothingIsStored) {
  const std::string pgm = Pgm(10, 10);
  EXPECT_STATUS(Import({{"hall.pgm", pgm}, {"hall.yaml", kYaml}}, "hall.pgm"), absl::StatusCode::kDataLoss,
                HasSubstr("hall.pgm"));
  EXPECT_STATUS(Import({{"hall.pgm", pgm.substr(0, 60)}, {"hall.yaml", kYaml}}), absl::StatusCode::kInvalidArgument,
                HasSubstr("hall.pgm"));
  EXPECT_CODE(Import({{"hall.yaml", kYaml}}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Import({}), absl::StatusCode::kInvalidArgument);
  EXPECT_CODE(Export("sites/s/maps/m", v1::MAP_FORMAT_PGM), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM map_revisions"), "0");
}

}  // namespace
}  // namespace enfilade::testing

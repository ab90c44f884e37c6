// SPDX-License-Identifier: Apache-2.0
// Downloads and uploads over real gRPC sockets, against a server that sends what no good server would.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "client/sdk/api/blobs.h"
#include "client/sdk/api/evidence.h"
#include "client/sdk/api/graph_export.h"
#include "client/sdk/api/map_export.h"
#include "client/sdk/api/map_import.h"
#include "client/sdk/api/trajectory.h"
#include "core/base/sha256.h"
#include "io/file.h"
#include "tests/support/scripted_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::client {
namespace {

namespace fs = std::filesystem;
using testing::AddToManifest;
using testing::ChunkOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::ScriptedServer;

class TransferTest : public ::testing::Test {
 protected:
  using MapPart = v1::ExportMapResponse;

  // The server answers an export with these files, in chunks of `chunk` bytes; `tamper` may change each message.
  void Serve(
      std::vector<NamedFile> files, std::size_t chunk = 1000,
      const std::function<void(MapPart&)>& tamper = [](MapPart&) {}) {
    server_.maps.export_map = [=](const v1::ExportMapRequest&, grpc::ServerWriter<MapPart>& writer) {
      MapPart manifest;
      manifest.mutable_manifest()->mutable_revision()->set_name("sites/s/maps/m/revisions/3");
      for (const NamedFile& file : files) AddToManifest(file.name, file.bytes, *manifest.mutable_manifest());
      tamper(manifest);
      writer.Write(manifest);
      for (std::size_t i = 0; i < files.size(); ++i) {
        for (std::size_t at = 0; at < files[i].bytes.size(); at += chunk) {
          MapPart part =
              ChunkOf<MapPart>(static_cast<int>(i), static_cast<std::int64_t>(at), files[i].bytes.substr(at, chunk));
          tamper(part);
          writer.Write(part);
        }
      }
      return grpc::Status::OK;
    };
  }
  absl::StatusOr<ExportedMap> Export(const TransferProgress& progress = {}) {
    return ExportMap(connection_, v1::ExportMapRequest(), folder_, progress);
  }
  std::vector<std::string> FolderContent() const {
    std::vector<std::string> names;
    if (!fs::exists(folder_)) return names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

  testing::TemporaryDirectory directory_;
  const fs::path folder_ = directory_.path() / "deep" / "maps";
  ScriptedServer server_{(directory_.path() / "s").string()};
  const Connection connection_{server_.address(), std::chrono::seconds(20), "ann"};
};

const std::vector<NamedFile> kHall = {{"hall.yaml", "image: hall.pgm\n"}, {"hall.pgm", std::string(2500, 'x')}};

TEST_F(TransferTest, ExportWritesAllFilesAndReportsProgress) {
  Serve(kHall);
  std::vector<std::pair<std::int64_t, std::int64_t>> progress;
  ASSERT_OK_AND_ASSIGN(const ExportedMap map,
                       Export([&](std::int64_t done, std::int64_t total) { progress.emplace_back(done, total); }));
  EXPECT_EQ(map.revision.name(), "sites/s/maps/m/revisions/3");
  EXPECT_EQ(map.bytes, 2516);
  EXPECT_THAT(map.files, ElementsAre(folder_ / "hall.yaml", folder_ / "hall.pgm"));
  EXPECT_EQ(*io::ReadFile(folder_ / "hall.yaml"), kHall[0].bytes);
  EXPECT_EQ(*io::ReadFile(folder_ / "hall.pgm"), kHall[1].bytes);
  EXPECT_THAT(progress,
              ElementsAre(std::pair(16, 2516), std::pair(1016, 2516), std::pair(2016, 2516), std::pair(2516, 2516)));
  EXPECT_THAT(FolderContent(), ElementsAre("hall.pgm", "hall.yaml")) << "no temporary files";
}

TEST_F(TransferTest, ExportHasAnActorAndNoDeadline) {
  Serve(kHall);
  ASSERT_OK(Export());
  ASSERT_EQ(server_.calls().size(), 1U);
  EXPECT_EQ(server_.calls()[0].actor, "ann");
  EXPECT_EQ(server_.calls()[0].seconds_to_live, std::nullopt);
}

TEST_F(TransferTest, AnEmptyFileIsWrittenThoughNoChunkCarriesIt) {
  Serve({{"empty.pgm", ""}});
  ASSERT_OK(Export());
  ASSERT_OK_AND_ASSIGN(const std::string bytes, io::ReadFile(folder_ / "empty.pgm"));
  EXPECT_EQ(bytes, "");
}

TEST_F(TransferTest, NoServerWritesOutsideOfTheFolder) {
  for (const std::string name : {"../escaped", "/tmp/enfilade-escaped", "a/../../escaped"}) {
    Serve({{name, "x"}});
    ASSERT_OK_AND_ASSIGN(const ExportedMap map, Export());
    ASSERT_EQ(map.files.size(), 1U);
    EXPECT_EQ(map.files[0].parent_path(), folder_) << name;
  }
  EXPECT_FALSE(fs::exists(folder_.parent_path() / "escaped"));
  EXPECT_FALSE(fs::exists("/tmp/enfilade-escaped"));
  for (const std::string name : {"", ".", ".."}) {
    Serve({{name, "x"}});
    EXPECT_FALSE(Export().ok()) << name;
  }
}

struct Tampering {
  const char* what;
  std::function<void(v1::ExportMapResponse&)> apply;
  const char* message;
};

TEST_F(TransferTest, WhatIsNotAsAnnouncedIsDataLossAndLeavesTheOldFiles) {
  const std::vector<Tampering> cases = {
      {"a wrong byte",
       [](auto& part) {
         if (part.chunk().offset() == 1000) part.mutable_chunk()->mutable_data()->at(3) = 'y';
       },
       "hall.pgm was damaged"},
      {"another digest",
       [](auto& part) {
         if (part.has_manifest()) part.mutable_manifest()->mutable_files(1)->set_sha256(Sha256(""));
       },
       "hall.pgm was damaged"},
      {"a chunk that is shorter",
       [](auto& part) {
         if (part.chunk().offset() == 2000) part.mutable_chunk()->mutable_data()->pop_back();
       },
       "2499 of 2500 bytes"},
      {"a gap",
       [](auto& part) {
         if (part.chunk().offset() == 1000) part.mutable_chunk()->set_offset(1001);
       },
       "offset 1001 after 1000 bytes"},
      {"a repeated chunk",
       [](auto& part) {
         if (part.chunk().offset() == 1000) part.mutable_chunk()->set_offset(0);
       },
       "offset 0 after 1000 bytes"},
      {"a file beyond the manifest",
       [](auto& part) {
         if (part.chunk().offset() == 2000) part.mutable_chunk()->set_file(2);
       },
       "chunk of file 2"},
      {"a negative file",
       [](auto& part) {
         if (part.has_chunk()) part.mutable_chunk()->set_file(-1);
       },
       "chunk of file -1"},
      {"no manifest",
       [](auto& part) {
         if (part.has_manifest()) part.mutable_chunk();
       },
       "not a manifest"},
      {"a larger size",
       [](auto& part) {
         if (part.has_manifest()) part.mutable_manifest()->mutable_files(0)->set_size_bytes(17);
       },
       "16 of 17 bytes"},
  };
  fs::create_directories(folder_);
  ASSERT_OK(io::WriteFile(folder_ / "hall.pgm", "of an earlier export"));
  for (const Tampering& test : cases) {
    Serve(kHall, 1000, test.apply);
    EXPECT_STATUS(Export(), absl::StatusCode::kDataLoss, HasSubstr(test.message)) << test.what;
    EXPECT_CODE(DownloadMap(connection_, v1::ExportMapRequest()), absl::StatusCode::kDataLoss) << test.what;
    EXPECT_THAT(FolderContent(), ElementsAre("hall.pgm")) << test.what;
    EXPECT_EQ(*io::ReadFile(folder_ / "hall.pgm"), "of an earlier export") << test.what;
  }
}

TEST_F(TransferTest, AStreamThatBreaksGivesTheServersErrorAndNoFile) {
  server_.maps.export_map = [](const v1::ExportMapRequest&, grpc::ServerWriter<v1::ExportMapResponse>& writer) {
    v1::ExportMapResponse manifest;
    AddToManifest("hall.pgm", "12", *manifest.mutable_manifest());
    writer.Write(manifest);
    writer.Write(ChunkOf<v1::ExportMapResponse>(0, 0, "1"));
    return grpc::Status(grpc::StatusCode::UNAVAILABLE, "draining");
  };
  EXPECT_STATUS(Export(), absl::StatusCode::kUnavailable, HasSubstr("draining"));
  EXPECT_THAT(FolderContent(), IsEmpty());
  server_.maps.export_map = [](const v1::ExportMapRequest&, grpc::ServerWriter<v1::ExportMapResponse>&) {
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such map");
  };
  EXPECT_STATUS(Export(), absl::StatusCode::kNotFound, HasSubstr("no such map"));
  server_.maps.export_map = [](const v1::ExportMapRequest&, grpc::ServerWriter<v1::ExportMapResponse>&) {
    return grpc::Status::OK;
  };
  EXPECT_STATUS(Export(), absl::StatusCode::kDataLoss, HasSubstr("no manifest"));
}

TEST_F(TransferTest, AFolderThatCannotBeUsedIsNamed) {
  Serve(kHall);
  ASSERT_OK(io::WriteFile(directory_.path() / "file", ""));
  const fs::path below_a_file = directory_.path() / "file" / "maps";
  EXPECT_STATUS(ExportMap(connection_, v1::ExportMapRequest(), below_a_file), absl::StatusCode::kInvalidArgument,
                HasSubstr("file/maps"));
  fs::create_directories(folder_ / "hall.pgm.part");  // in the way
  EXPECT_STATUS(Export(), absl::StatusCode::kInvalidArgument, HasSubstr("hall.pgm.part"));
}

TEST_F(TransferTest, DownloadKeepsTheFilesInMemory) {
  Serve(kHall, 700);
  ASSERT_OK_AND_ASSIGN(const DownloadedMap map, DownloadMap(connection_, v1::ExportMapRequest()));
  ASSERT_EQ(map.files.size(), 2U);
  EXPECT_EQ(map.files[0].name, "hall.yaml");
  EXPECT_EQ(map.files[1].bytes, kHall[1].bytes);
}

TEST_F(TransferTest, ImportSendsAManifestAndThenEveryByteInOrder) {
  const std::vector<NamedFile> files = {{"a.yaml", "y"}, {"a.pgm", std::string((2 << 20) + 5, 'p')}, {"b.pgm", ""}};
  std::vector<v1::ImportMapRequest> received;
  server_.maps.import_map = [&](grpc::ServerReader<v1::ImportMapRequest>& reader, v1::ImportMapResponse& response) {
    v1::ImportMapRequest part;
    while (reader.Read(&part)) received.push_back(part);
    response.mutable_revision()->set_name("revision");
    response.add_warnings("odd");
    return grpc::Status::OK;
  };
  std::int64_t done = 0, total = 0;
  ASSERT_OK_AND_ASSIGN(const v1::ImportMapResponse response,
                       ImportMap(connection_, "sites/s/maps/m", v1::MAP_DIALECT_ROS1, files,
                                 [&](std::int64_t d, std::int64_t t) { done = d, total = t; }));
  EXPECT_EQ(response.revision().name(), "revision");
  EXPECT_EQ(response.warnings(0), "odd");
  EXPECT_EQ(done, (2 << 20) + 6);
  EXPECT_EQ(total, done);
  ASSERT_EQ(received.size(), 5U) << "a manifest, one chunk and three chunks";
  const v1::ImportMapManifest& manifest = received[0].manifest();
  EXPECT_EQ(manifest.parent(), "sites/s/maps/m");
  EXPECT_EQ(manifest.dialect(), v1::MAP_DIALECT_ROS1);
  ASSERT_EQ(manifest.files_size(), 3);
  EXPECT_EQ(manifest.files(1).sha256(), Sha256(files[1].bytes));
  std::string sent;
  for (std::size_t i = 2; i < received.size(); ++i) {
    EXPECT_EQ(received[i].chunk().file(), 1);
    EXPECT_EQ(received[i].chunk().offset(), static_cast<std::int64_t>(sent.size()));
    EXPECT_LE(received[i].chunk().data().size(), kChunkBytes);
    sent += received[i].chunk().data();
  }
  EXPECT_TRUE(sent == files[1].bytes);
}

TEST_F(TransferTest, AnImportThatTheServerEndsEarlyHasItsReason) {
  server_.maps.import_map = [](grpc::ServerReader<v1::ImportMapRequest>& reader, v1::ImportMapResponse&) {
    v1::ImportMapRequest part;
    reader.Read(&part);
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "too large");
  };
  const std::vector<NamedFile> files = {{"a.pgm", std::string(3 << 20, 'p')}};
  EXPECT_STATUS(ImportMap(connection_, "m", v1::MAP_DIALECT_NAV2, files), absl::StatusCode::kInvalidArgument,
                HasSubstr("too large"));
}

class BlobTest : public TransferTest {
 protected:
  void ServeBlob(std::vector<std::pair<std::int64_t, std::string>> chunks) {
    server_.ingest.download_blob = [=](const v1::DownloadBlobRequest& request,
                                       grpc::ServerWriter<v1::DownloadBlobResponse>& writer) {
      EXPECT_EQ(request.parent(), "sites/s");
      for (const auto& [offset, data] : chunks) {
        v1::DownloadBlobResponse part;
        part.mutable_chunk()->set_offset(offset);
        part.mutable_chunk()->set_data(data);
        if (!writer.Write(part)) return grpc::Status::CANCELLED;
      }
      return grpc::Status::OK;
    };
  }
  absl::StatusOr<std::string> Download() { return DownloadBlob(connection_, SiteId("s"), Sha256("picture")); }
};

TEST_F(BlobTest, ChunksMakeTheBlob) {
  ServeBlob({{0, "pic"}, {3, "tu"}, {5, "re"}});
  ASSERT_OK_AND_ASSIGN(const std::string bytes, Download());
  EXPECT_EQ(bytes, "picture");
}

TEST_F(BlobTest, DamageGapsAndErrorsAreErrors) {
  ServeBlob({{0, "pIcture"}});
  EXPECT_STATUS(Download(), absl::StatusCode::kDataLoss, HasSubstr(ToHex(Sha256("picture"))));
  ServeBlob({{0, "pictur"}});
  EXPECT_CODE(Download(), absl::StatusCode::kDataLoss);
  ServeBlob({{0, "pic"}, {4, "ture"}});
  EXPECT_STATUS(Download(), absl::StatusCode::kDataLoss, HasSubstr("offset 4 after 3 bytes"));
  ServeBlob({});
  EXPECT_CODE(Download(), absl::StatusCode::kDataLoss);
  server_.ingest.download_blob = [](const auto&, auto&) {
    return grpc::Status(grpc::StatusCode::NOT_FOUND, "no such blob");
  };
  EXPECT_STATUS(Download(), absl::StatusCode::kNotFound, HasSubstr("no such blob"));
}

TEST_F(TransferTest, EvidenceGoesWithItsReferenceWithinTheDeadline) {
  const std::string cloud((1 << 20) + 3, 'c');
  std::vector<v1::AttachEvidenceRequest> received;
  server_.link_points.attach_evidence = [&](grpc::ServerReader<v1::AttachEvidenceRequest>& reader,
                                            v1::AttachEvidenceResponse& response) {
    v1::AttachEvidenceRequest part;
    while (reader.Read(&part)) received.push_back(part);
    *response.mutable_evidence() = received.front().manifest().evidence();
    return grpc::Status::OK;
  };
  v1::Evidence evidence;
  evidence.set_map("sites/s/maps/m");
  evidence.mutable_cloud()->set_encoding(v1::PointCloud::ENCODING_PCD);
  ASSERT_OK_AND_ASSIGN(const v1::Evidence attached,
                       AttachEvidence(connection_, "sites/s/linkPoints/door", evidence, cloud));
  EXPECT_EQ(attached.cloud().content().sha256(), Sha256(cloud));
  EXPECT_EQ(attached.cloud().content().size_bytes(), static_cast<std::int64_t>(cloud.size()));
  ASSERT_EQ(received.size(), 3U);
  EXPECT_EQ(received[0].manifest().parent(), "sites/s/linkPoints/door");
  EXPECT_TRUE(received[1].chunk().data() + received[2].chunk().data() == cloud);
  EXPECT_EQ(received[2].chunk().offset(), 1 << 20);
  ASSERT_TRUE(server_.calls()[0].seconds_to_live.has_value());
  EXPECT_LE(*server_.calls()[0].seconds_to_live, 25.0);

  received.clear();
  evidence.mutable_image();
  ASSERT_OK_AND_ASSIGN(const v1::Evidence image, AttachEvidence(connection_, "p", evidence, "png"));
  EXPECT_EQ(image.image().content().sha256(), Sha256("png")) << "an image after a cloud";
  server_.link_points.attach_evidence = nullptr;
  EXPECT_CODE(AttachEvidence(connection_, "p", evidence, "png"), absl::StatusCode::kUnimplemented);
}

TEST_F(TransferTest, TheGraphIsOneCheckedFile) {
  using Part = v1::ExportGraphResponse;
  int files = 1;
  std::string sent = "{\"type\":\"x\"}";
  server_.graph.export_graph = [&](const v1::ExportGraphRequest& request, grpc::ServerWriter<Part>& writer) {
    EXPECT_EQ(request.site(), "sites/s");
    Part manifest;
    manifest.mutable_manifest()->set_graph_version(7);
    for (int i = 0; i < files; ++i) AddToManifest("graph.geojson", "{\"type\":\"x\"}", *manifest.mutable_manifest());
    writer.Write(manifest);
    if (!sent.empty()) writer.Write(ChunkOf<Part>(0, 0, sent));
    return grpc::Status::OK;
  };
  ASSERT_OK_AND_ASSIGN(const ExportedGraph graph, ExportGraph(connection_, SiteId("s")));
  EXPECT_EQ(graph.version, 7);
  EXPECT_EQ(graph.geojson, sent);
  sent = "{\"type\":\"y\"}";
  EXPECT_CODE(ExportGraph(connection_, SiteId("s")), absl::StatusCode::kDataLoss);
  sent = "";
  EXPECT_CODE(ExportGraph(connection_, SiteId("s")), absl::StatusCode::kDataLoss);
  for (files = 0; files <= 2; files += 2) {
    EXPECT_STATUS(ExportGraph(connection_, SiteId("s")), absl::StatusCode::kDataLoss, HasSubstr("one file"));
  }
}

TEST_F(TransferTest, ATrajectoryComesPoseByPoseUntilTheCallerHasEnough) {
  server_.sessions.export_trajectory = [](const v1::ExportTrajectoryRequest& request,
                                          grpc::ServerWriter<v1::ExportTrajectoryResponse>& writer) {
    if (request.name() != "sites/s/sessions/run") return grpc::Status(grpc::StatusCode::NOT_FOUND, "no session");
    for (int message = 0; message < 3; ++message) {
      v1::ExportTrajectoryResponse part;
      for (int i = 0; i < 2; ++i) part.add_poses()->mutable_pose_map_robot()->set_x(2 * message + i);
      writer.Write(part);
    }
    return grpc::Status::OK;
  };
  std::vector<double> xs;
  const auto take = [&](const v1::TrajectoryPose& pose) {
    xs.push_back(pose.pose_map_robot().x());
    return xs.size() < 4 ? absl::OkStatus() : absl::ResourceExhaustedError("disk full");
  };
  EXPECT_STATUS(ExportTrajectory(connection_, "sites/s/sessions/run", take), absl::StatusCode::kResourceExhausted,
                HasSubstr("disk full"));
  EXPECT_THAT(xs, ElementsAre(0, 1, 2, 3));
  const auto ignore = [](const v1::TrajectoryPose&) { return absl::OkStatus(); };
  ASSERT_OK_AND_ASSIGN(const std::int64_t poses, ExportTrajectory(connection_, "sites/s/sessions/run", ignore));
  EXPECT_EQ(poses, 6);
  EXPECT_CODE(ExportTrajectory(connection_, "sites/s/sessions/other", ignore), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::client

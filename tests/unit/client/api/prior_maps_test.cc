// SPDX-License-Identifier: Apache-2.0
// Prior maps over real gRPC sockets.
#include "client/sdk/api/prior_maps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

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

class PriorMapsTest : public ::testing::Test {
 protected:
  testing::TemporaryDirectory directory_;
  testing::ScriptedServer server_{(directory_.path() / "s").string()};
  const Connection connection_{server_.address(), std::chrono::seconds(20), "ann"};
};

TEST_F(PriorMapsTest, ImportSendsTheManifestAndThenTheFileInChunks) {
  std::vector<v1::ImportPriorMapRequest> received;
  server_.prior_maps.import_file = [&](grpc::ServerReader<v1::ImportPriorMapRequest>& reader,
                                       v1::ImportPriorMapResponse& response) {
    v1::ImportPriorMapRequest part;
    while (reader.Read(&part)) received.push_back(part);
    response.mutable_prior_map()->set_name("sites/s/priorMaps/p");
    return grpc::Status::OK;
  };
  const std::string bytes((1 << 20) + 3, 'p');
  ASSERT_OK(io::WriteFile(directory_.path() / "floor.png", bytes));
  v1::ImportPriorMapManifest manifest;
  manifest.set_parent("sites/s");
  manifest.set_level(2);
  std::int64_t done = 0;
  ASSERT_OK_AND_ASSIGN(const v1::PriorMap added, ImportPriorMap(connection_, manifest, directory_.path() / "floor.png",
                                                                [&](std::int64_t sent, std::int64_t) { done = sent; }));
  EXPECT_EQ(added.name(), "sites/s/priorMaps/p");
  EXPECT_EQ(done, (1 << 20) + 3);
  ASSERT_EQ(received.size(), 3U);
  EXPECT_EQ(received[0].manifest().parent(), "sites/s");
  EXPECT_EQ(received[0].manifest().level(), 2);
  EXPECT_EQ(received[0].manifest().file().name(), "floor.png");
  EXPECT_EQ(received[0].manifest().file().sha256(), Sha256(bytes));
  EXPECT_EQ(received[2].chunk().offset(), 1 << 20);
  EXPECT_TRUE(received[1].chunk().data() + received[2].chunk().data() == bytes);
  EXPECT_EQ(server_.calls()[0].actor, "ann");
  EXPECT_FALSE(server_.calls()[0].seconds_to_live.has_value());
}

TEST_F(PriorMapsTest, AnImportThatFailsHasItsReason) {
  server_.prior_maps.import_file = [](grpc::ServerReader<v1::ImportPriorMapRequest>& reader,
                                      v1::ImportPriorMapResponse&) {
    v1::ImportPriorMapRequest part;
    reader.Read(&part);
    return grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "3 walls");
  };
  EXPECT_STATUS(ImportPriorMap(connection_, {}, NamedFile{"a.png", std::string(3 << 20, 'p')}),
                absl::StatusCode::kInvalidArgument, HasSubstr("3 walls"));
  EXPECT_CODE(ImportPriorMap(connection_, {}, fs::path("/none/a.png")), absl::StatusCode::kNotFound);
}

TEST_F(PriorMapsTest, ExportWritesFilesThatAreWhatTheManifestSays) {
  v1::ExportPriorMapRequest asked;
  std::string sent = "{}";
  server_.prior_maps.export_files = [&](const v1::ExportPriorMapRequest& request,
                                        grpc::ServerWriter<v1::ExportPriorMapResponse>& writer) {
    asked = request;
    v1::ExportPriorMapResponse manifest;
    manifest.mutable_manifest()->set_name(request.name());
    AddToManifest("walls.geojson", "{}", *manifest.mutable_manifest());
    AddToManifest("../walls.svg", "<svg/>", *manifest.mutable_manifest());
    writer.Write(manifest);
    writer.Write(ChunkOf<v1::ExportPriorMapResponse>(0, 0, sent));
    writer.Write(ChunkOf<v1::ExportPriorMapResponse>(1, 0, "<svg/>"));
    return grpc::Status::OK;
  };
  const fs::path folder = directory_.path() / "deep" / "out";
  const std::vector<v1::PriorMapProduct> products = {v1::PRIOR_MAP_PRODUCT_CORRECTED, v1::PRIOR_MAP_PRODUCT_PICTURE};
  ASSERT_OK_AND_ASSIGN(const std::vector<fs::path> files,
                       ExportPriorMap(connection_, "sites/s/priorMaps/p", products, folder));
  EXPECT_THAT(files, ElementsAre(folder / "walls.geojson", folder / "walls.svg"));
  EXPECT_EQ(*io::ReadFile(folder / "walls.svg"), "<svg/>");
  EXPECT_EQ(asked.name(), "sites/s/priorMaps/p");
  EXPECT_THAT(asked.products(), ElementsAre(v1::PRIOR_MAP_PRODUCT_CORRECTED, v1::PRIOR_MAP_PRODUCT_PICTURE));
  sent = "[]";
  EXPECT_STATUS(ExportPriorMap(connection_, "sites/s/priorMaps/p", products, folder), absl::StatusCode::kDataLoss,
                HasSubstr("walls.geojson was damaged"));
  EXPECT_EQ(*io::ReadFile(folder / "walls.geojson"), "{}") << "of the earlier export";
}

TEST_F(PriorMapsTest, APriorMapIsMeantByItsNameItsIdOrItsResourceName) {
  server_.prior_maps.list = [](const v1::ListPriorMapsRequest& request, v1::ListPriorMapsResponse& response) {
    // A page for each.
    v1::PriorMap& one = *response.add_prior_maps();
    one.set_name(request.page_token().empty() ? "sites/s/priorMaps/a" : "sites/s/priorMaps/b");
    one.set_display_name(request.page_token().empty() ? "Cellar" : "Ground floor");
    if (request.page_token().empty()) response.set_next_page_token("2");
    return grpc::Status::OK;
  };
  server_.prior_maps.get = [](const v1::GetPriorMapRequest& request, v1::GetPriorMapResponse& response) {
    if (request.name() == "sites/s/priorMaps/none") return grpc::Status(grpc::StatusCode::NOT_FOUND, "no plan");
    response.mutable_prior_map()->set_name(request.name());
    return grpc::Status::OK;
  };
  const auto name_of = [&](const std::string& meant) {
    const auto found = FindPriorMap(connection_, SiteId("s"), meant);
    return found.ok() ? found->name() : std::string(absl::StatusCodeToString(found.status().code()));
  };
  EXPECT_EQ(name_of("Ground floor"), "sites/s/priorMaps/b");
  EXPECT_EQ(name_of("a"), "sites/s/priorMaps/a");
  EXPECT_EQ(name_of("sites/s/priorMaps/b"), "sites/s/priorMaps/b");
  EXPECT_EQ(name_of("none"), "NOT_FOUND");
  EXPECT_EQ(name_of("First floor"), "NOT_FOUND");
}

}  // namespace
}  // namespace enfilade::client

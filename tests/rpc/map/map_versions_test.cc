// SPDX-License-Identifier: Apache-2.0
// Aliases of revisions, their differences, and what is restored.
#include <gmock/gmock.h>

#include "core/grid/files/png_codec.h"
#include "core/grid/map_raster.h"
#include "server/app/mapping/raster_revision.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using Maps = v1::MapService::Stub;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kStable[] = "sites/s/maps/m/aliases/stable";

std::string Revision(int number) { return "sites/s/maps/m/revisions/" + std::to_string(number); }

class MapVersionsTest : public ServerTest {
 protected:
  // Revisions 1, 2, 3: a hall, the same with a pillar, the same with another one instead.
  MapVersionsTest() {
    for (const int pillar : {-1, 100, 300}) Import(Hall(pillar));
  }
  static grid::OccupancyGrid Hall(int pillar) {
    grid::OccupancyGrid hall;
    hall.geometry = {0.05, {-10.0, -5.0, 0.0}, 600, 400};
    hall.cells.assign(hall.geometry.cell_count(), 20);
    for (int i = 0; i < 25 && pillar >= 0; ++i) hall.cells[hall.geometry.index(pillar + i % 5, 50 + i / 5)] = 240;
    return hall;
  }
  void Import(const grid::OccupancyGrid& hall) {
    auto raster = server::ToRevision(grid::FromOccupancyGrid(hall));
    ASSERT_OK(raster);
    raster->revision.source = storage::RevisionSource::kImport;
    ASSERT_OK(server::PutTiles(Soon(), storage::postgres::BlobStore(*pool_), SiteId("s"), *raster, {}));
    ASSERT_OK(revisions_.Add(Soon(), SiteId("s"), MapId("m"), raster->revision, {}));
  }

  absl::StatusOr<v1::MapAlias> Set(const std::string& revision, const std::string& etag = "",
                                   const std::string& name = kStable) const {
    v1::SetMapAliasRequest request;
    request.mutable_alias()->set_name(name);
    request.mutable_alias()->set_revision(revision);
    request.mutable_alias()->set_etag(etag);
    auto response = Call(&Maps::SetMapAlias, request);
    if (!response.ok()) return response.status();
    return response->alias();
  }
  absl::StatusOr<v1::MapAlias> RollBack(const std::string& etag = "") const {
    v1::RollBackMapAliasRequest request;
    request.set_name(kStable);
    request.set_etag(etag);
    auto response = Call(&Maps::RollBackMapAlias, request);
    if (!response.ok()) return response.status();
    return response->alias();
  }
  absl::StatusOr<v1::MapRevision> Get(const std::string& name) const {
    v1::GetMapRevisionRequest request;
    request.set_name(name);
    auto response = Call(&Maps::GetMapRevision, request);
    if (!response.ok()) return response.status();
    return response->revision();
  }
  absl::StatusOr<v1::MapRevision> Restore(const std::string& name) const {
    v1::RestoreMapRevisionRequest request;
    request.set_name(name);
    auto response = Call(&Maps::RestoreMapRevision, request);
    if (!response.ok()) return response.status();
    return response->revision();
  }
  static v1::DiffMapRevisionsRequest Between(const std::string& base, const std::string& revision) {
    v1::DiffMapRevisionsRequest request;
    request.set_base(base);
    request.set_revision(revision);
    return request;
  }
  // Of the map's files as PGM.
  absl::StatusOr<std::string> ExportedRevision(const std::string& name) const {
    const auto stub = v1::MapService::NewStub(connection_->channel());
    grpc::ClientContext context;
    v1::ExportMapRequest request;
    request.set_name(name);
    request.set_format(v1::MAP_FORMAT_PGM);
    const auto reader = stub->ExportMap(&context, request);
    v1::ExportMapResponse part;
    std::string revision;
    while (reader->Read(&part)) {
      if (part.has_manifest()) revision = part.manifest().revision().name();
    }
    const absl::Status status = client::FromGrpcStatus(reader->Finish());
    if (!status.ok()) return status;
    return revision;
  }

  const storage::postgres::RevisionStore revisions_{*pool_};
};

TEST_F(MapVersionsTest, AnAliasIsReadWhereverARevisionIs) {
  ASSERT_OK_AND_ASSIGN(const v1::MapAlias made, Set(Revision(2)));
  EXPECT_EQ(made.name(), kStable);
  EXPECT_EQ(made.revision(), Revision(2));
  EXPECT_THAT(made.previous_revision(), IsEmpty());
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision revision, Get(kStable));
  EXPECT_EQ(revision.name(), Revision(2));
  EXPECT_THAT(revision.aliases(), ElementsAre("stable"));
  ASSERT_OK_AND_ASSIGN(const std::string exported, ExportedRevision(kStable));
  EXPECT_EQ(exported, Revision(2));
  ASSERT_OK_AND_ASSIGN(const auto diff, Call(&Maps::DiffMapRevisions, Between(kStable, Revision(3))));
  EXPECT_EQ(diff.base(), Revision(2));
  EXPECT_EQ(diff.revision(), Revision(3));
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision restored, Restore(kStable));
  EXPECT_EQ(restored.name(), Revision(4));
}

TEST_F(MapVersionsTest, TheSecondWhoMovesAnAliasIsAborted) {
  ASSERT_OK_AND_ASSIGN(const v1::MapAlias made, Set(Revision(1)));
  ASSERT_OK_AND_ASSIGN(const v1::MapAlias moved, Set(Revision(2), made.etag()));
  EXPECT_EQ(moved.previous_revision(), Revision(1));
  EXPECT_STATUS(Set(Revision(3), made.etag()), absl::StatusCode::kAborted, HasSubstr("read it again"));
  EXPECT_CODE(RollBack(made.etag()), absl::StatusCode::kAborted);
  v1::DeleteMapAliasRequest deletion;
  deletion.set_name(kStable);
  deletion.set_etag(made.etag());
  EXPECT_CODE(Call(&Maps::DeleteMapAlias, deletion), absl::StatusCode::kAborted);
  EXPECT_EQ(Get(kStable)->name(), Revision(2));
  deletion.set_etag(moved.etag());
  ASSERT_OK(Call(&Maps::DeleteMapAlias, deletion));
  EXPECT_STATUS(Get(kStable), absl::StatusCode::kNotFound, HasSubstr("aliases/stable"));
}

TEST_F(MapVersionsTest, AnAliasIsLedBackInOneCall) {
  ASSERT_OK(Set(Revision(1)));
  EXPECT_CODE(RollBack(), absl::StatusCode::kFailedPrecondition);
  ASSERT_OK(Set(Revision(3)));
  ASSERT_OK_AND_ASSIGN(const v1::MapAlias back, RollBack());
  EXPECT_EQ(back.revision(), Revision(1));
  EXPECT_EQ(back.previous_revision(), Revision(3));
  v1::ListMapAliasesRequest list;
  list.set_parent("sites/s/maps/m");
  ASSERT_OK(Set(Revision(3), "", "sites/s/maps/m/aliases/canary"));
  ASSERT_OK_AND_ASSIGN(const auto aliases, Call(&Maps::ListMapAliases, list));
  ASSERT_EQ(aliases.aliases_size(), 2);
  EXPECT_EQ(aliases.aliases(0).name(), "sites/s/maps/m/aliases/canary");
  EXPECT_EQ(aliases.aliases(1).revision(), Revision(1));
}

TEST_F(MapVersionsTest, WrongNamesAreRefusedNamingThem) {
  constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
  EXPECT_STATUS(Set("sites/s/maps/other/revisions/1"), kInvalid, HasSubstr("alias.revision"));
  EXPECT_STATUS(Set("sites/s/maps/m"), kInvalid, HasSubstr("alias.revision"));
  EXPECT_STATUS(Set(Revision(1), "", "sites/s/maps/m/aliases/Main hall"), kInvalid, HasSubstr("alias.name"));
  EXPECT_STATUS(Set(Revision(1), "etag"), kInvalid, HasSubstr("etag"));
  EXPECT_STATUS(Set(Revision(9)), absl::StatusCode::kNotFound, HasSubstr("revisions/9"));
  EXPECT_STATUS(Get("sites/s/maps/m/aliases/../x"), kInvalid, HasSubstr("name is"));
  EXPECT_STATUS(Get("sites/s/maps/m/aliases/none"), absl::StatusCode::kNotFound, HasSubstr("aliases/none"));
  EXPECT_CODE(ExportedRevision("sites/s/maps/m/aliases/none"), absl::StatusCode::kNotFound);
  EXPECT_CODE(Restore(Revision(9)), absl::StatusCode::kNotFound);
  EXPECT_STATUS(Call(&Maps::DiffMapRevisions, Between(Revision(1), "sites/s/maps/other/revisions/1")), kInvalid,
                HasSubstr("expected a revision of sites/s/maps/m"));
  EXPECT_CODE(Call(&Maps::DiffMapRevisions, Between(Revision(1), Revision(9))), absl::StatusCode::kNotFound);
  v1::DiffMapRevisionsRequest many = Between(Revision(1), Revision(2));
  many.set_max_regions(1001);
  EXPECT_STATUS(Call(&Maps::DiffMapRevisions, many), kInvalid, HasSubstr("max_regions"));
}

TEST_F(MapVersionsTest, TellsWhatCameAndWent) {
  v1::DiffMapRevisionsRequest request = Between(Revision(2), Revision(3));
  request.set_with_picture(true);
  request.set_with_geojson(true);
  ASSERT_OK_AND_ASSIGN(const auto diff, Call(&Maps::DiffMapRevisions, request));
  EXPECT_EQ(diff.resolution_m(), 0.05);
  EXPECT_THAT(diff.cells(), ElementsAre(0, 0, 0, 0, 600 * 400 - 50, 25, 0, 25, 0));
  EXPECT_EQ(diff.region_count(), 2);
  ASSERT_EQ(diff.regions_size(), 2);
  EXPECT_EQ(diff.regions(0).cells(), 25);
  EXPECT_EQ(diff.regions(0).to_free(), 25) << "of equal ones the leftmost first";
  EXPECT_EQ(diff.regions(1).to_occupied(), 25);
  ASSERT_EQ(diff.regions(1).box().corners_size(), 4);
  EXPECT_NEAR(diff.regions(1).box().corners(0).x(), -10.0 + 300 * 0.05, 1e-9);
  EXPECT_NEAR(diff.regions(1).box().corners(2).y(), -5.0 + 55 * 0.05, 1e-9);
  ASSERT_OK_AND_ASSIGN(const grid::PixelImage picture, grid::DecodePng(diff.picture()));
  EXPECT_EQ(picture.width, 600);
  EXPECT_EQ(picture.height, 400);
  EXPECT_EQ(diff.picture_resolution_m(), 0.05);
  EXPECT_NEAR(diff.pose_map_picture().x(), -10.0, 1e-9);
  EXPECT_THAT(diff.geojson(), HasSubstr("\"went\""));
  EXPECT_THAT(diff.geojson(), HasSubstr("\"came\""));
  ASSERT_OK_AND_ASSIGN(const auto plain, Call(&Maps::DiffMapRevisions, Between(Revision(2), Revision(3))));
  EXPECT_THAT(plain.picture(), IsEmpty());
  EXPECT_THAT(plain.geojson(), IsEmpty());
}

TEST_F(MapVersionsTest, WhatIsRestoredIsTheNewestRevisionAndTheOnlyLayer) {
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision first, Get(Revision(1)));
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision restored, Restore(Revision(1)));
  EXPECT_EQ(restored.name(), Revision(4));
  EXPECT_EQ(restored.source(), v1::MapRevision::SOURCE_RESTORED);
  EXPECT_EQ(restored.content_sha256(), first.content_sha256());
  EXPECT_EQ(database_.SqlValue("SELECT string_agg(revision::text, ',') FROM enfilade.map_layers WHERE map_id = 'm'"),
            "4");
  ASSERT_OK_AND_ASSIGN(const auto diff, Call(&Maps::DiffMapRevisions, Between(Revision(1), Revision(4))));
  EXPECT_EQ(diff.region_count(), 0);
  ASSERT_OK_AND_ASSIGN(const v1::MapRevision again, Restore(Revision(1)));
  EXPECT_EQ(again.name(), Revision(4)) << "a call that is repeated makes no other one";
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM enfilade.raster_pyramids WHERE revision = 4"), "1");
}

}  // namespace
}  // namespace enfilade::testing

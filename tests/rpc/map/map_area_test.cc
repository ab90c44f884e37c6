// SPDX-License-Identifier: Apache-2.0
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "client/sdk/api/map_import.h"
#include "core/areas/area_geojson.h"
#include "core/base/sha256.h"
#include "core/grid/files/map_files.h"
#include "core/grid/occupancy_values.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_area_service.grpc.pb.h"
#include "tests/rpc/server_test.h"

namespace enfilade::testing {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Files = std::map<std::string, std::string>;
using Stub = v1::MapAreaService::Stub;

constexpr const char* kMap = "sites/s/maps/m";

class MapAreaTest : public ServerTest {
 protected:
  static v1::MapArea Box(v1::MapArea::Kind kind, double x0, double y0, double x1, double y1) {
    v1::MapArea area;
    area.set_display_name("Box");
    area.set_kind(kind);
    for (const auto& [x, y] : std::vector<std::pair<double, double>>{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}) {
      v1::Point& corner = *area.mutable_outline()->add_corners();
      corner.set_x(x);
      corner.set_y(y);
    }
    return area;
  }
  absl::StatusOr<v1::MapArea> Create(const std::string& id, const v1::MapArea& area, bool force = false,
                                     const std::string& request_id = "") const {
    v1::CreateMapAreaRequest request;
    request.set_parent(kMap);
    request.set_area_id(id);
    *request.mutable_area() = area;
    request.set_force(force);
    request.set_request_id(request_id);
    const auto response = Call(&Stub::CreateMapArea, request);
    if (!response.ok()) return response.status();
    return response->area();
  }
  absl::StatusOr<v1::MapArea> Update(const v1::MapArea& area, const std::vector<std::string>& mask,
                                     bool force = false) const {
    v1::UpdateMapAreaRequest request;
    *request.mutable_area() = area;
    for (const std::string& path : mask) request.mutable_update_mask()->add_paths(path);
    request.set_force(force);
    const auto response = Call(&Stub::UpdateMapArea, request);
    if (!response.ok()) return response.status();
    return response->area();
  }
  absl::StatusOr<v1::MapArea> Get(const std::string& id) const {
    v1::GetMapAreaRequest request;
    request.set_name(std::string(kMap) + "/areas/" + id);
    const auto response = Call(&Stub::GetMapArea, request);
    if (!response.ok()) return response.status();
    return response->area();
  }
  absl::StatusOr<Files> Export(v1::ExportMapAreasRequest request) const {
    request.set_parent(kMap);
    const auto stub = v1::MapAreaService::NewStub(connection_->channel());
    grpc::ClientContext context;
    const auto stream = stub->ExportMapAreas(&context, request);
    v1::ExportMapAreasResponse message;
    v1::ExportMapAreasManifest manifest;
    Files files;
    while (stream->Read(&message)) {
      if (message.has_manifest()) {
        manifest = message.manifest();
        continue;
      }
      std::string& file = files[manifest.files(message.chunk().file()).name()];
      EXPECT_EQ(message.chunk().offset(), static_cast<std::int64_t>(file.size()));
      file += message.chunk().data();
    }
    const absl::Status status = client::FromGrpcStatus(stream->Finish());
    if (!status.ok()) return status;
    EXPECT_EQ(static_cast<std::size_t>(manifest.files_size()), files.size());
    for (const v1::FileEntry& entry : manifest.files()) {
      EXPECT_EQ(Sha256(files[entry.name()]), entry.sha256());
      EXPECT_EQ(static_cast<std::int64_t>(files[entry.name()].size()), entry.size_bytes());
    }
    return files;
  }
  absl::StatusOr<Files> Export(v1::MapAreaFormat format, const std::string& robot_type = "") const {
    v1::ExportMapAreasRequest request;
    request.set_format(format);
    request.set_robot_type(robot_type);
    return Export(request);
  }
  // The ids in areas.geojson.
  static std::vector<std::string> IdsIn(const absl::StatusOr<Files>& files) {
    EXPECT_OK(files.status());
    std::vector<std::string> ids;
    if (!files.ok()) return ids;
    const auto read = areas::ReadAreasGeoJson(files->at("areas.geojson"));
    EXPECT_OK(read);
    for (const areas::NamedArea& area : *read) ids.push_back(area.id.value());
    return ids;
  }
  // Map "m" gets a revision of 8 x 4 cells of 0.5 m from (-1, 2) on.
  void ImportMap() const {
    grid::OccupancyGrid free;
    free.geometry = {0.5, {-1, 2, 0}, 8, 4};
    free.cells.assign(32, grid::CellFromOccupancyValue(0));
    const auto files = grid::RenderFiles(grid::FromOccupancyGrid(free), "m", {});
    ASSERT_OK(files);
    std::vector<client::NamedFile> named;
    for (const grid::MapFile& file : *files) named.push_back({file.name, file.bytes});
    ASSERT_OK(client::ImportMap(*connection_, kMap, v1::MAP_DIALECT_NAV2, named));
  }
  // The values that Nav2 reads in a mask, a row of it upwards from the lowest.
  static std::vector<int> RowOf(const Files& files, const std::string& stem, int row) {
    const std::vector<grid::MapFile> mask = {{stem + ".yaml", files.at(stem + ".yaml")},
                                             {stem + ".pgm", files.at(stem + ".pgm")}};
    const auto imported = grid::ImportFiles(mask, grid::MapDialect::kNav2);
    EXPECT_OK(imported);
    if (!imported.ok()) return {};
    EXPECT_EQ(imported->raster.geometry, (grid::GridGeometry{0.5, {-1, 2, 0}, 8, 4}));
    const auto& cells = std::get<grid::GreyCells>(imported->raster.cells);
    std::vector<int> values;
    for (int column = 0; column < 8; ++column) {
      values.push_back(grid::LoadedValue(cells.interpretation, cells.grey[static_cast<std::size_t>(8 * row + column)]));
    }
    return values;
  }
  absl::Status CreateLinkPoint(const std::string& id, double x, double y) const {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/s");
    request.set_link_point_id(id);
    request.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
    anchor.set_map(kMap);
    anchor.mutable_pose_map_place()->mutable_pose()->set_x(x);
    anchor.mutable_pose_map_place()->mutable_pose()->set_y(y);
    for (int i = 0; i < 9; ++i) anchor.mutable_pose_map_place()->add_covariance(i % 4 == 0 ? 0.01 : 0.0);
    return Call(&v1::LinkPointService::Stub::CreateLinkPoint, request).status();
  }
};

TEST_F(MapAreaTest, AreasAreCreatedReadChangedAndDeleted) {
  v1::MapArea ramp = Box(v1::MapArea::KIND_SPEED_LIMIT, 0, 0, 4, 2);
  ramp.set_display_name("Ramp");
  ramp.set_speed_limit_mps(0.3);
  ramp.add_robot_types("forklift");
  ramp.mutable_valid_from()->set_seconds(1'767'225'600);
  ramp.mutable_valid_from()->set_nanos(1'999);
  ASSERT_OK_AND_ASSIGN(const v1::MapArea created, Create("ramp", ramp, false, "request"));
  EXPECT_EQ(created.name(), "sites/s/maps/m/areas/ramp");
  EXPECT_EQ(created.valid_from().nanos(), 1'000) << "in microseconds";
  EXPECT_FALSE(created.has_valid_until());
  EXPECT_GT(created.create_time().seconds(), 0);
  ASSERT_OK_AND_ASSIGN(const v1::MapArea again, Create("ramp", ramp, false, "request"));
  EXPECT_EQ(again.SerializeAsString(), created.SerializeAsString());
  EXPECT_CODE(Create("ramp", ramp), absl::StatusCode::kAlreadyExists);
  ASSERT_OK_AND_ASSIGN(const v1::MapArea found, Get("ramp"));
  EXPECT_EQ(found.SerializeAsString(), created.SerializeAsString());

  v1::MapArea change;
  change.set_name(created.name());
  change.set_speed_limit_mps(0.5);
  ASSERT_OK_AND_ASSIGN(const v1::MapArea faster, Update(change, {}));
  EXPECT_EQ(faster.speed_limit_mps(), 0.5);
  EXPECT_EQ(faster.display_name(), "Ramp") << "what is not set stays";
  EXPECT_THAT(faster.robot_types(), ElementsAre("forklift"));
  ASSERT_OK_AND_ASSIGN(const v1::MapArea for_all, Update(change, {"robot_types", "valid_from"}));
  EXPECT_EQ(for_all.robot_types_size(), 0);
  EXPECT_FALSE(for_all.has_valid_from());
  EXPECT_EQ(for_all.speed_limit_mps(), 0.5) << "not in the mask";
  v1::MapArea room;
  room.set_name(created.name());
  room.set_kind(v1::MapArea::KIND_ROOM);
  ASSERT_OK_AND_ASSIGN(const v1::MapArea as_room, Update(room, {"kind"}));
  EXPECT_EQ(as_room.speed_limit_mps(), 0.0) << "a room has none";
  change.set_etag(created.etag());
  EXPECT_CODE(Update(change, {"display_name"}), absl::StatusCode::kInvalidArgument) << "an empty name";
  change.set_display_name("Late");
  EXPECT_CODE(Update(change, {"display_name"}), absl::StatusCode::kAborted);
  EXPECT_STATUS(Update(change, {"etag"}), absl::StatusCode::kInvalidArgument, HasSubstr("update_mask"));

  v1::DeleteMapAreaRequest remove;
  remove.set_name(created.name());
  remove.set_etag(created.etag());
  EXPECT_CODE(Call(&Stub::DeleteMapArea, remove), absl::StatusCode::kAborted);
  remove.set_etag(as_room.etag());
  EXPECT_OK(Call(&Stub::DeleteMapArea, remove));
  EXPECT_CODE(Get("ramp"), absl::StatusCode::kNotFound);
}

TEST_F(MapAreaTest, ListsPageByPage) {
  for (const char* id : {"c", "a", "b"}) ASSERT_OK(Create(id, Box(v1::MapArea::KIND_DOCK, 0, 0, 1, 1)));
  v1::ListMapAreasRequest request;
  request.set_parent(kMap);
  request.set_page_size(2);
  std::vector<std::string> names;
  do {
    ASSERT_OK_AND_ASSIGN(const v1::ListMapAreasResponse page, Call(&Stub::ListMapAreas, request));
    for (const v1::MapArea& area : page.areas()) names.push_back(area.name());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  EXPECT_THAT(names, ElementsAre("sites/s/maps/m/areas/a", "sites/s/maps/m/areas/b", "sites/s/maps/m/areas/c"));
  request.set_parent("sites/s/maps/none");
  EXPECT_CODE(Call(&Stub::ListMapAreas, request), absl::StatusCode::kNotFound);
}

TEST_F(MapAreaTest, WhatIsWrongIsNamed) {
  const auto refuse = [&](const v1::MapArea& area, const std::string& why) {
    EXPECT_STATUS(Create("a", area), absl::StatusCode::kInvalidArgument, HasSubstr(why));
  };
  refuse(Box(v1::MapArea::KIND_UNSPECIFIED, 0, 0, 1, 1), "area.kind is 0");
  refuse(Box(static_cast<v1::MapArea::Kind>(99), 0, 0, 1, 1), "area.kind is 99");
  v1::MapArea area = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1);
  area.clear_display_name();
  refuse(area, "area.display_name must have 1 to 200 characters");
  refuse(Box(v1::MapArea::KIND_SPEED_LIMIT, 0, 0, 1, 1), "area.speed_limit_mps is 0");
  area = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1);
  area.mutable_outline()->mutable_corners(0)->set_x(2);
  area.mutable_outline()->mutable_corners(0)->set_y(0.5);
  refuse(area, "area.outline: sides");
  area = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, std::numeric_limits<double>::quiet_NaN());
  refuse(area, "area.outline: corner 2 is not finite");
  area.clear_outline();
  refuse(area, "area.outline has 0 corners");
  area = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1);
  area.add_robot_types("Fork Lift");
  refuse(area, "area.robot_types[0] is \"Fork Lift\"");
  area.clear_robot_types();
  area.mutable_valid_from()->set_seconds(1'767'225'600);
  *area.mutable_valid_until() = area.valid_from();
  area.mutable_valid_until()->set_nanos(999);
  refuse(area, "area.valid_until is not after valid_from");
  area.mutable_valid_until()->set_seconds(-1);
  refuse(area, "area.valid_until");
  EXPECT_STATUS(Create("Not an id", Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1)), absl::StatusCode::kInvalidArgument,
                HasSubstr("area_id"));
}

TEST_F(MapAreaTest, AKeepOutAreaOverALinkPointNeedsForce) {
  ASSERT_OK(CreateLinkPoint("door", 1, 1));
  ASSERT_OK(CreateLinkPoint("gate", 5, 1));
  const auto names_the_door = AllOf(HasSubstr("sites/s/linkPoints/door"), ::testing::Not(HasSubstr("gate")));
  const v1::MapArea stop = Box(v1::MapArea::KIND_KEEP_OUT, 0, 0, 2, 2);
  EXPECT_STATUS(Create("stop", stop), absl::StatusCode::kFailedPrecondition, names_the_door);
  ASSERT_OK(Create("stop", stop, true));
  ASSERT_OK_AND_ASSIGN(v1::MapArea room, Create("room", Box(v1::MapArea::KIND_ROOM, 0, 0, 2, 2)));
  room.set_kind(v1::MapArea::KIND_KEEP_OUT);
  EXPECT_STATUS(Update(room, {"kind"}), absl::StatusCode::kFailedPrecondition, names_the_door);
  EXPECT_OK(Update(room, {"kind"}, true));
}

TEST_F(MapAreaTest, ExportsGeoJsonOfAllOrOfThoseThatHold) {
  v1::MapArea forklifts = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1);
  forklifts.add_robot_types("forklift");
  v1::MapArea past = Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1);
  past.mutable_valid_until()->set_seconds(1'600'000'000);
  ASSERT_OK(Create("all", Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1)));
  ASSERT_OK(Create("forklifts", forklifts));
  ASSERT_OK(Create("past", past));
  EXPECT_THAT(IdsIn(Export(v1::MAP_AREA_FORMAT_GEOJSON)), ElementsAre("all", "forklifts", "past"));
  EXPECT_THAT(IdsIn(Export(v1::MAP_AREA_FORMAT_GEOJSON, "cleaner")), ElementsAre("all", "past"));
  v1::ExportMapAreasRequest later;
  later.set_format(v1::MAP_AREA_FORMAT_GEOJSON);
  later.mutable_time()->set_seconds(1'600'000'000);
  EXPECT_THAT(IdsIn(Export(later)), ElementsAre("all", "forklifts"));
  later.mutable_time()->set_seconds(1'599'999'999);
  EXPECT_THAT(IdsIn(Export(later)), ElementsAre("all", "forklifts", "past"));
  EXPECT_STATUS(Export(v1::MAP_AREA_FORMAT_GEOJSON, "Fork Lift"), absl::StatusCode::kInvalidArgument,
                HasSubstr("robot_type"));
  EXPECT_STATUS(Export(v1::MAP_AREA_FORMAT_UNSPECIFIED), absl::StatusCode::kInvalidArgument, HasSubstr("format is 0"));
}

TEST_F(MapAreaTest, ExportsMoreAreasThanAPageHas) {
  database_.Sql(
      "INSERT INTO enfilade.map_areas (site_id, map_id, area_id, display_name, kind, outline, etag) SELECT 's', 'm',"
      " 'a' || i, 'A', 5, 'POLYGON((0 0, 1 0, 1 1, 0 0))', 1 FROM generate_series(1, 2500) i");
  EXPECT_EQ(IdsIn(Export(v1::MAP_AREA_FORMAT_GEOJSON)).size(), 2500U);
}

TEST_F(MapAreaTest, ExportsMasksOnTheCellsOfTheNewestRevision) {
  EXPECT_STATUS(Export(v1::MAP_AREA_FORMAT_NAV2_KEEPOUT), absl::StatusCode::kFailedPrecondition,
                HasSubstr("has no revision yet"));
  ImportMap();
  v1::MapArea forklifts = Box(v1::MapArea::KIND_KEEP_OUT, 2, 2, 3, 2.5);
  forklifts.add_robot_types("forklift");
  v1::MapArea past = Box(v1::MapArea::KIND_KEEP_OUT, -1, 2, 3, 4);
  past.mutable_valid_until()->set_seconds(1'600'000'000);
  ASSERT_OK(Create("stop", Box(v1::MapArea::KIND_KEEP_OUT, -0.5, 1.5, 0.25, 2.5)));
  ASSERT_OK(Create("forklifts", forklifts));
  ASSERT_OK(Create("past", past));
  ASSERT_OK_AND_ASSIGN(const Files all, Export(v1::MAP_AREA_FORMAT_NAV2_KEEPOUT));
  EXPECT_THAT(RowOf(all, "keepout", 0), ElementsAre(0, 100, 100, 0, 0, 0, 100, 100));
  EXPECT_THAT(RowOf(all, "keepout", 1), ElementsAre(0, 0, 0, 0, 0, 0, 0, 0));
  ASSERT_OK_AND_ASSIGN(const Files cleaners, Export(v1::MAP_AREA_FORMAT_NAV2_KEEPOUT, "cleaner"));
  EXPECT_THAT(RowOf(cleaners, "keepout", 0), ElementsAre(0, 100, 100, 0, 0, 0, 0, 0));
  ASSERT_OK(Create("lane", Box(v1::MapArea::KIND_PREFERRED, -1, 2, 3, 2.5)));
  ASSERT_OK_AND_ASSIGN(const Files lanes, Export(v1::MAP_AREA_FORMAT_NAV2_KEEPOUT, "cleaner"));
  EXPECT_THAT(RowOf(lanes, "keepout", 0), ElementsAre(0, 100, 100, 0, 0, 0, 0, 0));
  EXPECT_THAT(RowOf(lanes, "keepout", 1), ElementsAre(25, 25, 25, 25, 25, 25, 25, 25));
}

TEST_F(MapAreaTest, ExportsSpeedsThatAMaskCanSay) {
  ImportMap();
  v1::MapArea slow = Box(v1::MapArea::KIND_SPEED_LIMIT, -1, 2, 0, 2.5);
  slow.set_speed_limit_mps(0.3);
  v1::MapArea fast = Box(v1::MapArea::KIND_SPEED_LIMIT, 0, 2, 1, 2.5);
  fast.set_speed_limit_mps(1.5);
  ASSERT_OK(Create("slow", slow));
  ASSERT_OK(Create("fast", fast));
  ASSERT_OK_AND_ASSIGN(const Files files, Export(v1::MAP_AREA_FORMAT_NAV2_SPEED));
  EXPECT_THAT(RowOf(files, "speed", 0), ElementsAre(1, 1, 5, 5, 0, 0, 0, 0));
  EXPECT_THAT(files.at("speed.yaml"), HasSubstr("#   multiplier: 0.3\n"));
  fast.set_speed_limit_mps(0.001);
  fast.set_display_name("Crawl");
  ASSERT_OK(Create("crawl", fast));
  EXPECT_STATUS(Export(v1::MAP_AREA_FORMAT_NAV2_SPEED), absl::StatusCode::kFailedPrecondition, HasSubstr("\"Crawl\""));
}

TEST_F(MapAreaTest, ADeletedMapTakesItsAreasWithIt) {
  ASSERT_OK(Create("a", Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1)));
  v1::DeleteMapRequest request;
  request.set_name(kMap);
  ASSERT_OK(Call(&v1::MapService::Stub::DeleteMap, request));
  EXPECT_CODE(Get("a"), absl::StatusCode::kNotFound);
  EXPECT_CODE(Create("a", Box(v1::MapArea::KIND_ROOM, 0, 0, 1, 1)), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::testing

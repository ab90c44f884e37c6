// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_area_store.h"

#include <gmock/gmock.h>

#include <thread>

#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

using areas::AreaKind;
using storage::MapArea;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class MapAreaStoreTest : public StoreTest {
 protected:
  MapArea Area(const std::string& id, AreaKind kind = AreaKind::kRoom) const {
    MapArea area;
    area.site = site_;
    area.map = map_;
    area.id = MapAreaId(id);
    area.area.kind = kind;
    area.area.display_name = "Area \"" + id + "\"";
    area.area.outline = {{0.1, 0.2}, {4, 1.0 / 3.0}, {4, 3}, {0, 3}};
    return area;
  }
  absl::StatusOr<MapArea> Create(const MapArea& area, const storage::RequestId& request_id = "", bool force = false) {
    return areas_.Create(Soon(), area, request_id, force);
  }
  static std::vector<std::string> Ids(const absl::StatusOr<std::vector<MapArea>>& listed) {
    EXPECT_OK(listed.status());
    std::vector<std::string> ids;
    if (listed.ok()) {
      for (const MapArea& area : *listed) ids.push_back(area.id.value());
    }
    return ids;
  }

  storage::MapAreaStore areas_{*pool_};
};

TEST_F(MapAreaStoreTest, GivesBackWhatWasStored) {
  MapArea area = Area("ramp", AreaKind::kSpeedLimit);
  area.area.robot_types = {"forklift", "cleaner"};
  area.area.speed_limit_mps = 0.3;
  area.area.valid_from = 1'700'000'000'000'001'000;
  area.area.valid_until = 1'800'000'000'000'002'000;
  ASSERT_OK_AND_ASSIGN(const MapArea created, Create(area));
  ASSERT_OK_AND_ASSIGN(const MapArea found, areas_.Get(Soon(), site_, map_, area.id));
  for (const MapArea& stored : {created, found}) {
    EXPECT_EQ(stored.site, site_);
    EXPECT_EQ(stored.map, map_);
    EXPECT_EQ(stored.id, area.id);
    EXPECT_EQ(stored.area.kind, AreaKind::kSpeedLimit);
    EXPECT_EQ(stored.area.display_name, "Area \"ramp\"");
    EXPECT_EQ(stored.area.outline, area.area.outline);
    EXPECT_THAT(stored.area.robot_types, ElementsAre("forklift", "cleaner"));
    EXPECT_EQ(stored.area.speed_limit_mps, 0.3);
    EXPECT_EQ(stored.area.valid_from, area.area.valid_from);
    EXPECT_EQ(stored.area.valid_until, area.area.valid_until);
    EXPECT_GT(stored.etag, 0);
    EXPECT_GT(stored.create_time, 0);
  }
  ASSERT_OK(Create(Area("room")));
  ASSERT_OK_AND_ASSIGN(const MapArea room, areas_.Get(Soon(), site_, map_, MapAreaId("room")));
  EXPECT_FALSE(room.area.valid_from.has_value());
  EXPECT_THAT(room.area.robot_types, IsEmpty());
}

TEST_F(MapAreaStoreTest, NamesWhatIsTakenOrMissing) {
  ASSERT_OK(Create(Area("room")));
  EXPECT_STATUS(Create(Area("room")), absl::StatusCode::kAlreadyExists, HasSubstr("maps/hall/areas/room"));
  MapArea elsewhere = Area("room");
  elsewhere.map = MapId("nowhere");
  EXPECT_STATUS(Create(elsewhere), absl::StatusCode::kNotFound, HasSubstr("maps/nowhere does not exist"));
  EXPECT_STATUS(areas_.Get(Soon(), site_, map_, MapAreaId("none")), absl::StatusCode::kNotFound,
                HasSubstr("areas/none"));
  EXPECT_CODE(areas_.List(Soon(), site_, MapId("nowhere"), {}), absl::StatusCode::kNotFound);
  MapArea crossed = Area("crossed");
  std::swap(crossed.area.outline[0], crossed.area.outline[1]);
  EXPECT_STATUS(Create(crossed), absl::StatusCode::kInvalidArgument, HasSubstr("cross or touch"));
}

TEST_F(MapAreaStoreTest, ARepeatedRequestCreatesNothing) {
  ASSERT_OK_AND_ASSIGN(const MapArea first, Create(Area("a"), storage::RequestId("request", std::string(32, 'x'))));
  ASSERT_OK_AND_ASSIGN(const MapArea again, Create(Area("b"), storage::RequestId("request", std::string(32, 'x'))));
  EXPECT_EQ(again.id, first.id);
  EXPECT_EQ(again.etag, first.etag);
  EXPECT_STATUS(Create(Area("b"), storage::RequestId("request", std::string(32, 'y'))),
                absl::StatusCode::kInvalidArgument, HasSubstr("request_id was used before"));
  EXPECT_THAT(Ids(areas_.List(Soon(), site_, map_, {})), ElementsAre("a"));
}

TEST_F(MapAreaStoreTest, TheSameRequestTwiceAtOnceCreatesOne) {
  std::vector<absl::StatusOr<MapArea>> created(8, absl::UnknownError("not called"));
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < created.size(); ++i) {
    threads.emplace_back([&, i] {
      created[i] = Create(Area("a" + std::to_string(i)), storage::RequestId("same", std::string(32, 'x')));
    });
  }
  threads.clear();
  for (const auto& area : created) {
    ASSERT_OK(area);
    EXPECT_EQ(area->id, created[0]->id);
  }
  EXPECT_EQ(Ids(areas_.List(Soon(), site_, map_, {})).size(), 1U);
}

TEST_F(MapAreaStoreTest, ListsByIdAndByKind) {
  ASSERT_OK(Create(Area("c", AreaKind::kIgnoreHits)));
  ASSERT_OK(Create(Area("a", AreaKind::kIgnoreHits)));
  ASSERT_OK(Create(Area("b", AreaKind::kDock)));
  EXPECT_THAT(Ids(areas_.List(Soon(), site_, map_, {.limit = 2, .after = ""})), ElementsAre("a", "b"));
  EXPECT_THAT(Ids(areas_.List(Soon(), site_, map_, {.limit = 2, .after = "b"})), ElementsAre("c"));
  EXPECT_THAT(Ids(areas_.ListOf(Soon(), site_, map_, AreaKind::kIgnoreHits)), ElementsAre("a", "c"));
  EXPECT_THAT(Ids(areas_.ListOf(Soon(), site_, map_, AreaKind::kKeepOut)), IsEmpty());
  EXPECT_THAT(Ids(areas_.ListOf(Soon(), site_, MapId("nowhere"), AreaKind::kDock)), IsEmpty());
}

TEST_F(MapAreaStoreTest, UpdatesByEtag) {
  ASSERT_OK_AND_ASSIGN(MapArea area, Create(Area("a")));
  const std::int64_t old_etag = area.etag;
  area.area.kind = AreaKind::kSpeedLimit;
  area.area.speed_limit_mps = 1.5;
  area.area.outline = {{0, 0}, {1, 0}, {0, 1}};
  area.area.robot_types = {"forklift"};
  area.area.valid_until = 1'800'000'000'000'000'000;
  ASSERT_OK_AND_ASSIGN(const MapArea updated, areas_.Update(Soon(), area, false));
  EXPECT_NE(updated.etag, old_etag);
  EXPECT_EQ(updated.area.outline, area.area.outline);
  EXPECT_EQ(updated.area.kind, AreaKind::kSpeedLimit);
  EXPECT_EQ(updated.area.valid_until, area.area.valid_until);
  EXPECT_EQ(updated.create_time, area.create_time);
  EXPECT_CODE(areas_.Update(Soon(), area, false), absl::StatusCode::kAborted);
  EXPECT_CODE(areas_.Delete(Soon(), site_, map_, area.id, old_etag), absl::StatusCode::kAborted);
  area.etag = 0;
  EXPECT_OK(areas_.Update(Soon(), area, false));
  area.id = MapAreaId("none");
  EXPECT_CODE(areas_.Update(Soon(), area, false), absl::StatusCode::kNotFound);
  EXPECT_OK(areas_.Delete(Soon(), site_, map_, MapAreaId("a"), 0));
  EXPECT_CODE(areas_.Delete(Soon(), site_, map_, MapAreaId("a"), 0), absl::StatusCode::kNotFound);
}

TEST_F(MapAreaStoreTest, AKeepOutAreaOverLinkPointsIsRefusedUnlessForced) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  // (2, 2) in the hall is inside; that the lab's anchor is there, too, does not matter.
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "inside", {MakeAnchor("hall", 2, 2)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "on-edge", {MakeAnchor("hall", 4, 2)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "outside", {MakeAnchor("hall", 5, 2)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "lab-only", {MakeAnchor("lab", 2, 2)}), ""));
  const auto names_them = AllOf(HasSubstr("linkPoints/inside"), HasSubstr("linkPoints/on-edge"),
                                Not(HasSubstr("outside")), Not(HasSubstr("lab-only")), HasSubstr("set force"));
  const MapArea area = Area("stop", AreaKind::kKeepOut);
  EXPECT_STATUS(Create(area), absl::StatusCode::kFailedPrecondition, names_them);
  EXPECT_CODE(areas_.Get(Soon(), site_, map_, area.id), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(MapArea room, Create(Area("room", AreaKind::kRoom)));
  room.area.kind = AreaKind::kKeepOut;
  EXPECT_STATUS(areas_.Update(Soon(), room, false), absl::StatusCode::kFailedPrecondition, names_them);
  EXPECT_OK(Create(area, "", true));
  EXPECT_OK(areas_.Update(Soon(), room, true));
}

TEST_F(MapAreaStoreTest, AMapHasTenThousandAtMost) {
  database_.Sql(
      "INSERT INTO map_areas (site_id, map_id, area_id, display_name, kind, outline, etag) SELECT 'campus', 'hall',"
      " 'a' || i, 'A', 5, 'POLYGON((0 0, 1 0, 1 1, 0 0))', 1 FROM generate_series(1, 9999) i");
  ASSERT_OK(Create(Area("last")));
  EXPECT_STATUS(Create(Area("more")), absl::StatusCode::kResourceExhausted, HasSubstr("10000 areas"));
  ASSERT_OK(areas_.Delete(Soon(), site_, map_, MapAreaId("a1"), 0));
  EXPECT_OK(Create(Area("more")));
}

TEST_F(MapAreaStoreTest, GoWithTheirMapAndTheirSite) {
  ASSERT_OK(Create(Area("a")));
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM map_areas"), "0");
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, map_, "Hall"), ""));
  ASSERT_OK(Create(Area("a")));
  DeleteSite(site_);
  EXPECT_EQ(database_.SqlValue("SELECT count(*) FROM map_areas"), "0");
}

TEST_F(MapAreaStoreTest, ChangesAreInTheAuditTrailWithTheirActor) {
  storage::CallContext context = Soon();
  context.actor = "ann";
  ASSERT_OK(areas_.Create(context, Area("a"), "", false));
  ASSERT_OK(areas_.Delete(context, site_, map_, MapAreaId("a"), 0));
  ASSERT_OK_AND_ASSIGN(const auto entries, audit_.List(Soon(), site_, "maps/hall/areas/a", 0, 10));
  ASSERT_EQ(entries.size(), 2U);
  for (const storage::AuditEntry& entry : entries) EXPECT_EQ(entry.actor, "ann");
}

}  // namespace
}  // namespace enfilade::testing

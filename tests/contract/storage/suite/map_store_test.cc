// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_store.h"

#include <limits>

#include "core/base/environment.h"
#include "tests/contract/storage/suite/contract_test.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<Eigen::Vector2d> Square(double x, double y, double side) {
  return {{x, y}, {x + side, y}, {x + side, y + side}, {x, y + side}};
}

class MapStoreTest : public StoreContractTest {
 protected:
  storage::Map Get(const std::string& id) {
    const auto map = maps_.Get(Soon(), site_, MapId(id));
    EXPECT_OK(map);
    return *map;
  }
};

TEST_F(MapStoreTest, GivesBackWhatWasStored) {
  storage::Map map = MakeMap(site_, MapId("lab"), "Lab 1/2 \"west\" \xf0\x9f\xa4\x96");
  map.level = -2;
  map.environment = Environment::kOutdoor;
  map.slam_profile = "outdoor-fast";
  map.outline = {{500'000.1, 5'800'000.2}, {500'010.3, 5'800'000.2}, {500'005.0, 5'800'009.4}};
  ASSERT_OK(maps_.Create(Soon(), map, ""));
  const storage::Map stored = Get("lab");
  EXPECT_EQ(stored.display_name, map.display_name);
  EXPECT_EQ(stored.level, -2);
  EXPECT_EQ(stored.environment, Environment::kOutdoor);
  EXPECT_EQ(stored.slam_profile, "outdoor-fast");
  EXPECT_EQ(stored.outline, map.outline);
  EXPECT_EQ(stored.state, storage::MapState::kEmpty);
  EXPECT_EQ(stored.current_revision, 0);
  EXPECT_THAT(Get("hall").outline, IsEmpty());
  ASSERT_OK_AND_ASSIGN(const storage::Map named, maps_.GetByDisplayName(Soon(), site_, map.display_name));
  EXPECT_EQ(named.id, map.id);
  EXPECT_CODE(maps_.GetByDisplayName(Soon(), site_, "lab"), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, SaysWhatIsTaken) {
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, map_, "Other"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("sites/campus/maps/hall exists"));
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(site_, MapId("hall2"), "Hall"), ""), absl::StatusCode::kAlreadyExists,
                HasSubstr("\"Hall\""));
  EXPECT_STATUS(maps_.Create(Soon(), MakeMap(SiteId("nowhere"), map_, "Hall"), ""), absl::StatusCode::kNotFound,
                HasSubstr("sites/nowhere"));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("a"), "A"), "request"));
  ASSERT_OK_AND_ASSIGN(const storage::Map repeated, maps_.Create(Soon(), MakeMap(site_, MapId("b"), "A"), "request"));
  EXPECT_EQ(repeated.id, MapId("a"));
}

TEST_F(MapStoreTest, RefusesOutlinesThatAreNoSimplePolygons) {
  storage::Map map = MakeMap(site_, MapId("m"), "M");
  map.outline = {{0, 0}, {1, 1}, {1, 0}, {0, 1}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("outline"));
  map.outline = {{0, 0}, {1, 1}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("2 corners"));
  map.outline = {{0, 0}, {1, std::numeric_limits<double>::quiet_NaN()}, {1, 0}};
  EXPECT_STATUS(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument, HasSubstr("finite"));
  map.outline = {};
  map.environment = static_cast<Environment>(7);
  EXPECT_CODE(maps_.Create(Soon(), map, ""), absl::StatusCode::kInvalidArgument);
}

TEST_F(MapStoreTest, UpdatesOnlyUnderTheStoredEtag) {
  storage::Map map = Get("hall");
  map.display_name = "Great hall";
  map.level = 3;
  map.outline = Square(0, 0, 10);
  ASSERT_OK_AND_ASSIGN(const storage::Map updated, maps_.Update(Soon(), map));
  EXPECT_EQ(updated.outline, map.outline);
  EXPECT_EQ(Get("hall").level, 3);
  EXPECT_CODE(maps_.Update(Soon(), map), absl::StatusCode::kAborted);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  map.etag = updated.etag;
  map.display_name = "Lab";
  EXPECT_STATUS(maps_.Update(Soon(), map), absl::StatusCode::kAlreadyExists, HasSubstr("\"Lab\""));
  map.id = MapId("nowhere");
  EXPECT_CODE(maps_.Update(Soon(), map), absl::StatusCode::kNotFound);
}

TEST_F(MapStoreTest, IsKeptWhileSessionsMapIntoIt) {
  const SessionId first = NewSession("s1");
  NewSession("s2");
  EXPECT_STATUS(maps_.Delete(Soon(), site_, map_, 0, false), absl::StatusCode::kFailedPrecondition,
                HasSubstr("s1, s2"));
  ASSERT_OK(Append(first, ScanRecords(1, 3)));
  ASSERT_OK_AND_ASSIGN(const auto leased, mapping_.Acquire(Soon(), "worker", std::chrono::seconds(60)));
  ASSERT_TRUE(leased);
  ASSERT_OK(maps_.Delete(Soon(), site_, map_, 0, true));
  EXPECT_CODE(maps_.Get(Soon(), site_, map_), absl::StatusCode::kNotFound);
  EXPECT_CODE(sessions_.Get(Soon(), site_, first), absl::StatusCode::kNotFound);
  EXPECT_CODE(Append(first, {ScanRecord(4)}), absl::StatusCode::kFailedPrecondition);
  EXPECT_CODE(mapping_.Renew(Soon(), leased->lease, std::chrono::seconds(60)), absl::StatusCode::kAborted);
}

TEST_F(MapStoreTest, AMapMadeAgainUnderAnOldIdStartsAnew) {
  for (const char* id : {"a", "b", "c"}) ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
  const TestBlob blob("tile");
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.content_sha256 = blob.sha256();
  revision.tiles = {{{0, 0}, blob.sha256()}};
  ASSERT_OK(revisions_.Add(Soon(), site_, MapId("b"), revision, {blob.view()}));
  const storage::Map old = Get("b");
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("b"), old.etag + 1, false), absl::StatusCode::kAborted);
  ASSERT_OK(maps_.Delete(Soon(), site_, MapId("b"), old.etag, false));
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("b"), 0, false), absl::StatusCode::kNotFound);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("b"), "b"), ""));
  EXPECT_EQ(Get("b").current_revision, 0);
  EXPECT_EQ(Get("b").state, storage::MapState::kEmpty);
  EXPECT_CODE(revisions_.Get(Soon(), site_, MapId("b"), 1), absl::StatusCode::kNotFound);
  ASSERT_OK_AND_ASSIGN(const auto page, maps_.List(Soon(), site_, {2, "a"}));
  ASSERT_EQ(page.size(), 2U);
  EXPECT_EQ(page[0].id, MapId("b"));
  EXPECT_EQ(page[1].id, MapId("c"));
}

TEST_F(MapStoreTest, PagesOfEverySizeListEachMapOnce) {
  for (const char* id : {"b", "a", "a-1", "c"}) ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId(id), id), ""));
  const std::vector<std::string> expected = {"a", "a-1", "b", "c", "hall"};
  for (int limit = 1; limit <= 6; ++limit) {
    std::vector<std::string> listed;
    storage::PageRequest page{limit, ""};
    while (true) {
      ASSERT_OK_AND_ASSIGN(const auto maps, maps_.List(Soon(), site_, page));
      if (maps.empty()) break;
      for (const storage::Map& map : maps) listed.push_back(map.id.value());
      page.after = listed.back();
    }
    EXPECT_EQ(listed, expected) << limit;
  }
  ASSERT_OK_AND_ASSIGN(const auto elsewhere, maps_.List(Soon(), SiteId("nowhere"), {}));
  EXPECT_THAT(elsewhere, IsEmpty());
}

TEST_F(MapStoreTest, AChangeThatFailsMakesNoVersionOfTheGraph) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), "request"));
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  storage::Map lab = Get("lab");
  lab.etag += 100;
  EXPECT_CODE(maps_.Update(Soon(), lab), absl::StatusCode::kAborted);
  lab = Get("lab");
  lab.display_name = "Hall";
  EXPECT_CODE(maps_.Update(Soon(), lab), absl::StatusCode::kAlreadyExists);
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("m9"), 0, true), absl::StatusCode::kNotFound);
  EXPECT_CODE(maps_.Delete(Soon(), site_, MapId("lab"), lab.etag + 100, true), absl::StatusCode::kAborted);
  EXPECT_CODE(maps_.Create(Soon(), MakeMap(site_, MapId("new"), "Hall"), ""), absl::StatusCode::kAlreadyExists);
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab2"), "Lab 2"), "request"));
  EXPECT_EQ(*graph_.GetVersion(Soon(), site_), version);
}

TEST_F(MapStoreTest, ANewLevelChangesTheMapsLinkPoints) {
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("lab"), "Lab"), ""));
  ASSERT_OK(link_points_.Create(Soon(),
                                MakeLinkPoint(site_, "door", {MakeAnchor("hall", 1, 0), MakeAnchor("lab", 0, 0)}), ""));
  ASSERT_OK(link_points_.Create(Soon(), MakeLinkPoint(site_, "elsewhere", {MakeAnchor("hall", 9, 0)}), ""));
  ASSERT_OK_AND_ASSIGN(const std::int64_t version, graph_.GetVersion(Soon(), site_));
  storage::Map lab = Get("lab");
  lab.slam_profile = "fine";
  ASSERT_OK_AND_ASSIGN(lab, maps_.Update(Soon(), lab));
  ASSERT_OK_AND_ASSIGN(const auto same_level, graph_.ReadChanges(Soon(), site_, version));
  EXPECT_THAT(same_level.link_points, IsEmpty());
  lab.level = 2;
  ASSERT_OK(maps_.Update(Soon(), lab));
  ASSERT_OK_AND_ASSIGN(const auto changes, graph_.ReadChanges(Soon(), site_, version));
  ASSERT_EQ(changes.link_points.size(), 1U);
  EXPECT_EQ(changes.link_points[0].point.id, LinkPointId("door"));
  EXPECT_EQ(changes.link_points[0].point.graph_version, version + 2);
}

TEST_F(MapStoreTest, ARequestIdThatWasUsedForSomethingElseIsRefused) {
  const storage::RequestId request("request", std::string(32, 'a'));
  const storage::RequestId other("request", std::string(32, 'b'));
  ASSERT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("r1"), "R 1"), request));
  EXPECT_OK(maps_.Create(Soon(), MakeMap(site_, MapId("r2"), "R 1"), request));
  EXPECT_CODE(maps_.Create(Soon(), MakeMap(site_, MapId("r3"), "R 3"), other).status(),
              absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/placed_link_points.h"

#include <gmock/gmock.h>

#include <limits>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "fmt/format.h"
#include "server/app/graph/site_graph.h"
#include "tests/contract/storage/store_test.h"

namespace enfilade::testing {
namespace {

constexpr int kRounds = 100;
constexpr int kQueriesPerRound = 100;
constexpr int kChangesPerRound = 8;
constexpr int kMaps = 30;
constexpr double kSide = 100.0;  // m, of the area in which the places lie
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string Describe(const storage::StoredLinkPoint& stored) {
  const PoseWithCovariance place = stored.T_world_place.value_or(PoseWithCovariance{});
  return fmt::format("{} {} {} {} {} at ({}, {}, {}) {} etag {} updated {} use {} level {} anchors {}",
                     stored.site.value(), stored.point.id.value(), stored.forced, stored.environment.has_value(),
                     stored.T_world_place.has_value(), place.pose.x, place.pose.y, place.pose.yaw,
                     place.covariance.sum(), stored.etag, stored.update_time, static_cast<int>(stored.point.use),
                     stored.point.difficulty, stored.point.anchors.size());
}

// A site that is changed at random, and its link points in memory, which follow the changes.
class PlacedLinkPointsTest : public StoreTest {
 protected:
  PlacedLinkPointsTest() {
    for (int i = 0; i < kMaps; ++i) {
      storage::Map map = MakeMap(site_, MapId(fmt::format("m{}", i)), fmt::format("m{}", i));
      map.level = i % 3;
      EXPECT_OK(maps_.Create(Soon(), map, ""));
    }
  }

  double Coordinate() { return std::uniform_real_distribution<double>(-kSide / 2.0, kSide / 2.0)(random_); }
  int Pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  MapId RandomMap() { return MapId(fmt::format("m{}", Pick(kMaps))); }

  void CreateLinkPoint() {
    std::vector<graph::Anchor> anchors;
    std::set<MapId> used;
    for (int n = 1 + Pick(3); n > 0; --n) {
      const MapId map = Pick(10) == 0 ? map_ : RandomMap();
      if (used.insert(map).second) anchors.push_back(MakeAnchor(map.value(), Coordinate(), Coordinate()));
    }
    storage::StoredLinkPoint point = MakeLinkPoint(site_, fmt::format("p{}", created_++), anchors);
    point.forced = true;
    EXPECT_OK(link_points_.Create(Soon(), point, ""));
    present_.push_back(point.point.id);
  }

  void ChangeSomething() {
    const int what = present_.size() < 40 ? 0 : Pick(7);
    if (what < 2) return CreateLinkPoint();
    if (what == 6) {
      ASSERT_OK_AND_ASSIGN(storage::Map map, maps_.Get(Soon(), site_, RandomMap()));
      map.level = Pick(3);
      EXPECT_OK(maps_.Update(Soon(), map));
      return;
    }
    const std::size_t i = random_() % present_.size();
    if (what == 2) {
      EXPECT_OK(link_points_.Delete(Soon(), site_, present_[i], 0));
      present_.erase(present_.begin() + static_cast<std::ptrdiff_t>(i));
      return;
    }
    ASSERT_OK_AND_ASSIGN(storage::StoredLinkPoint point, link_points_.Get(Soon(), site_, present_[i]));
    if (what == 3) {
      const bool suspend = point.point.use != graph::LinkPointUse::kSuspended;
      EXPECT_OK(link_points_.SetSuspended(Soon(), site_, present_[i], 0, suspend));
    } else {
      point.point.anchors[0].T_map_place.x = Coordinate();
      EXPECT_OK(link_points_.Update(Soon(), point));
    }
  }

  void Follow() {
    ASSERT_OK_AND_ASSIGN(const storage::GraphChanges changes, graph_.ReadChanges(Soon(), site_, snapshot_.version()));
    if (changes.version == snapshot_.version()) return;
    ASSERT_OK_AND_ASSIGN(graph::GraphSnapshot next, graph::Apply(snapshot_, server::ToSnapshotChanges(changes)));
    placed_ = placed_.With(snapshot_, next, changes);
    snapshot_ = std::move(next);
  }

  storage::LinkPointQuery RandomQuery() {
    storage::LinkPointQuery query;
    if (Pick(3) == 0) {
      const Eigen::Vector2d center(Coordinate(), Coordinate());
      const Eigen::Vector2d a(20.0 + Coordinate() / 10.0, Coordinate() / 5.0);
      query.area =
          std::vector<Eigen::Vector2d>{center, center + a, center + Eigen::Vector2d(Coordinate() / 10.0, 30.0)};
    } else {
      query.area =
          storage::LinkPointCircle{{Coordinate(), Coordinate()}, Pick(4) == 0 ? kInfinity : std::abs(Coordinate())};
    }
    if (Pick(2) == 0) query.level = Pick(3);
    if (Pick(3) == 0) query.candidate = Pick(2) == 0;
    query.with_unused = Pick(2) == 0;
    query.limit = Pick(2) == 0 ? 1000 : 1 + Pick(10);
    return query;
  }

  std::mt19937 random_{20};
  int created_ = 0;
  std::vector<LinkPointId> present_;
  graph::GraphSnapshot snapshot_;
  server::PlacedLinkPoints placed_;
};

TEST_F(PlacedLinkPointsTest, MemoryAnswersRandomQueriesAsTheDatabaseDoes) {
  std::size_t found = 0;
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kChangesPerRound; ++i) ChangeSomething();
    Follow();
    for (int i = 0; i < kQueriesPerRound; ++i) {
      const storage::LinkPointQuery query = RandomQuery();
      ASSERT_OK_AND_ASSIGN(const storage::FoundLinkPoints stored, link_points_.Find(Soon(), site_, query));
      ASSERT_OK_AND_ASSIGN(const auto remembered, placed_.Find(snapshot_, query));
      ASSERT_EQ(stored.graph_version, snapshot_.version());
      ASSERT_EQ(remembered.size(), stored.link_points.size()) << "round " << round << ", query " << i;
      for (std::size_t k = 0; k < remembered.size(); ++k) {
        ASSERT_EQ(Describe(*remembered[k]), Describe(stored.link_points[k])) << "round " << round << ", query " << i;
      }
      found += remembered.size();
    }
    ASSERT_OK_AND_ASSIGN(const auto unplaced, link_points_.ListUnplaced(Soon(), site_, 1000));
    const auto remembered = placed_.ListUnplaced(1000);
    ASSERT_EQ(remembered.size(), unplaced.size());
    for (std::size_t k = 0; k < unplaced.size(); ++k) ASSERT_EQ(remembered[k]->point.id, unplaced[k].point.id);
    ASSERT_OK_AND_ASSIGN(const auto places, graph_.GetPlaces(Soon(), site_, {}));
    std::size_t known = 0;
    for (std::size_t slot = 0; slot < snapshot_.map_slots(); ++slot) {
      if (snapshot_.map_node(static_cast<int>(slot)).map == nullptr) continue;
      known += placed_.PlaceOfMap(static_cast<int>(slot)).has_value() ? 1 : 0;
    }
    ASSERT_EQ(known, places.size());
    for (const storage::MapPose& place : places) {
      EXPECT_EQ(placed_.PlaceOfMap(snapshot_.MapSlot(place.map))->pose, place.T_world_map.pose);
    }
  }
  EXPECT_GT(found, 10'000U) << "the queries find something";
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
#include "server/app/watch/site_updates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/support/status_assertions.h"

namespace enfilade::server {
namespace {

using storage::SessionState;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr TimeNs kNow = 1'800'000'000LL * kNsPerSecond;

// Root "a", then "b", "c" and so on, each behind a door at (`x`, 0) of the one before.
std::shared_ptr<const SiteGraph> MakeRow(std::int64_t version, const std::string& maps, const std::vector<double>& x) {
  graph::SnapshotChanges changes{.version = version, .root = MapId("a")};
  for (const char map : maps) changes.maps.push_back({.id = MapId(std::string(1, map))});
  for (std::size_t i = 0; i < x.size(); ++i) {
    graph::LinkPoint door;
    door.id = LinkPointId(maps.substr(i, 2));
    door.anchors = {{MapId(maps.substr(i, 1)), {x[i], 0, 0}, graph::DefaultAnchorCovariance()},
                    {MapId(maps.substr(i + 1, 1)), {0, 0, 0}, graph::DefaultAnchorCovariance()}};
    changes.link_points.push_back(door);
  }
  auto snapshot = Apply(graph::GraphSnapshot(), changes);
  EXPECT_OK(snapshot);
  return std::make_shared<SiteGraph>(*std::move(snapshot));
}

storage::SessionProgress Session(const std::string& id, std::int64_t acknowledged,
                                 SessionState state = SessionState::kRecording) {
  storage::SessionProgress session;
  session.id = SessionId(id);
  session.robot = RobotId("r");
  session.state = state;
  session.acknowledged_sequence = acknowledged;
  if (state == SessionState::kMapped) session.finish_time = kNow;
  return session;
}

// A site that goes on from moment to moment, and what its watchers are told.
class SiteUpdatesTest : public ::testing::Test {
 protected:
  SiteUpdatesTest() {
    activity_.site_created = kNow - kNsPerSecond;
    activity_.time = kNow;
  }

  std::shared_ptr<const SiteMoment> Moment() {
    SiteMoment moment;
    activity_.time += kNsPerSecond;
    auto poses = Following(last_.poses, graph_, reports_);
    EXPECT_OK(poses);
    moment.poses = *poses;
    auto view = Following(last_.graph, graph_);
    EXPECT_OK(view);
    moment.graph = *view;
    moment.activity = Following(last_.activity, activity_);
    last_ = moment;
    return std::make_shared<const SiteMoment>(moment);
  }
  SiteUpdate Next(SiteUpdates& updates) {
    auto update = updates.Next(Moment(), [this](TimeNs, TimeNs) -> absl::StatusOr<storage::PastActivity> {
      ++past_reads_;
      return past_;
    });
    EXPECT_OK(update);
    return *std::move(update);
  }
  static std::vector<std::string> MapsOf(const SiteUpdate& update) {
    std::vector<std::string> ids;
    for (const GraphView::Map* map : update.maps) ids.push_back(map->map->id.value());
    return ids;
  }
  static std::vector<std::string> LinkPointsOf(const SiteUpdate& update) {
    std::vector<std::string> ids;
    for (const GraphView::LinkPoint* point : update.link_points) ids.push_back(point->link_point->id.value());
    return ids;
  }
  static std::vector<std::string> SessionsOf(const SiteUpdate& update) {
    std::vector<std::string> ids;
    for (const storage::SessionProgress* session : update.sessions) ids.push_back(session->id.value());
    return ids;
  }

  std::shared_ptr<const SiteGraph> graph_ = MakeRow(1, "abcd", {5, 5, 5});
  std::vector<storage::RobotPose> reports_;
  storage::SiteActivity activity_;
  storage::PastActivity past_;
  int past_reads_ = 0;
  SiteMoment last_;
};

TEST_F(SiteUpdatesTest, AMovedDoorMovesTheMapsBehindItOnly) {
  SiteUpdates updates(std::nullopt, {});
  const SiteUpdate first = Next(updates);
  EXPECT_TRUE(first.reset);
  EXPECT_THAT(MapsOf(first), ElementsAre("a", "b", "c", "d"));
  EXPECT_TRUE(Next(updates).empty());
  graph_ = MakeRow(2, "abcd", {5, 6, 5});
  const SiteUpdate moved = Next(updates);
  EXPECT_FALSE(moved.reset);
  EXPECT_THAT(MapsOf(moved), ElementsAre("c", "d"));
  EXPECT_THAT(LinkPointsOf(moved), ElementsAre("bc", "cd"));
  EXPECT_TRUE(Next(updates).empty());
}

TEST_F(SiteUpdatesTest, WhatGoesIsToldAsRemoved) {
  SiteUpdates updates(std::nullopt, {});
  Next(updates);
  graph_ = MakeRow(2, "abc", {5, 5});
  const SiteUpdate update = Next(updates);
  EXPECT_THAT(update.removed_maps, ElementsAre(MapId("d")));
  EXPECT_THAT(update.removed_link_points, ElementsAre(LinkPointId("cd")));
  EXPECT_THAT(MapsOf(update), IsEmpty());
}

TEST_F(SiteUpdatesTest, AMapThatComesBackIsToldAgain) {
  SiteUpdates updates(std::nullopt, {});
  Next(updates);
  const WatchPosition before = updates.position();
  graph_ = MakeRow(2, "abc", {5, 5});
  Next(updates);
  graph_ = MakeRow(3, "abcd", {5, 5, 5});
  EXPECT_THAT(MapsOf(Next(updates)), ElementsAre("d"));
  SiteUpdates resumed(before, {});
  const SiteUpdate update = Next(resumed);
  EXPECT_FALSE(update.reset);
  EXPECT_THAT(update.removed_maps, ElementsAre(MapId("d")));  // removals come first
  EXPECT_THAT(MapsOf(update), ElementsAre("d"));
}

TEST_F(SiteUpdatesTest, ResumesFromAnyVersionThatTheViewKnows) {
  SiteUpdates updates(std::nullopt, {});
  Next(updates);
  const WatchPosition at_1 = updates.position();
  for (std::int64_t version = 2; version <= 20; ++version) {
    graph_ = MakeRow(version, "abcd", {5, 5, 5.0 + static_cast<double>(version)});
    Next(updates);
  }
  SiteUpdates resumed(at_1, {});
  EXPECT_THAT(MapsOf(Next(resumed)), ElementsAre("d"));
  WatchPosition unknown = at_1;
  unknown.graph_version = 0;
  SiteUpdates anew(unknown, {});
  EXPECT_TRUE(Next(anew).reset);
  WatchPosition other_site = at_1;
  other_site.site_created += 1;
  SiteUpdates other(other_site, {});
  EXPECT_TRUE(Next(other).reset);
  WatchPosition old = at_1;
  old.time -= 25 * 3600 * kNsPerSecond;
  SiteUpdates late(old, {});
  EXPECT_TRUE(Next(late).reset);
}

TEST_F(SiteUpdatesTest, SessionsAreToldWhenTheyChange) {
  activity_.sessions = {Session("s1", 1), Session("s2", 1), Session("s3", 9, SessionState::kMapped)};
  SiteUpdates updates(std::nullopt, {});
  EXPECT_THAT(SessionsOf(Next(updates)), ElementsAre("s1", "s2"));
  activity_.sessions = {Session("s1", 1), Session("s2", 7)};
  EXPECT_THAT(SessionsOf(Next(updates)), ElementsAre("s2"));
  activity_.sessions = {Session("s1", 1), Session("s2", 7, SessionState::kMapped), Session("s4", 1)};
  EXPECT_THAT(SessionsOf(Next(updates)), ElementsAre("s2", "s4"));
  activity_.sessions = {Session("s1", 1), Session("s4", 1)};
  EXPECT_TRUE(Next(updates).empty());
  activity_.sessions = {Session("s4", 1)};
  activity_.removed_sessions = {SessionId("s1")};
  EXPECT_THAT(Next(updates).removed_sessions, ElementsAre(SessionId("s1")));
  EXPECT_TRUE(Next(updates).empty()) << "told once, although it is read for a while";
}

TEST_F(SiteUpdatesTest, AResumedWatchHearsOfSessionsThatHaveEndedMeanwhile) {
  activity_.sessions = {Session("s1", 1), Session("s2", 1)};
  SiteUpdates updates(std::nullopt, {});
  Next(updates);
  {
    SiteUpdates quiet(updates.position(), {});
    const SiteUpdate update = Next(quiet);
    EXPECT_THAT(SessionsOf(update), IsEmpty());
    EXPECT_FALSE(update.reset);
    EXPECT_EQ(past_reads_, 1);
  }
  activity_.sessions = {Session("s2", 1)};
  past_.ended = {Session("s1", 5, SessionState::kMapped)};
  past_.removed_sessions = {SessionId("s0")};
  past_.removed_robots = {RobotId("r0")};
  SiteUpdates resumed(updates.position(), {});
  const SiteUpdate update = Next(resumed);
  EXPECT_THAT(SessionsOf(update), UnorderedElementsAre("s1", "s2"));
  EXPECT_THAT(update.removed_sessions, ElementsAre(SessionId("s0")));
  EXPECT_THAT(update.removed_robots, ElementsAre(RobotId("r0")));
}

TEST_F(SiteUpdatesTest, ASiteThatWasCreatedAgainEndsTheWatch) {
  SiteUpdates updates(std::nullopt, {});
  Next(updates);
  activity_.site_created += kNsPerSecond;
  const auto none = [](TimeNs, TimeNs) -> absl::StatusOr<storage::PastActivity> { return storage::PastActivity(); };
  EXPECT_CODE(updates.Next(Moment(), none), absl::StatusCode::kAborted);
}

}  // namespace
}  // namespace enfilade::server

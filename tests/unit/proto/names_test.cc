// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/names.h"

#include <gtest/gtest.h>

#include <iterator>
#include <limits>
#include <string>

#include "tests/support/status_assertions.h"

namespace enfilade::convert {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Names, RoundTrip) {
  ASSERT_OK_AND_ASSIGN(const MapName map, ParseMapName("name", "sites/campus-1/maps/0a"));
  EXPECT_EQ(NameOf(map), "sites/campus-1/maps/0a");
  ASSERT_OK_AND_ASSIGN(const RevisionName revision,
                       ParseMapOrRevisionName("name", "sites/campus-1/maps/0a/revisions/17"));
  EXPECT_EQ(revision.revision, 17);
  EXPECT_EQ(NameOf(revision), "sites/campus-1/maps/0a/revisions/17");
  ASSERT_OK_AND_ASSIGN(const RevisionName newest, ParseMapOrRevisionName("name", "sites/campus-1/maps/0a"));
  EXPECT_EQ(newest.revision, 0);
}

TEST(Names, RefusesEverythingElseNamingFieldAndForm) {
  for (const char* name :
       {"", "sites", "sites/", "sites//maps/x", "sites/a/maps/", "sites/a/maps/b/", "sites/A/maps/b", "sites/a/map/b",
        "sites/a/maps/b/revisions/1", "/sites/a/maps/b", "sites/a/maps/b'; DROP TABLE maps; --", "sites/-a/maps/b"}) {
    EXPECT_STATUS(ParseMapName("map.name", name), absl::StatusCode::kInvalidArgument,
                  AllOf(HasSubstr("map.name"), HasSubstr("sites/{site}/maps/{map}")))
        << name;
  }
  EXPECT_FALSE(ParseRevisionName("name", "sites/a/maps/b/revisions/0").ok());
  EXPECT_FALSE(ParseRevisionName("name", "sites/a/maps/b/revisions/1x").ok());
  EXPECT_FALSE(ParseRevisionName("name", "sites/a/maps/b/revisions/99999999999999999999").ok());
  EXPECT_FALSE(ParseSessionName("name", "sites/a/sessions/" + std::string(64, 'x')).ok());
}

TEST(Names, OfEveryKindComeBackFromTheirText) {
  const SiteId site("campus-1");
  EXPECT_EQ(ParseSiteName("name", enfilade::NameOf(site))->value(), "campus-1");
  ASSERT_OK_AND_ASSIGN(const LinkPointName link_point,
                       ParseLinkPointName("name", NameOf(LinkPointName{site, LinkPointId("door-7")})));
  EXPECT_EQ(link_point.link_point, LinkPointId("door-7"));
  ASSERT_OK_AND_ASSIGN(const RobotName robot, ParseRobotName("name", NameOf(RobotName{site, RobotId("r1")})));
  EXPECT_EQ(robot.robot, RobotId("r1"));
  ASSERT_OK_AND_ASSIGN(const SessionName session,
                       ParseSessionName("name", NameOf(SessionName{site, SessionId("monday")})));
  EXPECT_EQ(session.session, SessionId("monday"));
  for (const std::int64_t number : {std::int64_t{0}, std::int64_t{1}, std::numeric_limits<std::int64_t>::max()}) {
    ASSERT_OK_AND_ASSIGN(const LoopClosureName closure,
                         ParseLoopClosureName("name", NameOf(LoopClosureName{site, SessionId("monday"), number})));
    EXPECT_EQ(closure.closure, number);
    EXPECT_EQ(closure.session, SessionId("monday"));
    EXPECT_EQ(closure.site, site);
  }
  ASSERT_OK_AND_ASSIGN(const DoorVerdictName door,
                       ParseDoorVerdictName("name", NameOf(DoorVerdictName{site, SessionId("monday"), 12})));
  EXPECT_EQ(door.sequence, 12);
  EXPECT_EQ(door.session, SessionId("monday"));
  EXPECT_FALSE(ParseDoorVerdictName("name", "sites/a/sessions/monday/doors/0").ok());
}

// A name of one kind is never taken for one of another.
TEST(Names, OfOneKindAreRefusedAsAnother) {
  const std::string names[] = {
      "sites/s",          "sites/s/maps/x",     "sites/s/maps/x/revisions/1",    "sites/s/linkPoints/x",
      "sites/s/robots/x", "sites/s/sessions/x", "sites/s/sessions/x/closures/1", "sites/s/sessions/x/doors/1"};
  for (const std::string& name : names) {
    const bool accepted[] = {ParseSiteName("n", name).ok(),        ParseMapName("n", name).ok(),
                             ParseRevisionName("n", name).ok(),    ParseLinkPointName("n", name).ok(),
                             ParseRobotName("n", name).ok(),       ParseSessionName("n", name).ok(),
                             ParseLoopClosureName("n", name).ok(), ParseDoorVerdictName("n", name).ok()};
    for (std::size_t kind = 0; kind < std::size(accepted); ++kind) {
      EXPECT_EQ(accepted[kind], name == names[kind]) << name << " as kind " << kind;
    }
  }
}

TEST(Names, ErrorsQuoteAtMostTheBeginningOfAName) {
  const absl::Status status = ParseMapName("map.name", std::string(100'000, 'x')).status();
  EXPECT_LT(status.message().size(), 500U);
}

}  // namespace
}  // namespace enfilade::convert

// SPDX-License-Identifier: Apache-2.0
#include "proto/convert/names.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace enfilade::convert

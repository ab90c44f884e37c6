// SPDX-License-Identifier: Apache-2.0
#include "client/sources/imports/map_manager_database.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>

#include "client/sdk/spool/sqlite.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"

namespace enfilade::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

class MapManagerDatabaseTest : public ::testing::Test {
 protected:
  MapManagerDatabaseTest() {
    // map_manager's schema (dbdriver.cpp).
    Sql("CREATE TABLE MAPS (MAP_ID INT PRIMARY KEY, NAME TEXT NOT NULL, PATH TEXT NOT NULL, STRANDS_DB TEXT,"
        " INDOOR INT NOT NULL);"
        "CREATE TABLE LINKPOINTS (ID INT PRIMARY KEY, TAG TEXT, MAP_ID_0 INT NOT NULL, POS_X_0 REAL NOT NULL,"
        " POS_Y_0 REAL NOT NULL, THETA_0 REAL NOT NULL, MAP_ID_1 INT, POS_X_1 REAL, POS_Y_1 REAL, THETA_1 REAL,"
        " POS_X_WORLD REAL, POS_Y_WORLD REAL, THETA_WORLD REAL, IMAGE_FRONT BLOB, IMAGE_REAR BLOB, DIRECTION INT,"
        " DIFFICULTY INT, ENVIRONMENT INT);"
        "CREATE TABLE LINKPOINTCANDIDATES (ID INT PRIMARY KEY, MAP_ID INT NOT NULL, POS_X REAL NOT NULL,"
        " POS_Y REAL NOT NULL, THETA REAL NOT NULL, POS_X_WORLD REAL NOT NULL, POS_Y_WORLD REAL NOT NULL,"
        " THETA_WORLD REAL NOT NULL, POINTCLOUD_PATH TEXT NOT NULL, IMAGE BLOB NOT NULL, DIFFICULTY INT,"
        " ENVIRONMENT INT);"
        "INSERT INTO MAPS VALUES (0, 'Hall', 'data/0_map_0.db', NULL, 1), (7, 'Yard ''9''', 'p', NULL, 0),"
        " (1000000, 'Far', 'p', NULL, 1)");
  }
  void Sql(const std::string& sql) {
    auto database = client::SqliteDatabase::Open(path());
    ASSERT_OK(database);
    ASSERT_OK(database->Execute(sql));
  }
  std::string path() const { return (directory_.path() / "linkpoints.db").string(); }

  TemporaryDirectory directory_;
};

TEST_F(MapManagerDatabaseTest, ReadsMapsAndLinkPointsOfAnyIds) {
  Sql("INSERT INTO LINKPOINTS VALUES (100, 'a ''door''', 0, 1.5, -2, 4, 7, 0, 0, -1, 0, 0, 0, x'89504e47', x'ff00ff', "
      "7,"
      " 3, 0), (-4, NULL, 7, 1, 1, 0, 1000000, 2, 2, 0, NULL, NULL, NULL, NULL, NULL, NULL, NULL, NULL)");
  ASSERT_OK_AND_ASSIGN(const sources::MapManagerContent content, sources::ReadMapManagerDatabase(path()));
  ASSERT_THAT(content.maps, SizeIs(3));
  EXPECT_EQ(content.maps[1].name, "Yard '9'");
  EXPECT_FALSE(content.maps[1].indoor);
  ASSERT_THAT(content.places, SizeIs(2));
  EXPECT_THAT(content.remarks, SizeIs(0));
  EXPECT_EQ(content.places[0].id, -4);
  EXPECT_EQ(content.places[0].anchors[1].map, 1'000'000);
  EXPECT_FALSE(content.places[0].direction);
  EXPECT_FALSE(content.places[0].indoor);
  const sources::MapManagerPlace& door = content.places[1];
  EXPECT_EQ(door.tag, "a 'door'");
  EXPECT_THAT(door.anchors[0].T_map_place, PoseNear(Pose2{1.5, -2, 4}, 1e-12, 1e-12));
  EXPECT_EQ(door.direction, 7);
  EXPECT_EQ(door.difficulty, 3);
  EXPECT_EQ(door.indoor, false);
  EXPECT_EQ(door.front_image, "\x89PNG");
  EXPECT_EQ(door.rear_image, std::string("\xff\0\xff", 3));
}

TEST_F(MapManagerDatabaseTest, ABrokenRowCostsNoOther) {
  Sql("INSERT INTO LINKPOINTS (ID, MAP_ID_0, POS_X_0, POS_Y_0, THETA_0, MAP_ID_1, POS_X_1, POS_Y_1, THETA_1, DIRECTION)"
      " VALUES (1, 0, 'here', 0, 0, 7, 0, 0, 0, 0), (2, 0, 0, 0, 0, 5, 0, 0, 0, 0), (3, 0, 0, 0, 0, 7, NULL, 0, 0, 0),"
      " (4, 0, 0, 0, 0, 0, 1, 1, 0, 0), (5, 0, 9e999, 0, 0, 7, 0, 0, 0, 0), (6, 0, 1, 2, 3, NULL, NULL, NULL, NULL, 5),"
      " (NULL, 0, 1, 2, 3, 7, 0, 0, 0, 0), (8, 0, 1, 2, 3, 7, 0, 0, 0, 0)");
  ASSERT_OK_AND_ASSIGN(const sources::MapManagerContent content, sources::ReadMapManagerDatabase(path()));
  ASSERT_THAT(content.places, SizeIs(2));
  EXPECT_EQ(content.places[0].id, 6);
  EXPECT_THAT(content.places[0].anchors, SizeIs(1));
  EXPECT_EQ(content.places[1].id, 8);
  std::map<std::string, std::string> refused;
  int remarks = 0;
  for (const sources::MapManagerRemark& remark : content.remarks) {
    if (remark.refused) refused[remark.row] = remark.why;
    if (!remark.refused) ++remarks;
  }
  EXPECT_EQ(remarks, 2) << "row 6: no second map, a direction that is not one of its maps";
  ASSERT_THAT(refused, SizeIs(6));
  EXPECT_THAT(refused["LINKPOINTS 1"], HasSubstr("numbers"));
  EXPECT_THAT(refused["LINKPOINTS 2"], HasSubstr("map 5 is not in MAPS"));
  EXPECT_THAT(refused["LINKPOINTS 3"], HasSubstr("numbers"));
  EXPECT_THAT(refused["LINKPOINTS 4"], HasSubstr("with itself"));
  EXPECT_THAT(refused["LINKPOINTS 5"], HasSubstr("finite"));
}

TEST_F(MapManagerDatabaseTest, ReadsCandidatesCloudsWhereTheyAre) {
  std::filesystem::create_directories(directory_.path() / "data" / "pointclouds");
  std::ofstream(directory_.path() / "named.pcd") << "cloud 1";
  std::ofstream(directory_.path() / "data" / "pointclouds" / "2_pointcloud.pcd") << "cloud 2";
  Sql("INSERT INTO LINKPOINTCANDIDATES VALUES (1, 0, 1, 2, 3, 0, 0, 0, 'named.pcd', x'01', 0, 1),"
      " (2, 0, 5, 2, 3, 0, 0, 0, '/elsewhere/of/another/computer.pcd', x'02', 0, 1),"
      " (3, 7, 1, 2, 3, 0, 0, 0, 'missing.pcd', x'03', 0, 1)");
  ASSERT_OK_AND_ASSIGN(const sources::MapManagerContent content, sources::ReadMapManagerDatabase(path()));
  ASSERT_THAT(content.places, SizeIs(3));
  EXPECT_TRUE(content.places[0].candidate);
  EXPECT_EQ(content.places[0].cloud, "cloud 1");
  EXPECT_EQ(content.places[0].rear_image, "\x01");
  EXPECT_EQ(content.places[1].cloud, "cloud 2");
  EXPECT_EQ(content.places[2].cloud, "");
  ASSERT_THAT(content.remarks, SizeIs(1));
  EXPECT_EQ(content.remarks[0].row, "LINKPOINTCANDIDATES 3");
  EXPECT_FALSE(content.remarks[0].refused);
}

TEST_F(MapManagerDatabaseTest, SaysWhatTheFileIsNot) {
  EXPECT_CODE(sources::ReadMapManagerDatabase(path() + ".none"), absl::StatusCode::kNotFound);
  std::ofstream(directory_.path() / "text.db") << std::string(5000, 'x');
  EXPECT_CODE(sources::ReadMapManagerDatabase((directory_.path() / "text.db").string()), absl::StatusCode::kDataLoss);
  Sql("DROP TABLE LINKPOINTS");
  EXPECT_STATUS(sources::ReadMapManagerDatabase(path()), absl::StatusCode::kInvalidArgument, HasSubstr("LINKPOINTS"));
}

}  // namespace
}  // namespace enfilade::testing

// SPDX-License-Identifier: Apache-2.0
// enfilade localize: which scans it sends, and what it prints.
#include <cmath>

#include "tests/unit/client/cli/server_commands_fixture.h"

namespace enfilade::cli {
namespace {

using ::testing::HasSubstr;

class LocalizeCommandTest : public ServerCommandsTest {
 protected:
  LocalizeCommandTest() {
    server_.localization.localize_robot = [this](const v1::LocalizeRobotRequest& request,
                                                 v1::LocalizeRobotResponse& response) {
      asked_ = request;
      response.set_reason("97 % of the hits lie on walls");
      response.set_maps_searched(2);
      v1::LocatedPose& pose = *response.add_poses();
      pose.set_map("sites/s/maps/h");
      pose.mutable_pose_map_robot()->mutable_pose()->set_x(1.5);
      for (int i = 0; i < 9; ++i) pose.mutable_pose_map_robot()->add_covariance(i % 4 == 0 ? 0.01 : 0.0);
      pose.set_score(0.97);
      pose.set_confident(true);
      v1::LocatedPlace& place = *response.add_places();
      place.set_link_point("sites/s/linkPoints/door");
      place.set_map("sites/s/maps/l");
      place.set_matches(120);
      return grpc::Status::OK;
    };
  }

  // A log of a robot that drives straight on, 0.1 m and 1 s from scan to scan.
  std::string Log(int scans) const {
    std::string text;
    for (int i = 0; i < scans; ++i) {
      text += "FLASER 181";
      for (int beam = 0; beam < 181; ++beam) text += " 2.50";
      const std::string pose = std::to_string(0.1 * i) + " 0 0";
      text += " " + pose + " " + pose + " " + std::to_string(i) + " host " + std::to_string(i) + "\n";
    }
    return File("drive.clf", text);
  }

  v1::LocalizeRobotRequest asked_;
};

TEST_F(LocalizeCommandTest, SendsTheScansOfTheLastMetres) {
  ASSERT_OK(Run({"localize", Log(101)}));
  EXPECT_EQ(asked_.site(), "sites/s");
  ASSERT_EQ(asked_.scans_size(), 11) << "3 m, a scan every 0.3 m";
  EXPECT_NEAR(asked_.scans(10).pose_odom_robot().x(), 10.0, 1e-6);
  EXPECT_NEAR(asked_.scans(0).pose_odom_robot().x(), 7.0, 0.11);
  EXPECT_EQ(asked_.scans(10).scan().ranges_m_size(), 181);
  EXPECT_FALSE(asked_.prior().has_pose_map_robot());
  const nlohmann::json printed = Printed();
  EXPECT_EQ(printed["poses"][0]["map"], "sites/s/maps/h");
  EXPECT_EQ(printed["poses"][0]["confident"], true);
  EXPECT_EQ(printed["poses"][0]["pose_map_robot"]["x"], 1.5);
  EXPECT_EQ(printed["places"][0]["matches"], 120);
  EXPECT_EQ(printed["maps_searched"], 2);
}

TEST_F(LocalizeCommandTest, TakesTheScansAtAMoment) {
  ASSERT_OK(Run({"localize", Log(101), "--at", "40", "--drive", "0"}));
  ASSERT_EQ(asked_.scans_size(), 1);
  EXPECT_NEAR(asked_.scans(0).pose_odom_robot().x(), 4.0, 1e-6);
  ASSERT_OK(Run({"localize", Log(101), "--no-odometry"}));
  ASSERT_EQ(asked_.scans_size(), 1) << "several need odometry";
  EXPECT_FALSE(asked_.scans(0).has_pose_odom_robot());
}

TEST_F(LocalizeCommandTest, PassesOnWhatIsKnown) {
  ASSERT_OK(Run({"localize", Log(3), "--near", "Lab,1,2,0.5", "--sigma", "2", "--level", "1", "--results", "7"}));
  EXPECT_EQ(asked_.prior().map(), "sites/s/maps/l");
  EXPECT_EQ(asked_.prior().pose_map_robot().pose().yaw(), 0.5);
  EXPECT_EQ(asked_.prior().pose_map_robot().covariance(0), 4.0);
  EXPECT_EQ(asked_.prior().level(), 1);
  EXPECT_EQ(asked_.max_results(), 7);
  ASSERT_OK(Run({"localize", Log(3), "--map", "Hall"}));
  EXPECT_EQ(asked_.prior().map(), "sites/s/maps/h");
  EXPECT_FALSE(asked_.prior().has_pose_map_robot());
}

TEST_F(LocalizeCommandTest, SendsAnImage) {
  ASSERT_OK(Run({"localize", "--image", File("view.png", "bytes"), "--rear"}));
  EXPECT_EQ(asked_.scans_size(), 0);
  EXPECT_EQ(asked_.image().content(), "bytes");
  EXPECT_EQ(asked_.image().camera(), v1::Image::CAMERA_REAR);
}

TEST_F(LocalizeCommandTest, PrintsATableForPeople) {
  ASSERT_OK(Run({"localize", Log(3)}, false));
  EXPECT_THAT(printed_, HasSubstr("certain"));
  EXPECT_THAT(printed_, HasSubstr("1.50 0.00 0.00"));
  EXPECT_THAT(printed_, HasSubstr("97 % of the hits"));
}

TEST_F(LocalizeCommandTest, SaysWhatIsMissing) {
  EXPECT_STATUS(Run({"localize"}), absl::StatusCode::kInvalidArgument, HasSubstr("LOG"));
  EXPECT_CODE(Run({"localize", "missing.clf"}), absl::StatusCode::kNotFound);
  EXPECT_STATUS(Run({"localize", Log(3), "--near", "Lab,1,2,0", "--map", "Lab"}), absl::StatusCode::kInvalidArgument,
                HasSubstr("--map"));
  EXPECT_CODE(Run({"localize", Log(3), "--map", "Cellar"}), absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace enfilade::cli

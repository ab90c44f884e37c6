// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/uplink/session_setup.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/fake_server/fake_server.h"
#include "tests/support/status_assertions.h"
#include "tests/support/test_data.h"
#include "tests/unit/client/spool/spool_samples.h"

namespace enfilade::client {
namespace {

using testing::FakeServer;
using testing::SampleSession;

class SessionSetupTest : public ::testing::Test {
 protected:
  SpoolSession Session(const std::string& id, const std::string& map) {
    SpoolSession session = SampleSession(id);
    session.map = map;
    session.request_id = "request-" + id;
    return session;
  }
  // The map that the session was created in, by its resource name.
  std::string MapOf(const SpoolSession& session) {
    const auto created = EnsureSession(connection_, session, true);
    EXPECT_OK(created.status());
    return server_.sessions()["sites/campus/sessions/" + session.id.value()].session.map();
  }

  testing::TemporaryDirectory directory_;
  FakeServer server_{"unix:" + (directory_.path() / "server").string()};
  Connection connection_{server_.address(), std::chrono::seconds(20)};
};

TEST_F(SessionSetupTest, APoseStaysWithTheNameOfItsMapWhenThatIsMerged) {
  EXPECT_EQ(MapOf(Session("s1", "hall")), "sites/campus/maps/hall");
  EXPECT_EQ(MapOf(Session("s2", "yard")), "sites/campus/maps/yard");
  server_.Redirect("sites/campus/maps/hall", "sites/campus/maps/yard");
  SpoolSession located = Session("s3", "hall");
  located.entry.T_map_robot = PoseWithCovariance{{1.0, 2.0, 0.5}, 0.01 * Eigen::Matrix3d::Identity()};
  EXPECT_EQ(MapOf(located), "sites/campus/maps/hall") << "the server moves the pose with the name";
  EXPECT_EQ(MapOf(located), "sites/campus/maps/hall") << "asked again";
  EXPECT_EQ(MapOf(Session("s4", "hall")), "sites/campus/maps/yard") << "without a pose there is nothing to move";
}

}  // namespace
}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#include "client/robot/upload/session_follower.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/fake_server/fake_server.h"
#include "tests/support/test_data.h"

namespace enfilade::robot {
namespace {

using ::testing::ElementsAre;
using testing::FakeServer;

class SessionFollowerTest : public ::testing::Test {
 protected:
  // Mapped and judged, but not surveyed.
  void Follow(const std::string& id) {
    server_.Edit(NameOf(id), [&](FakeServer::Session& edited) {
      edited.session.set_name(NameOf(id));
      edited.session.set_map("sites/s/maps/m");
      edited.session.set_state(v1::Session::STATE_MAPPED);
    });
    follower_.Add(SessionId(id));
  }
  void Survey(const std::string& id) {
    server_.Edit(NameOf(id), [](FakeServer::Session& edited) { edited.session.set_surveyed(true); });
  }
  static std::string NameOf(const std::string& id) { return "sites/s/sessions/" + id; }
  // How often each of the sessions was asked for.
  std::vector<int> Asked() {
    std::vector<int> counts;
    for (const auto& [name, session] : server_.sessions()) counts.push_back(session.asked);
    return counts;
  }

  testing::TemporaryDirectory directory_;
  FakeServer server_{"unix:" + (directory_.path() / "server").string(), {.surveys_sites = true}};
  int expected_verdicts_ = 0;
  SessionFollower follower_{client::Connection(server_.address(), std::chrono::seconds(60)),
                            convert::RobotName{SiteId("s"), RobotId("r1")},
                            [](const Notification&) {},
                            {.expected_verdicts = [this](const SessionId&) { return expected_verdicts_; },
                             .on_map_entered = [](const SessionId&, const v1::MapEntered&) {}}};
};

TEST_F(SessionFollowerTest, OfSessionsThatAwaitASurveyOnlyTheFirstIsAskedFor) {
  for (const char* id : {"a", "b", "c"}) Follow(id);
  follower_.Poll();
  EXPECT_THAT(Asked(), ElementsAre(1, 1, 1));
  for (int i = 0; i < 5; ++i) follower_.Poll();
  EXPECT_THAT(Asked(), ElementsAre(6, 1, 1));
  Follow("d");
  follower_.Poll();
  EXPECT_THAT(Asked(), ElementsAre(7, 1, 1, 1)) << "a new one is asked for";
  for (const char* id : {"a", "b", "c"}) Survey(id);
  follower_.Poll();
  EXPECT_EQ(follower_.size(), 1) << "all that the survey has seen are done";
  Survey("d");
  follower_.Poll();
  EXPECT_EQ(follower_.size(), 0);
}

TEST_F(SessionFollowerTest, SessionsWhoseDoorsAreNotJudgedAreAllAskedFor) {
  expected_verdicts_ = 1;
  for (const char* id : {"a", "b"}) Follow(id);
  for (int i = 0; i < 3; ++i) follower_.Poll();
  EXPECT_THAT(Asked(), ElementsAre(3, 3));
}

}  // namespace
}  // namespace enfilade::robot

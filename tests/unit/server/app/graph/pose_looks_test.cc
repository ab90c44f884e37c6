// SPDX-License-Identifier: Apache-2.0
#include "server/app/graph/pose_looks.h"

#include <atomic>
#include <latch>

#include "tests/unit/server/app/graph/graph_test.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

// Counts how often poses are listed, and holds that up on request.
class ListedPoseStore final : public storage::RobotPoseStore {
 public:
  explicit ListedPoseStore(const storage::RobotPoseStore& store) : store_(store) {}

  std::vector<absl::Status> ReportAll(const storage::CallContext& context,
                                      const std::vector<storage::RobotPose>& poses) const override {
    return store_.ReportAll(context, poses);
  }
  absl::StatusOr<storage::RobotPose> Get(const storage::CallContext& context, const SiteId& site,
                                         const RobotId& robot) const override {
    return store_.Get(context, site, robot);
  }
  absl::StatusOr<std::vector<storage::RobotPose>> List(const storage::CallContext& context,
                                                       const SiteId& site) const override {
    ++lists_;
    if (gate_ != nullptr) gate_->wait();
    return store_.List(context, site);
  }

  void set_gate(std::latch* gate) { gate_ = gate; }  // while nobody lists
  int lists() const { return lists_; }

 private:
  const storage::RobotPoseStore& store_;
  std::latch* gate_ = nullptr;
  mutable std::atomic<int> lists_ = 0;
};

class PoseLooksTest : public AppGraphTest {
 protected:
  PoseLooksTest() {
    StartListening();
    stores_.database.AddRobot(site_, RobotId("r"));
    storage::RobotPose report{site_, RobotId("r"), MapId("b"), std::nullopt, {}, 1, 0};
    report.T_map_robot.covariance = Eigen::Vector3d(0.1, 0.1, 0.1).asDiagonal();
    EXPECT_OK(stores_.robot_poses.Report(Soon(), report));
  }

  PoseLooks::Result LookNow(PoseLooks& looks, const SiteId& site) {
    PoseLooks::Result result;
    std::latch done(1);
    looks.Look(site, [&](const PoseLooks::Result& look) {
      result = look;
      done.count_down();
    });
    done.wait();
    return result;
  }

  ListedPoseStore listed_{stores_.robot_poses};
};

TEST_F(PoseLooksTest, OneLookServesOneWatcherAsWellAsTwoHundred) {
  PoseLooks looks(*graphs_, listed_, {.fresh = std::chrono::seconds(0)});
  for (const int watchers : {1, 200}) {
    const int before = listed_.lists();
    std::latch gate(1), answered(watchers);
    listed_.set_gate(&gate);
    std::atomic<const SitePoses*> seen = nullptr;
    for (int i = 0; i < watchers; ++i) {
      looks.Look(site_, [&](const PoseLooks::Result& look) {
        ASSERT_OK(look);
        ASSERT_THAT((*look)->robots, SizeIs(1));
        const SitePoses* const first = seen.exchange(look->get());
        EXPECT_TRUE(first == nullptr || first == look->get());
        answered.count_down();
      });
    }
    EXPECT_EQ(seen, nullptr);
    gate.count_down();
    answered.wait();
    EXPECT_EQ(listed_.lists() - before, 1) << watchers;
  }
}

TEST_F(PoseLooksTest, AFreshLookServesTheNextWatcherAsWell) {
  PoseLooks looks(*graphs_, listed_, {.fresh = std::chrono::hours(1)});
  ASSERT_OK_AND_ASSIGN(const PoseLooks::Watcher watcher, looks.Admit(site_));
  ASSERT_OK_AND_ASSIGN(const auto first, LookNow(looks, site_));
  ASSERT_OK_AND_ASSIGN(const auto second, LookNow(looks, site_));
  EXPECT_EQ(first, second);
  EXPECT_EQ(listed_.lists(), 1);
}

TEST_F(PoseLooksTest, TellsWhatIsWrongAndLooksAgainNextTime) {
  PoseLooks looks(*graphs_, listed_, {.fresh = std::chrono::hours(1)});
  EXPECT_CODE(LookNow(looks, SiteId("nowhere")), absl::StatusCode::kNotFound);
  stores_.database.AddSite(SiteId("nowhere"));
  EXPECT_OK(LookNow(looks, SiteId("nowhere")));
}

TEST_F(PoseLooksTest, LimitsTheWatchersOfASiteAndInAll) {
  PoseLooks looks(*graphs_, listed_, {.max_per_site = 2, .max_in_all = 3});
  ASSERT_OK_AND_ASSIGN(PoseLooks::Watcher first, looks.Admit(site_));
  ASSERT_OK_AND_ASSIGN(const PoseLooks::Watcher second, looks.Admit(site_));
  EXPECT_STATUS(looks.Admit(site_), absl::StatusCode::kResourceExhausted, HasSubstr("try again in a minute"));
  ASSERT_OK_AND_ASSIGN(PoseLooks::Watcher third, looks.Admit(other_site_));
  EXPECT_STATUS(looks.Admit(other_site_), absl::StatusCode::kResourceExhausted, HasSubstr("this server"));
  first.reset();
  EXPECT_OK(looks.Admit(other_site_));
  ASSERT_OK_AND_ASSIGN(first, looks.Admit(site_));
  EXPECT_CODE(looks.Admit(site_), absl::StatusCode::kResourceExhausted);
}

}  // namespace
}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/app/ingest/pose_reports.h"

#include <gmock/gmock.h>

#include <atomic>
#include <latch>
#include <memory>
#include <optional>
#include <thread>

#include "fmt/format.h"
#include "tests/fakes/in_memory_stores.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/server/app/test_values.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;

// Counts the batches, and holds those of one site up on request.
class CountingPoseStore final : public storage::RobotPoseStore {
 public:
  explicit CountingPoseStore(const storage::RobotPoseStore& store) : store_(store) {}

  std::vector<absl::Status> ReportAll(const storage::CallContext& context,
                                      const std::vector<storage::RobotPose>& poses) const override {
    ++batches_;
    last_actor_ = context.actor;
    if (held_ && poses.front().site == *held_) released_.wait();
    return store_.ReportAll(context, poses);
  }
  absl::StatusOr<storage::RobotPose> Get(const storage::CallContext& context, const SiteId& site,
                                         const RobotId& robot) const override {
    return store_.Get(context, site, robot);
  }
  absl::StatusOr<std::vector<storage::RobotPose>> List(const storage::CallContext& context,
                                                       const SiteId& site) const override {
    return store_.List(context, site);
  }

  void Hold(const SiteId& site) { held_ = site; }  // before the first report
  void LetGo() { released_.count_down(); }
  int batches() const { return batches_; }
  const std::string& last_actor() const { return last_actor_; }  // once all is answered

 private:
  const storage::RobotPoseStore& store_;
  std::optional<SiteId> held_;
  mutable std::latch released_{1};
  mutable std::atomic<int> batches_ = 0;
  mutable std::string last_actor_;
};

class PoseReportsTest : public ::testing::Test {
 protected:
  static constexpr int kRobots = 200;

  void SetUp() override {
    for (const SiteId& site : {site_, other_site_}) {
      stores_.database.AddSite(site);
      ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site, "m"), ""));
      for (int i = 0; i < kRobots; ++i) stores_.database.AddRobot(site, Robot(i));
    }
  }

  static RobotId Robot(int i) { return RobotId(fmt::format("r{}", i)); }

  static storage::RobotPose PoseOf(const SiteId& site, int robot, TimeNs time = 1) {
    storage::RobotPose pose{site, Robot(robot), MapId("m"), std::nullopt, {}, time, 0};
    pose.T_map_robot.covariance = Eigen::Vector3d(0.1, 0.1, 0.1).asDiagonal();
    return pose;
  }

  const SiteId site_{"s"};
  const SiteId other_site_{"t"};
  testing::InMemoryStores stores_;
  CountingPoseStore counted_{stores_.robot_poses};
};

TEST_F(PoseReportsTest, StoresTheReportsOfManyRobotsTogetherAndAnswersEach) {
  PoseReports reports(counted_, {.gather = std::chrono::seconds(1)});
  std::latch answered(kRobots + 1);
  std::atomic<int> stored = 0;
  for (int i = 0; i < kRobots; ++i) {
    reports.Report(PoseOf(site_, i), fmt::format("robot {}", i), [&](const absl::Status& status) {
      stored += status.ok() ? 1 : 0;
      answered.count_down();
    });
  }
  absl::Status refused;
  reports.Report(PoseOf(site_, kRobots), "", [&](const absl::Status& status) {
    refused = status;
    answered.count_down();
  });
  answered.wait();
  EXPECT_EQ(stored, kRobots);
  EXPECT_STATUS(refused, absl::StatusCode::kNotFound, HasSubstr(fmt::format("r{}", kRobots)));
  EXPECT_LE(counted_.batches(), 5) << "one, unless this machine stalls";
  EXPECT_EQ(counted_.last_actor(), "");
  const auto listed = stores_.robot_poses.List(Soon(), site_);
  ASSERT_OK(listed);
  EXPECT_EQ(listed->size(), static_cast<std::size_t>(kRobots));
}

TEST_F(PoseReportsTest, ABlockedSiteHoldsNoOtherUpAndGathersMeanwhile) {
  counted_.Hold(site_);
  PoseReports reports(counted_, {.gather = std::chrono::milliseconds(1)});
  std::latch first(1), all(1 + kRobots);
  std::atomic<int> of_blocked = 0;
  const auto count = [&](const absl::Status& status) {
    EXPECT_OK(status);
    ++of_blocked;
    all.count_down();
  };
  reports.Report(PoseOf(site_, 0), "ann", count);
  while (counted_.batches() == 0) std::this_thread::yield();
  for (int i = 0; i < kRobots; ++i) reports.Report(PoseOf(site_, i, 2), "ann", count);
  reports.Report(PoseOf(other_site_, 0), "bob", [&](const absl::Status& status) {
    EXPECT_OK(status);
    first.count_down();
  });
  first.wait();
  EXPECT_EQ(of_blocked, 0);
  counted_.LetGo();
  all.wait();
  EXPECT_EQ(counted_.batches(), 3);
  EXPECT_EQ(counted_.last_actor(), "ann");
}

TEST_F(PoseReportsTest, RefusesWhatIsTooManyAndStoresWhatWaitsWhenItStops) {
  PoseReports reports(counted_, {.gather = std::chrono::hours(1), .max_batch = 2, .max_waiting = 5});
  std::atomic<int> stored = 0;
  const auto count = [&](const absl::Status& status) { stored += status.ok() ? 1 : 0; };
  for (int i = 0; i < 5; ++i) reports.Report(PoseOf(site_, i), "", count);
  absl::Status refused;
  const auto refuse = [&](const absl::Status& status) { refused = status; };
  reports.Report(PoseOf(site_, 5), "", refuse);
  EXPECT_STATUS(refused, absl::StatusCode::kResourceExhausted, HasSubstr("later"));
  EXPECT_EQ(stored, 0);
  reports.Stop();
  EXPECT_EQ(stored, 5);
  EXPECT_EQ(counted_.batches(), 3);
  reports.Report(PoseOf(site_, 6), "", refuse);
  EXPECT_CODE(refused, absl::StatusCode::kUnavailable);
}

}  // namespace
}  // namespace enfilade::server

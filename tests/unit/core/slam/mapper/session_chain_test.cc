// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/session_chain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/slam/mapper/mapper.h"
#include "core/slam/state/checkpoint.h"
#include "tests/support/pose_matchers.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/slam/ring_of_corridors.h"
#include "tests/unit/core/slam/synthetic_drive.h"

namespace enfilade::slam {
namespace {

using testing::kPoorOdometry;
using testing::PoseNear;
using testing::RingOfCorridors;
using testing::TwoRounds;
using Log = std::vector<sensor::PairedScan>;

// One after another, as equal in length as possible.
std::vector<Log> InParts(const Log& log, std::size_t count) {
  std::vector<Log> parts;
  for (std::size_t i = 0; i < count; ++i) {
    parts.emplace_back(log.begin() + static_cast<std::ptrdiff_t>(i * log.size() / count),
                       log.begin() + static_cast<std::ptrdiff_t>((i + 1) * log.size() / count));
  }
  return parts;
}

ChainedSession MapSession(const Log& log, const SlamOptions& options = {}) {
  Mapper mapper(options);
  for (const sensor::PairedScan& scan : log) mapper.AddScan(scan);
  mapper.Finish();
  ChainedSession session;
  session.map.Apply(mapper.TakeDelta());
  session.errors = *DecodeErrors(mapper.Checkpoint());
  for (const sensor::PairedScan& scan : log) {
    const bool is_keyframe = std::any_of(session.map.nodes.begin(), session.map.nodes.end(),
                                         [&](const auto& node) { return node.second.sequence == scan.sequence; });
    if (is_keyframe || scan.sequence == log.back().sequence) session.scans.push_back(scan);
  }
  return session;
}

std::vector<ChainedSession> MapSessions(const Log& log, std::size_t count) {
  std::vector<ChainedSession> sessions;
  for (const Log& part : InParts(log, count)) sessions.push_back(MapSession(part));
  return sessions;
}

ChainedMap ChainOf(const std::vector<ChainedSession>& sessions, const std::optional<ExistingMap>& existing = {}) {
  SessionChain chain({}, existing);
  for (const ChainedSession& session : sessions) EXPECT_OK(chain.Append(session));
  return chain.Finish();
}

// m, after the first pose.
double WorstError(const std::vector<StampedPose>& trajectory, const std::vector<Pose2>& truth) {
  double worst = 0.0;
  for (std::size_t i = 0; i < trajectory.size(); ++i) {
    const Pose2 T_first_now = Between(trajectory.front().T_map_robot, trajectory[i].T_map_robot);
    worst = std::max(worst, Between(Between(truth.front(), truth[i]), T_first_now).translation().norm());
  }
  return worst;
}

void ExpectEqual(const ChainedMap& a, const ChainedMap& b) {
  EXPECT_EQ(a.grid, b.grid);
  EXPECT_EQ(a.variance_factor, b.variance_factor);
  ASSERT_EQ(a.trajectory.size(), b.trajectory.size());
  for (std::size_t i = 0; i < a.trajectory.size(); ++i) {
    EXPECT_EQ(a.trajectory[i].time, b.trajectory[i].time);
    EXPECT_EQ(a.trajectory[i].T_map_robot, b.trajectory[i].T_map_robot);
  }
}

TEST(SessionChain, ClosesLoopsAcrossSessionsAsOneMapDoes) {
  const std::vector<Pose2> truth = TwoRounds();
  const Log log = testing::Record(RingOfCorridors(), truth, {}, kPoorOdometry, 3);
  double odometry = 0.0;
  for (std::size_t i = 0; i < log.size(); ++i) {
    odometry = std::max(odometry, (Between(truth.front(), truth[i]).translation() -
                                   Between(*log.front().T_odom_robot, *log[i].T_odom_robot).translation())
                                      .norm());
  }
  ASSERT_GT(odometry, 1.0);
  const double one_map = WorstError(TrajectoryOf(MapSession(log).map), truth);
  for (const std::size_t sessions : {2U, 7U, 20U}) {
    const ChainedMap chained = ChainOf(MapSessions(log, sessions));
    ASSERT_EQ(chained.trajectory.size(), log.size()) << sessions;
    EXPECT_LT(WorstError(chained.trajectory, truth), one_map + 0.06) << sessions;
    EXPECT_FALSE(chained.grid.cells.empty());
  }
}

TEST(SessionChain, AskingForTheMapInBetweenChangesNothing) {
  const std::vector<ChainedSession> sessions =
      MapSessions(testing::Record(RingOfCorridors(), TwoRounds(), {}, kPoorOdometry, 4), 6);
  SessionChain chain({}, std::nullopt);
  for (const ChainedSession& session : sessions) {
    ASSERT_OK(chain.Append(session));
    chain.Finish();
  }
  const ChainedMap in_between = chain.Finish();
  ExpectEqual(in_between, ChainOf(sessions));
  ExpectEqual(in_between, chain.Finish());
}

TEST(SessionChain, OneSessionKeepsItsOwnMap) {
  const ChainedSession session = MapSession(testing::Record(RingOfCorridors(), TwoRounds(), {}, kPoorOdometry, 5));
  const std::vector<StampedPose> own = TrajectoryOf(session.map);
  const ChainedMap chained = ChainOf({session});
  ASSERT_EQ(chained.trajectory.size(), own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_THAT(chained.trajectory[i].T_map_robot, PoseNear(own[i].T_map_robot, 0.01, 0.002)) << i;
  }
}

TEST(SessionChain, TiesSessionsWithoutOdometryByTheirScans) {
  const std::vector<Pose2> truth = TwoRounds();
  Log log = testing::Record(RingOfCorridors(), truth, {}, {}, 6);
  for (sensor::PairedScan& scan : log) scan.T_odom_robot.reset();
  EXPECT_LT(WorstError(ChainOf(MapSessions(log, 6)).trajectory, truth), 0.15);
}

TEST(SessionChain, TiesSessionsByTheirScansIfOdometryBeginsAnew) {
  const std::vector<Pose2> truth = TwoRounds();
  std::vector<Log> parts = InParts(testing::Record(RingOfCorridors(), truth, {}, {}, 7), 2);
  const Pose2 anew = Inverse(*parts[1].front().T_odom_robot);
  for (sensor::PairedScan& scan : parts[1]) scan.T_odom_robot = Pose2{100.0, 0.0, 0.0} * anew * *scan.T_odom_robot;
  EXPECT_LT(WorstError(ChainOf({MapSession(parts[0]), MapSession(parts[1])}).trajectory, truth), 0.15);
}

TEST(SessionChain, BeginsInAnExistingMap) {
  const std::vector<Pose2> truth = TwoRounds();
  const Log log = testing::Record(RingOfCorridors(), truth, {}, {}, 8);
  const ChainedMap before = ChainOf(MapSessions(log, 4));
  // Beginning 0.3 m from where it is said to be.
  PoseWithCovariance start{{0.25, -0.15, 0.03}, Eigen::Matrix3d::Zero()};
  start.covariance.diagonal() << 0.09, 0.09, 0.0025;
  const std::vector<ChainedSession> second =
      MapSessions(testing::Record(RingOfCorridors(), truth, {}, kPoorOdometry, 9), 6);
  const ChainedMap chained = ChainOf(second, ExistingMap{before.grid, {start, std::nullopt}});
  ASSERT_EQ(chained.trajectory.size(), before.trajectory.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_THAT(chained.trajectory[i].T_map_robot, PoseNear(Between(truth.front(), truth[i]), 0.15, 0.04)) << i;
  }
}

TEST(SessionChain, KnowsItsErrorsAsOneMapDoes) {
  for (const double sigma : {0.005, 0.03}) {
    const testing::SyntheticScanner scanner{.range_sigma = sigma};
    const Log log = testing::Record(RingOfCorridors(), TwoRounds(), scanner, {0.01, 0.01}, 10);
    Mapper mapper{SlamOptions()};
    for (const sensor::PairedScan& scan : log) mapper.AddScan(scan);
    mapper.Finish();
    const double chained = ChainOf(MapSessions(log, 6)).variance_factor;
    EXPECT_GT(chained, mapper.variance_factor() / 2.0) << sigma;
    EXPECT_LT(chained, mapper.variance_factor() * 2.0) << sigma;
  }
}

TEST(SessionChain, WithoutSessionsIsEmpty) {
  SessionChain chain({}, std::nullopt);
  ASSERT_OK(chain.Append({}));
  const ChainedMap empty = chain.Finish();
  EXPECT_TRUE(empty.grid.cells.empty());
  EXPECT_TRUE(empty.trajectory.empty());
}

class RefusedSessionTest : public ::testing::Test {
 protected:
  // Nothing of it may remain.
  void ExpectRefused(const ChainedSession& session, absl::StatusCode code) {
    SessionChain chain({}, std::nullopt);
    ASSERT_OK(chain.Append(sessions_[0]));
    EXPECT_CODE(chain.Append(session), code);
    ASSERT_OK(chain.Append(sessions_[1]));
    ExpectEqual(chain.Finish(), ChainOf(sessions_));
  }

  const Log log_ = testing::Record(RingOfCorridors(), TwoRounds(), {}, {}, 11);
  const std::vector<ChainedSession> sessions_ = MapSessions(log_, 2);
  ChainedSession refused_ = sessions_[1];
};

TEST_F(RefusedSessionTest, ASubmapThatIsNotFinished) {
  refused_.map.submaps.rbegin()->second.finished = false;
  ExpectRefused(refused_, absl::StatusCode::kFailedPrecondition);
}

TEST_F(RefusedSessionTest, ASubmapThatIsMissing) {
  ASSERT_GT(refused_.map.submaps.size(), 2U);
  refused_.map.submaps.erase(1);
  ExpectRefused(refused_, absl::StatusCode::kFailedPrecondition);
}

TEST_F(RefusedSessionTest, KeyframesThatAreMissing) {
  const std::int64_t submap = refused_.map.nodes.begin()->second.submap;
  std::erase_if(refused_.map.nodes, [&](const auto& node) { return node.second.submap == submap; });
  ExpectRefused(refused_, absl::StatusCode::kFailedPrecondition);
}

TEST_F(RefusedSessionTest, SubmapsOfAnotherResolution) {
  SlamOptions coarse;
  coarse.resolution = 0.1;
  ExpectRefused(MapSession(InParts(log_, 2)[1], coarse), absl::StatusCode::kFailedPrecondition);
}

TEST_F(RefusedSessionTest, ASubmapThatIsDamaged) {
  refused_.map.submaps.rbegin()->second.content.resize(20);
  ExpectRefused(refused_, absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace enfilade::slam

// SPDX-License-Identifier: Apache-2.0
#include "server/app/mapping/mapping.h"

#include <atomic>
#include <new>
#include <optional>
#include <thread>

#include "fmt/format.h"
#include "tests/unit/server/app/mapping/mapping_fixture.h"

namespace enfilade::server {
namespace {

using ::testing::HasSubstr;
using State = storage::SessionState;

// Counts how often work is looked for, and a session's results are loaded.
class CountingMappingStore final : public storage::MappingStore {
 public:
  explicit CountingMappingStore(const storage::MappingStore& store) : store_(store) {}

  int looks() const { return looks_; }
  int loads() const { return loads_; }
  int commits() const { return commits_; }
  std::int64_t read_sequence() const { return read_sequence_; }  // of the last turn

  absl::StatusOr<std::optional<storage::LeasedSession>> Acquire(const storage::CallContext& context,
                                                                const std::string& owner,
                                                                std::chrono::milliseconds ttl) const override {
    ++looks_;
    return store_.Acquire(context, owner, ttl);
  }
  absl::Status Renew(const storage::CallContext& context, const storage::SessionLease& lease,
                     std::chrono::milliseconds ttl) const override {
    return store_.Renew(context, lease, ttl);
  }
  absl::Status Release(const storage::CallContext& context, const storage::SessionLease& lease,
                       std::int64_t read_sequence) const override {
    read_sequence_ = read_sequence;
    return store_.Release(context, lease, read_sequence);
  }
  absl::Status Queue(const storage::CallContext& context, const SiteId& site, const SessionId& session) const override {
    return store_.Queue(context, site, session);
  }
  absl::StatusOr<storage::MappingBacklog> GetBacklog(const storage::CallContext& context) const override {
    return store_.GetBacklog(context);
  }
  absl::StatusOr<std::int64_t> Commit(const storage::CallContext& context, const storage::SessionLease& lease,
                                      const storage::MappingStep& step) const override {
    ++commits_;
    return store_.Commit(context, lease, step);
  }
  absl::StatusOr<std::optional<storage::StoredMapping>> Load(const storage::CallContext& context, const SiteId& site,
                                                             const SessionId& session) const override {
    ++loads_;
    return store_.Load(context, site, session);
  }
  absl::StatusOr<storage::Trajectory> ReadTrajectory(const storage::CallContext& context, const SiteId& site,
                                                     const SessionId& session) const override {
    return store_.ReadTrajectory(context, site, session);
  }
  absl::StatusOr<std::vector<slam::SlamNode>> ListKeyframes(const storage::CallContext& context, const SiteId& site,
                                                            const SessionId& session) const override {
    return store_.ListKeyframes(context, site, session);
  }
  absl::StatusOr<std::optional<PoseWithCovariance>> FindKeyframe(const storage::CallContext& context,
                                                                 const SiteId& site, const SessionId& session,
                                                                 TimeNs time) const override {
    return store_.FindKeyframe(context, site, session, time);
  }

 private:
  const storage::MappingStore& store_;
  mutable std::atomic<int> looks_{0};
  mutable std::atomic<int> loads_{0};
  mutable std::atomic<int> commits_{0};
  mutable std::atomic<std::int64_t> read_sequence_{0};
};

// Throws or waits when the records of one session are read.
class FaultyRecordStore final : public storage::RecordStore {
 public:
  explicit FaultyRecordStore(const storage::RecordStore& store) : store_(store) {}

  void ThrowFor(const SessionId& session) { poison_ = session; }
  int throws() const { return throws_; }
  void HoldUp(const SessionId& session) { held_up_ = session; }
  void LetGo() { let_go_ = true; }
  bool is_waiting() const { return waiting_; }

  std::vector<absl::StatusOr<storage::AppendResult>> AppendGroup(
      const storage::CallContext& context, absl::Span<const storage::RecordBatch> batches) const override {
    return store_.AppendGroup(context, batches);
  }
  absl::StatusOr<std::vector<sensor::Record>> Read(const storage::CallContext& context, const SiteId& site,
                                                   const SessionId& session, std::int64_t from_sequence,
                                                   std::int64_t max_bytes) const override {
    if (session == poison_) {
      ++throws_;
      throw std::bad_alloc();
    }
    waiting_ = session == held_up_;
    while (waiting_ && !let_go_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return store_.Read(context, site, session, from_sequence, max_bytes);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadSelected(const storage::CallContext& context, const SiteId& site,
                                                           const SessionId& session,
                                                           const storage::RecordSelection& selection) const override {
    return store_.ReadSelected(context, site, session, selection);
  }
  absl::StatusOr<std::vector<sensor::Record>> ReadEach(const storage::CallContext& context, const SiteId& site,
                                                       const SessionId& session,
                                                       const std::vector<std::int64_t>& sequences) const override {
    return store_.ReadEach(context, site, session, sequences);
  }

 private:
  const storage::RecordStore& store_;
  SessionId poison_{"none"};
  SessionId held_up_{"none"};
  std::atomic<bool> let_go_{false};
  mutable std::atomic<bool> waiting_{false};
  mutable std::atomic<int> throws_{0};
};

class MappingWorkersTest : public MappingFixture {
 protected:
  void Start(int workers = 1) {
    options_.workers = workers;
    SessionMappingStores stores{counting_,           records_,    stores_.sessions, stores_.blobs, stores_.revisions,
                                stores_.robot_poses, stores_.maps};
    mapping_.emplace(options_, slam::SlamOptions(), stores, *metrics_, [this] { ++ended_; });
  }
  void AwaitState(const SessionId& session, State state) {
    while (Session(session).state != state) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void AwaitMapped(const SessionId& session, std::int64_t sequence) {
    while (Session(session).mapped_sequence < sequence) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  void AwaitEnded(int count) {
    while (ended_ < count) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  ServerOptions::Mapping options_;
  CountingMappingStore counting_{stores_.mappings};
  FaultyRecordStore records_{stores_.records};
  const std::unique_ptr<Metrics> metrics_ = *Metrics::Create("");
  std::atomic<int> ended_{0};
  std::optional<Mapping> mapping_;
};

TEST_F(MappingWorkersTest, MapsFinishedSessionsAndReportsTheirEnd) {
  const SessionId a = NewFinishedSession("a");
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "cellar"), ""));
  const SessionId b = NewFinishedSession("b", "cellar");
  Start();
  AwaitEnded(2);
  for (const SessionId& session : {a, b}) {
    EXPECT_EQ(Session(session).state, State::kMapped);
    ExpectOfflineMap(session);
  }
  mapping_.reset();
  EXPECT_EQ(metrics_->sessions_mapping(), 0);
}

TEST_F(MappingWorkersTest, SeveralWorkersMapManySessionsEachOnce) {
  std::vector<SessionId> sessions;
  for (int i = 0; i < 6; ++i) {
    const std::string id = std::to_string(i);
    ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room" + id), ""));
    sessions.push_back(NewFinishedSession("s" + id, "room" + id));
  }
  Start(3);
  AwaitEnded(6);
  for (const SessionId& session : sessions) ExpectOfflineMap(session);
  EXPECT_EQ(ended_, 6);
}

TEST_F(MappingWorkersTest, ALiveSessionIsMappedAsItsRecordsComeAndLoadedOnce) {
  const SessionId session = NewSession("s");
  options_.checkpoint_interval_s = 0.0;
  Start();
  for (std::size_t begin = 0; begin < Log().size(); begin += 67) {
    const std::size_t end = std::min(Log().size(), begin + 67);
    Append(session, begin, end);
    mapping_->Wake();
    AwaitMapped(session, static_cast<std::int64_t>(end));
  }
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
  EXPECT_EQ(counting_.loads(), 1) << "kept between its turns";
}

// A checkpoint takes longer to write than a scan to map.
TEST_F(MappingWorkersTest, ALiveSessionIsStoredOnceACheckpointIsDue) {
  const SessionId session = NewSession("s");
  options_.checkpoint_interval_s = 1.0;
  Append(session, 0, 40);
  Start();
  AwaitMapped(session, 40);
  while (counting_.read_sequence() < 40) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const TimeNs first_pose = stores_.robot_poses.Get(Soon(), site_, RobotId("r"))->time;
  const auto begin = std::chrono::steady_clock::now();
  const int commits = counting_.commits();
  for (std::size_t end = 42; end <= 80; end += 2) {
    Append(session, end - 2, end);
    mapping_->Wake(site_, session);
    std::this_thread::sleep_for(std::chrono::milliseconds(120));  // more than a worker rests between two looks
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_LE(counting_.commits() - commits, took.count() / options_.checkpoint_interval_s + 1.0);
  EXPECT_GT(stores_.robot_poses.Get(Soon(), site_, RobotId("r"))->time, first_pose) << "the pose is, at each turn";
  AwaitMapped(session, 80);  // though the robot sends nothing more
  EXPECT_EQ(counting_.loads(), 1);
  Append(session, 80, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, AServerThatStopsLeavesWhatItHasNotStoredToTheNextOne) {
  const SessionId session = NewSession("s");
  options_.checkpoint_interval_s = 3600.0;
  Append(session, 0, 40);
  Start();
  AwaitMapped(session, 40);
  Append(session, 40, 80);
  mapping_->Wake(site_, session);
  while (counting_.read_sequence() < 80) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(Session(session).mapped_sequence, 40) << "not due for an hour";
  mapping_.reset();
  Start();
  AwaitMapped(session, 80);
}

TEST_F(MappingWorkersTest, ManyLiveSessionsAreAllStored) {
  options_.checkpoint_interval_s = 0.5;
  std::vector<SessionId> sessions;
  for (int i = 0; i < 7; ++i) {  // more than are kept between their turns
    const std::string id = std::to_string(i);
    ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room" + id), ""));
    sessions.push_back(NewSession("s" + id, "room" + id));
  }
  Start(2);
  for (std::size_t end = 20; end <= 100; end += 20) {
    for (const SessionId& session : sessions) {
      Append(session, end - 20, end);
      mapping_->Wake(site_, session);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  for (const SessionId& session : sessions) AwaitMapped(session, 100);
}

TEST_F(MappingWorkersTest, AnUnreadableRecordFailsItsSessionAndNoOther) {
  const SessionId broken = NewFinishedSession("broken");
  stores_.database.CorruptRecord(site_, broken, 100);
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room"), ""));
  const SessionId sound = NewFinishedSession("sound", "room");
  Start();
  AwaitEnded(2);
  EXPECT_EQ(Session(broken).state, State::kFailed);
  EXPECT_THAT(Session(broken).error, HasSubstr("broken"));
  EXPECT_EQ(Session(sound).state, State::kMapped);
}

TEST_F(MappingWorkersTest, AnExceptionEndsTheTurnAndTheTenthInSuccessionTheSession) {
  const SessionId poison = NewFinishedSession("poison");
  records_.ThrowFor(poison);
  ASSERT_OK(stores_.maps.Create(Soon(), MakeMap(site_, "room"), ""));
  const SessionId sound = NewFinishedSession("sound", "room");
  Start();
  while (ended_ < 2) {
    stores_.database.AdvanceClock(std::chrono::hours(1));  // the leases of ended turns run out
    mapping_->Wake();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  AwaitState(sound, State::kMapped);
  EXPECT_EQ(Session(poison).state, State::kFailed);
  EXPECT_THAT(Session(poison).error, HasSubstr("bad_alloc"));
  EXPECT_EQ(records_.throws(), Mapping::kMaxAttempts);
}

TEST_F(MappingWorkersTest, ASessionThatKilledItsProcessesIsGivenUpUnread) {
  const SessionId deadly = NewFinishedSession("deadly");
  for (std::int64_t i = 0; i < Mapping::kMaxAttempts; ++i) {
    ASSERT_OK(stores_.mappings.Acquire(Soon(), "a process that dies", std::chrono::seconds(10)));
    stores_.database.AdvanceClock(std::chrono::hours(1));
  }
  Start();
  AwaitEnded(1);
  EXPECT_EQ(Session(deadly).state, State::kFailed);
  EXPECT_THAT(Session(deadly).error, HasSubstr("10 attempts"));
}

TEST_F(MappingWorkersTest, StoppingStoresTheCheckpointAndReleasesTheLease) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  Start();
  AwaitMapped(session, 100);
  Append(session, 100, 150);
  mapping_.reset();
  // Whether or not the last records were mapped before the stop: another process continues without waiting.
  Append(session, 150, Log().size());
  Finish(session);
  Start();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, ContinuesFromTheCheckpointAfterAnOutage) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  Start();
  AwaitMapped(session, 100);
  stores_.database.FailCalls(absl::UnavailableError("gone"));
  mapping_->Wake();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  stores_.database.FailCalls(absl::OkStatus());
  Append(session, 100, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

TEST_F(MappingWorkersTest, ASessionThatAnotherProcessMappedMeanwhileIsLoadedAgain) {
  const SessionId session = NewSession("s");
  Append(session, 0, 67);
  Start();
  AwaitMapped(session, 67);
  ASSERT_EQ(counting_.loads(), 1);
  // Another process takes the next turn.
  std::optional<storage::LeasedSession> taken;
  std::size_t end = 67;
  while (!taken) {
    Append(session, end, end + 1);
    ++end;
    const auto leased = stores_.mappings.Acquire(Soon(), "another process", std::chrono::hours(1));
    ASSERT_OK(leased);
    taken = *leased;  // unset: this process was faster
  }
  auto other = SessionMapping::Load(mapping_stores(), {}, taken->session);
  ASSERT_OK(other);
  while (*(*other)->Step(taken->lease) == SessionMapping::Progress::kWorked) {
  }
  ASSERT_OK((*other)->Store(taken->lease));
  ASSERT_OK(stores_.mappings.Release(Soon(), taken->lease, 0));
  Append(session, end, Log().size());
  Finish(session);
  mapping_->Wake();
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
  EXPECT_EQ(counting_.loads(), 2);
}

TEST_F(MappingWorkersTest, RecordsOfASessionThatIsBeingMappedCostNoLooks) {
  const SessionId session = NewSession("s");
  Append(session, 0, 100);
  records_.HoldUp(session);
  Start(2);
  while (!records_.is_waiting()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const int looks = counting_.looks();
  for (int i = 0; i < 300; ++i) {
    mapping_->Wake(site_, session);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_LT(counting_.looks() - looks, 50) << "those of the other worker that polls";
  Append(session, 100, Log().size());
  records_.LetGo();
  AwaitMapped(session, static_cast<std::int64_t>(Log().size()));
}

TEST_F(MappingWorkersTest, ManyRobotsCostFewLooks) {
  Start();
  for (int i = 0; i < 300; ++i) {
    mapping_->Wake(site_, SessionId(fmt::format("s{}", i)));
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_LT(counting_.looks(), 50);
}

// The lease expires whenever another process gets hold of the clock: whoever loses it stores nothing more.
TEST_F(MappingWorkersTest, TheResultIsTheSameHoweverOftenLeasesAreLost) {
  const SessionId session = NewFinishedSession("s");
  options_.checkpoint_interval_s = 0.0;
  Start();
  for (int i = 0; i < 20 && Session(session).state != State::kMapped; ++i) {
    stores_.database.AdvanceClock(std::chrono::hours(1));
    const auto leased = stores_.mappings.Acquire(Soon(), "thief", std::chrono::seconds(10));
    ASSERT_OK(leased);
    if (!leased->has_value()) continue;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_OK(stores_.mappings.Release(Soon(), (*leased)->lease, 0));
    mapping_->Wake();
  }
  AwaitState(session, State::kMapped);
  ExpectOfflineMap(session);
}

}  // namespace
}  // namespace enfilade::server

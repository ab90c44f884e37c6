// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/readiness.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "core/base/mutex.h"

namespace enfilade::server {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using Position = storage::SchemaState::Position;

// A database whose schema state a test changes, and the changes of readiness that followed.
class Database {
 public:
  void Set(absl::StatusOr<storage::SchemaState> schema) {
    MutexLock lock(mutex_);
    schema_ = std::move(schema);
  }
  Readiness::CheckSchema check() {
    return [this] {
      MutexLock lock(mutex_);
      ++checks_;
      changed_.NotifyAll();
      return schema_;
    };
  }
  std::function<void(const Readiness::State&)> on_change() {
    return [this](const Readiness::State& state) {
      MutexLock lock(mutex_);
      changes_.push_back(state.ready);
      changed_.NotifyAll();
    };
  }
  void AwaitChanges(std::size_t count) {
    MutexLock lock(mutex_);
    while (changes_.size() < count) changed_.Wait(mutex_);
  }
  void AwaitChecks(int more) {
    MutexLock lock(mutex_);
    const int wanted = checks_ + more;
    while (checks_ < wanted) changed_.Wait(mutex_);
  }
  std::vector<bool> changes() {
    MutexLock lock(mutex_);
    return changes_;
  }

 private:
  Mutex mutex_;
  CondVar changed_;
  absl::StatusOr<storage::SchemaState> schema_ = storage::SchemaState{Position::kAtHead, "head", "head"};
  int checks_ = 0;
  std::vector<bool> changes_;
};

constexpr auto kOften = std::chrono::milliseconds(1);
constexpr auto kNever = std::chrono::hours(1);

TEST(Readiness, TheReasonSaysWhatToDo) {
  struct Case {
    absl::StatusOr<storage::SchemaState> schema;
    ::testing::Matcher<std::string> reason;
  };
  const Case cases[] = {
      {absl::UnavailableError("connection refused"), AllOf(HasSubstr("does not answer"), HasSubstr("refused"))},
      {storage::SchemaState{Position::kEmpty, "", "new"}, HasSubstr("deploy/database/migrate up")},
      {storage::SchemaState{Position::kBehind, "old", "new"},
       AllOf(HasSubstr("is at old"), HasSubstr("needs new"), HasSubstr("deploy/database/migrate up"))},
      {storage::SchemaState{Position::kTooNew, "newest", "new", "newer", "newer_too"},
       AllOf(HasSubstr("is at newest"), HasSubstr("change newer "), HasSubstr("knows newer_too"), HasSubstr("for new:"),
             HasSubstr("use a newer one"))},
  };
  for (const Case& one : cases) {
    Database database;
    database.Set(one.schema);
    const Readiness readiness(database.check(), database.on_change(), kNever);
    EXPECT_FALSE(readiness.state().ready);
    EXPECT_THAT(readiness.state().reason, one.reason);
    EXPECT_THAT(database.changes(), ElementsAre(false)) << "the first state is reported";
  }
}

TEST(Readiness, ServesANewerSchemaThatAllowsIt) {
  Database database;
  database.Set(storage::SchemaState{Position::kAhead, "newer", "new"});
  const Readiness readiness(database.check(), database.on_change(), kNever);
  EXPECT_TRUE(readiness.state().ready);
  EXPECT_EQ(readiness.state().schema.deployed, "newer");
}

TEST(Readiness, ReportsTheFirstStateAndThenOnlyChanges) {
  Database database;
  const Readiness readiness(database.check(), database.on_change(), kOften);
  EXPECT_TRUE(readiness.state().ready);
  EXPECT_TRUE(readiness.state().reason.empty());
  EXPECT_EQ(readiness.state().schema.deployed, "head");
  database.AwaitChecks(3);
  EXPECT_THAT(database.changes(), ElementsAre(true));
  database.Set(absl::UnavailableError("gone"));
  database.AwaitChanges(2);
  EXPECT_FALSE(readiness.state().ready);
  database.AwaitChecks(3);
  database.Set(storage::SchemaState{Position::kAtHead, "head", "head"});
  database.AwaitChanges(3);
  EXPECT_TRUE(readiness.state().ready);
  EXPECT_THAT(database.changes(), ElementsAre(true, false, true));
}

TEST(Readiness, TheReasonFollowsWhileItStaysNotReady) {
  Database database;
  database.Set(absl::UnavailableError("gone"));
  const Readiness readiness(database.check(), database.on_change(), kOften);
  database.Set(storage::SchemaState{Position::kEmpty, "", "head"});
  database.AwaitChecks(2);  // the state of the first of them is stored when the second one starts
  EXPECT_THAT(readiness.state().reason, HasSubstr("has no schema"));
  EXPECT_THAT(database.changes(), ElementsAre(false));
}

TEST(Readiness, DrainingIsPermanent) {
  Database database;
  Readiness readiness(database.check(), database.on_change(), kOften);
  readiness.Drain();
  database.AwaitChecks(3);
  EXPECT_FALSE(readiness.state().ready);
  EXPECT_THAT(readiness.state().reason, HasSubstr("shutting down"));
  EXPECT_THAT(database.changes(), ElementsAre(true, false));
}

}  // namespace
}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
// How fast records are stored, beside a bare COPY of the same rows. Against the server that ENFILADE_TEST_DATABASE
// names, otherwise against a throwaway cluster without fsync (whose figures say little about a real one).
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/base/sha256.h"
#include "core/sensor/record_codec.h"
#include "fmt/format.h"
#include "storage/postgres/driver/copy_buffer.h"
#include "storage/postgres/driver/transaction.h"
#include "storage/postgres/graph/robot_pose_store.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/map_store.h"
#include "storage/postgres/maps/revision_store.h"
#include "storage/postgres/sessions/record_store.h"
#include "storage/postgres/sessions/session_store.h"
#include "storage/sites/robot_store.h"
#include "storage/sites/site_store.h"
#include "tests/support/database.h"

namespace enfilade::bench {
namespace {

constexpr int kBeams = 180;  // as many as the Intel recording's
const SiteId kSite("bench");
const RobotId kRobot("robot");

template <typename T>
T OrDie(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

storage::CallContext Soon() { return storage::CallContext::WithTimeout(std::chrono::seconds(60)); }

// One database for all benchmarks: it grows, as a real one does.
struct Fixture {
  testing::TestDatabase database;
  std::unique_ptr<storage::postgres::Pool> pool =
      OrDie(storage::postgres::Pool::Create({.url = database.url(), .max_connections = 16}));
  storage::postgres::SessionStore sessions{*pool};
  storage::postgres::RecordStore records{*pool};
  int session_count = 0;

  Fixture() {
    storage::Site site;
    site.id = kSite;
    site.display_name = "Bench";
    OrDie(storage::SiteStore(*pool).Create(Soon(), site, ""));
    storage::Robot robot;
    robot.site = kSite;
    robot.id = kRobot;
    robot.display_name = "Robot";
    OrDie(storage::RobotStore(*pool).Create(Soon(), robot, ""));
  }
  SessionId NewSession() {
    storage::Session session;
    session.site = kSite;
    session.id = SessionId(fmt::format("0190c1d2-7a4b-7000-8000-{:012}", ++session_count));
    session.robot = kRobot;
    return OrDie(sessions.Create(Soon(), session, "")).id;
  }
  static Fixture& Instance() {
    static Fixture fixture;
    return fixture;
  }
};

std::vector<sensor::Record> Scans(std::int64_t first, std::int64_t count) {
  std::vector<sensor::Record> records;
  for (std::int64_t sequence = first; sequence < first + count; ++sequence) {
    sensor::LaserScan scan;
    scan.time = 1'700'000'000 * kNsPerSecond + sequence * kNsPerSecond / 10;
    scan.angle_increment = 0.0174;
    scan.range_max = 81.0F;
    for (int i = 0; i < kBeams; ++i) scan.ranges.push_back(static_cast<float>((sequence * 37 + i * 91) % 8000) * 0.01F);
    records.push_back({sequence, std::move(scan)});
  }
  return records;
}

// COPY BINARY of `batch` rows per transaction into a table like the log's, and nothing else.
void BM_BareCopy(benchmark::State& state) {
  constexpr storage::postgres::Statement kCopy{
      "copying",
      "COPY bare_records (site_id, session_id, sequence, time_ns, kind, payload) FROM STDIN (FORMAT binary)"};
  Fixture& fixture = Fixture::Instance();
  fixture.database.Sql("DROP TABLE IF EXISTS bare_records");
  fixture.database.Sql("CREATE TABLE bare_records (LIKE enfilade.session_records INCLUDING ALL)");
  const std::int64_t batch = state.range(0);
  std::int64_t first = 1;
  for (auto _ : state) {
    state.PauseTiming();
    storage::postgres::CopyBuffer rows;
    for (const sensor::Record& record : Scans(first, batch)) {
      rows.BeginRow(6);
      rows.Put(kSite.value());
      rows.Put("0190c1d2-7a4b-7000-8000-000000000000");
      rows.Put(record.sequence);
      rows.Put(sensor::TimeOf(record));
      rows.Put(static_cast<std::int16_t>(sensor::KindOf(record)));
      rows.PutAppended([&](std::string& out) { sensor::AppendPayload(record, out); });
    }
    const std::string_view bytes = rows.Finish();
    first += batch;
    state.ResumeTiming();
    storage::postgres::Transaction transaction = OrDie(storage::postgres::Transaction::Begin(*fixture.pool, Soon()));
    if (!transaction.CopyIn(kCopy, bytes).ok() || !transaction.Commit().ok()) state.SkipWithError("copy failed");
  }
  state.SetItemsProcessed(state.iterations() * batch);
}
BENCHMARK(BM_BareCopy)->Arg(1)->Arg(10)->Arg(100)->Arg(1000)->Arg(20000)->UseRealTime()->Unit(benchmark::kMicrosecond);

// One session's batches, one after the other.
void BM_Append(benchmark::State& state) {
  Fixture& fixture = Fixture::Instance();
  const SessionId session = fixture.NewSession();
  const std::int64_t batch = state.range(0);
  std::int64_t first = 1;
  for (auto _ : state) {
    state.PauseTiming();
    const std::vector<sensor::Record> scans = Scans(first, batch);
    first += batch;
    state.ResumeTiming();
    OrDie(fixture.records.Append(Soon(), {kSite, session, scans, {}}));
  }
  state.SetItemsProcessed(state.iterations() * batch);
}
BENCHMARK(BM_Append)->Arg(1)->Arg(10)->Arg(100)->Arg(1000)->UseRealTime()->Unit(benchmark::kMicrosecond);

// `range(0)` sessions with a batch of `range(1)` each, in one transaction.
void BM_AppendGroup(benchmark::State& state) {
  Fixture& fixture = Fixture::Instance();
  std::vector<SessionId> sessions;
  for (std::int64_t i = 0; i < state.range(0); ++i) sessions.push_back(fixture.NewSession());
  const std::int64_t batch = state.range(1);
  std::int64_t first = 1;
  for (auto _ : state) {
    state.PauseTiming();
    const std::vector<sensor::Record> scans = Scans(first, batch);
    std::vector<storage::RecordBatch> batches;
    for (const SessionId& session : sessions) batches.push_back({kSite, session, scans, {}});
    first += batch;
    state.ResumeTiming();
    for (const auto& answer : fixture.records.AppendGroup(Soon(), batches)) OrDie(answer);
  }
  state.SetItemsProcessed(state.iterations() * batch * state.range(0));
}
BENCHMARK(BM_AppendGroup)
    ->Args({10, 1})
    ->Args({100, 1})
    ->Args({10, 10})
    ->Args({100, 10})
    ->UseRealTime()
    ->Unit(benchmark::kMicrosecond);

// Each thread appends to a session of its own: what several writers make of the commits.
void BM_AppendThreads(benchmark::State& state) {
  Fixture& fixture = Fixture::Instance();
  static std::vector<SessionId> sessions;
  if (state.thread_index() == 0) {
    sessions.clear();
    for (int i = 0; i < state.threads(); ++i) sessions.push_back(fixture.NewSession());
  }
  const std::int64_t batch = state.range(0);
  std::int64_t first = 1;
  for (auto _ : state) {
    const SessionId& session = sessions[static_cast<std::size_t>(state.thread_index())];
    const std::vector<sensor::Record> scans = Scans(first, batch);
    first += batch;
    OrDie(fixture.records.Append(Soon(), {kSite, session, scans, {}}));
  }
  state.SetItemsProcessed(state.iterations() * batch);
}
BENCHMARK(BM_AppendThreads)->Arg(1)->Arg(10)->Threads(2)->Threads(8)->UseRealTime()->Unit(benchmark::kMicrosecond);

// As mapping reads a log.
void BM_Read(benchmark::State& state) {
  Fixture& fixture = Fixture::Instance();
  const SessionId session = fixture.NewSession();
  constexpr std::int64_t kCount = 20'000;
  for (std::int64_t first = 1; first <= kCount; first += 1000) {
    OrDie(fixture.records.Append(Soon(), {kSite, session, Scans(first, 1000), {}}));
  }
  std::int64_t next = 1;
  std::int64_t read = 0;
  for (auto _ : state) {
    const auto records = OrDie(fixture.records.Read(Soon(), kSite, session, next, state.range(0)));
    read += static_cast<std::int64_t>(records.size());
    next = records.empty() ? 1 : records.back().sequence + 1;
  }
  state.SetItemsProcessed(read);
}
BENCHMARK(BM_Read)->Arg(1 << 16)->Arg(1 << 20)->UseRealTime()->Unit(benchmark::kMicrosecond);

// A raster of 200 MB in tiles of 64 KiB, as a map's download reads it.
void BM_ReadTiles(benchmark::State& state) {
  Fixture& fixture = Fixture::Instance();
  storage::Map map;
  map.site = kSite;
  static int maps = 0;  // this function is called several times
  map.id = MapId(fmt::format("map{}", ++maps));
  map.display_name = map.id.value();
  OrDie(storage::postgres::MapStore(*fixture.pool).Create(Soon(), map, ""));
  const storage::postgres::BlobStore blobs(*fixture.pool);
  const storage::postgres::RevisionStore revisions(*fixture.pool);
  storage::NewRevision revision;
  revision.source = storage::RevisionSource::kImport;
  revision.content_sha256 = std::string(32, 'c');
  constexpr int kTiles = 3200;
  for (int i = 0; i < kTiles; ++i) {
    std::string data(1 << 16, static_cast<char>(i));
    data.replace(0, 8, fmt::format("{:08}", i));
    const std::string digest = Sha256(data);
    const storage::BlobView view{digest, data};
    if (!blobs.Put(Soon(), kSite, absl::MakeConstSpan(&view, 1)).ok()) state.SkipWithError("put failed");
    revision.tiles.push_back({{i / 64, i % 64}, digest});
  }
  const storage::MapRevision added = OrDie(revisions.Add(Soon(), kSite, map.id, revision, {}));
  std::int64_t bytes = 0;
  for (auto _ : state) {
    std::optional<storage::TileKey> after;
    while (true) {
      const auto tiles = OrDie(revisions.ReadTiles(Soon(), added, after, state.range(0)));
      if (tiles.empty()) break;
      for (const storage::Tile& tile : tiles) bytes += static_cast<std::int64_t>(tile.data.size());
      after = tiles.back().key;
    }
  }
  state.SetBytesProcessed(bytes);
}
BENCHMARK(BM_ReadTiles)->Arg(1 << 20)->Arg(8 << 20)->UseRealTime()->Unit(benchmark::kMillisecond);

// Processor time of the database's processes for this database since they began, s.
double DatabaseCpu(const Fixture& fixture) {
  double ticks = 0.0;
  for (const std::string& pid :
       fixture.database.Sql("SELECT pid::text FROM pg_stat_activity WHERE datname = current_database()"
                            " AND application_name = 'pose bench'")) {
    std::ifstream file("/proc/" + pid + "/stat");
    std::string field;
    for (int i = 1; file >> field && i <= 15; ++i) {
      if (i >= 14) ticks += std::stod(field);  // utime and stime: "postgres:" and what follows is in (parentheses)
    }
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

// A second of 1,000 robots that report a pose each, `range(0)` of them in a statement. The counter "cores" is the
// share of a processor that the database needs for it, if the robots report once a second.
void BM_ReportPoses(benchmark::State& state) {
  constexpr int kRobots = 1000;
  Fixture& fixture = Fixture::Instance();
  static const MapId map = [&fixture] {
    storage::Map made;
    made.site = kSite;
    made.id = MapId("poses");
    made.display_name = "Poses";
    OrDie(storage::postgres::MapStore(*fixture.pool).Create(Soon(), made, ""));
    for (int i = 0; i < kRobots; ++i) {
      OrDie(storage::RobotStore(*fixture.pool)
                .Create(Soon(), {.site = kSite, .id = RobotId(fmt::format("r{}", i)), .display_name = "Robot"}, ""));
    }
    return made.id;
  }();
  const auto pool = OrDie(storage::postgres::Pool::Create(
      {.url = fixture.database.url(), .max_connections = 1, .application_name = "pose bench"}));
  const storage::postgres::RobotPoseStore store(*pool);
  static TimeNs time = 1'700'000'000 * kNsPerSecond;
  const auto report = [&] {
    time += kNsPerSecond;
    std::vector<storage::RobotPose> poses;
    for (int i = 0; i < kRobots; ++i) {
      storage::RobotPose& pose = poses.emplace_back();
      pose = {kSite, RobotId(fmt::format("r{}", i)), map, std::nullopt, {}, time, 0};
      pose.T_map_robot = {{0.001 * i, 1.0, 0.1}, 0.01 * Eigen::Matrix3d::Identity()};
      if (static_cast<std::int64_t>(poses.size()) < state.range(0) && i + 1 < kRobots) continue;
      for (const absl::Status& status : store.ReportAll(Soon(), poses)) {
        if (!status.ok()) state.SkipWithError(status.ToString().c_str());
      }
      poses.clear();
    }
  };
  report();
  const double before = DatabaseCpu(fixture);
  for (auto _ : state) report();
  state.counters["cores"] = (DatabaseCpu(fixture) - before) / static_cast<double>(state.iterations());
  state.SetItemsProcessed(state.iterations() * kRobots);
}
BENCHMARK(BM_ReportPoses)->Arg(1)->Arg(10)->Arg(100)->Arg(1000)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace enfilade::bench

BENCHMARK_MAIN();

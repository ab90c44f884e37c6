// SPDX-License-Identifier: Apache-2.0
// Prints JSON: rate and latency of FindLinkPoints in a site of 10,000 maps and 100,000 link points, beside pgbench with
// the same SQL prepared, asked by a bare client and by gRPC's; and how long a global pose takes after a link point was
// changed. usage: bench_link_points [--quick]
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <random>
#include <thread>

#include "absl/synchronization/mutex.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "fmt/format.h"
#include "grpcpp/generic/generic_stub.h"
#include "grpcpp/grpcpp.h"
#include "grpcpp/support/proto_buffer_reader.h"
#include "nlohmann/json.hpp"
#include "storage/postgres/graph/link_point_search.h"
#include "tests/bench/support/bare_caller.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"
#include "tests/bench/support/processor_time.h"
#include "tests/support/command.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;
using testing::RunCommand;

constexpr double kRadius = 20.0;  // m
constexpr const char* kMethod = "/enfilade.v1.LinkPointService/FindLinkPoints";
constexpr std::int64_t kDecoded = 100;  // of so many answers, one
// Of the square campus, m: ten of 100,000 link points lie within a circle of 20 m.
const double kSide = std::sqrt(100'000 * M_PI * kRadius * kRadius / 10);

// A grid of 100 x 100 maps; each link point joins the map that it lies in with one beside it. What the triggers would
// write for each anchor is written at once; foreign keys and constraints hold as ever.
constexpr char kPopulate[] = R"(
BEGIN;
ALTER TABLE enfilade.link_points DISABLE TRIGGER USER;
ALTER TABLE enfilade.link_point_anchors DISABLE TRIGGER USER;
SELECT setseed(0.5);
INSERT INTO enfilade.maps (site_id, map_id, display_name, environment)
  SELECT 'bench', 'room-' || i, 'room ' || i, 1 FROM generate_series(0, 9999) i;
CREATE TEMP TABLE rooms AS SELECT i, 'room-' || i AS id, i % 100 * :side / 100 AS x, i / 100 * :side / 100 AS y
  FROM generate_series(0, 9999) i;
UPDATE enfilade.graph_maps m SET x = r.x, y = r.y, yaw = 0, covariance = array_fill(0::float8, '{9}')
  FROM rooms r WHERE m.site_id = 'bench' AND m.map_id = r.id;
CREATE TEMP TABLE doors AS
  SELECT i, x, y, col + 100 * row AS room,
    CASE WHEN i % 2 = 0 THEN CASE col WHEN 99 THEN 98 ELSE col + 1 END + 100 * row
      ELSE col + 100 * CASE row WHEN 99 THEN 98 ELSE row + 1 END END AS next_room
  FROM (SELECT i, x, y, floor(x / :side * 100)::int AS col, floor(y / :side * 100)::int AS row
    FROM (SELECT i, random() * :side AS x, random() * :side AS y FROM generate_series(1, 100000) i) p) placed;
INSERT INTO enfilade.link_points (site_id, link_point_id, kind, anchor_count, levels, position, yaw, world_covariance,
    changed_version)
  SELECT 'bench', 'door-' || i, 1, 2, '{[0,0]}', ST_MakePoint(x, y), 0, '{0.01,0,0,0,0.01,0,0,0,0.01}', 1 FROM doors;
INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)
  SELECT 'bench', 'door-' || d.i, r.id, n, d.x - r.x, d.y - r.y, 0, '{0.003,0,0,0,0.003,0,0,0,0.003}'
  FROM doors d CROSS JOIN (VALUES (1), (2)) o (n) JOIN rooms r ON r.i = CASE n WHEN 1 THEN d.room ELSE d.next_room END;
ALTER TABLE enfilade.link_points ENABLE TRIGGER USER;
ALTER TABLE enfilade.link_point_anchors ENABLE TRIGGER USER;
COMMIT;
VACUUM ANALYZE;
)";

std::string Run(const std::vector<std::string>& command) {
  auto result = RunCommand(command);
  if (result.exit_code != 0) throw std::runtime_error(result.output);
  return std::move(result.output);
}

template <typename Service, typename Request, typename Response>
Response Must(const enfilade::client::Connection& connection,
              grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request) {
  auto response = connection.Call(method, request);
  if (!response.ok()) throw std::runtime_error(response.status().ToString());
  return *std::move(response);
}

void Populate(BenchSystem& system) {
  const std::string file = (system.directory() / "populate.sql").string();
  std::ofstream(file) << kPopulate;
  // The server is away meanwhile: it need not solve a graph whose maps have their places.
  system.server().Kill();
  Run({"psql", system.database_url(), "-Xqv", "ON_ERROR_STOP=1", "-v", fmt::format("side={}", kSide), "-f", file});
  system.server().StartAndWait();
  system.Settle("sites/bench");
  // The solution has written every row: SQL need not pass their old versions.
  Run({"psql", system.database_url(), "-Xqc", "VACUUM ANALYZE"});
}

// The statement of the server, its parameters as pgbench's variables.
std::string WriteScript(const BenchSystem& system) {
  constexpr const char* kNames[] = {"site", "min_anchors", "max_anchors", "max_use", "limit", "x", "y", "radius"};
  std::string sql = storage::postgres::kFindWithin.sql;
  for (int i = 0; i < 8; ++i) {
    const std::string number = fmt::format("${}", i + 1);
    for (auto at = sql.find(number); at != std::string::npos; at = sql.find(number)) {
      sql.replace(at, number.size(), fmt::format(":{}", kNames[i]));
    }
  }
  const std::string file = (system.directory() / "find.sql").string();
  std::ofstream(file) << fmt::format("\\set x random(0, 1000000) / 1000000.0 * {0}\n", kSide)
                      << fmt::format("\\set y random(0, 1000000) / 1000000.0 * {0}\n", kSide) << sql << ";\n";
  return file;
}

double PgbenchRate(const BenchSystem& system, const std::string& script, int clients, int seconds) {
  const std::string count = std::to_string(clients);
  const std::string output = Run({"pgbench",
                                  "-n",
                                  "-M",
                                  "prepared",
                                  "-f",
                                  script,
                                  "-c",
                                  count,
                                  "-j",
                                  count,
                                  "-T",
                                  std::to_string(seconds),
                                  "-D",
                                  "site=bench",
                                  "-D",
                                  "min_anchors=1",
                                  "-D",
                                  "max_anchors=2147483647",
                                  "-D",
                                  "max_use=1",
                                  "-D",
                                  "limit=1000",
                                  "-D",
                                  fmt::format("radius={}", kRadius),
                                  system.database_url()});
  const auto at = output.find("tps = ");
  if (at == std::string::npos) throw std::runtime_error(output);
  return std::stod(output.substr(at + 6));
}

struct Load {
  double rate = 0.0;               // calls per second
  std::vector<double> latency_ms;  // of each call
  std::int64_t found = 0;          // link points, over all calls, about
};

std::int64_t CountFound(std::string_view bytes) {
  v1::FindLinkPointsResponse response;
  if (!response.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    throw std::runtime_error("an answer cannot be read");
  }
  return response.found_size();
}

std::int64_t CountFound(grpc::ByteBuffer bytes) {
  v1::FindLinkPointsResponse response;
  grpc::ProtoBufferReader reader(&bytes);
  if (!response.ParseFromZeroCopyStream(&reader)) throw std::runtime_error("an answer cannot be read");
  return response.found_size();
}

// The same with gRPC's client, on a connection of its own.
class GrpcCaller {
 public:
  GrpcCaller(const std::string& address, const std::string& method)
      : stub_(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), Arguments())), method_(method) {}

  grpc::ByteBuffer Call(const v1::FindLinkPointsRequest& request) {
    grpc::ClientContext context;
    grpc::ByteBuffer response;
    grpc::Status status;
    const auto call = stub_.PrepareUnaryCall(&context, method_, Serialize(request), &queue_);
    call->StartCall();
    call->Finish(&response, &status, nullptr);
    void* tag = nullptr;
    bool ok = false;
    queue_.Next(&tag, &ok);
    if (!status.ok()) throw std::runtime_error(status.error_message());
    return response;
  }

 private:
  static grpc::ChannelArguments Arguments() {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);  // pgbench repeats nothing, either
    return arguments;
  }

  grpc::GenericStub stub_;
  const std::string method_;
  grpc::CompletionQueue queue_;
};

// One client. It decodes every 100th answer only: it stands for another machine, and pgbench, which is the yardstick,
// drops its rows unread, too.
template <typename Caller>
Load Ask(const std::string& address, unsigned seed, Clock::time_point until) {
  Caller caller(address, kMethod);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> anywhere(0.0, kSide);
  v1::FindLinkPointsRequest request;
  request.set_parent("sites/bench");
  request.set_radius_m(kRadius);
  Load load;
  while (Clock::now() < until) {
    request.mutable_point_world()->set_x(anywhere(random));
    request.mutable_point_world()->set_y(anywhere(random));
    const Clock::time_point begin = Clock::now();
    const auto response = caller.Call(request);
    load.latency_ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    if (load.latency_ms.size() % kDecoded == 0) load.found += kDecoded * CountFound(response);
  }
  return load;
}

template <typename Caller>
Load AskAll(const std::string& address, int clients, int seconds, unsigned seed) {
  const Clock::time_point until = Clock::now() + std::chrono::seconds(seconds);
  std::vector<Load> loads(static_cast<std::size_t>(clients));
  std::vector<std::string> errors(loads.size());
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < loads.size(); ++i) {
    threads.emplace_back([&, i] {
      try {
        loads[i] = Ask<Caller>(address, seed * 100 + static_cast<unsigned>(i), until);
      } catch (const std::exception& failure) {
        errors[i] = failure.what();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& error : errors) {
    if (!error.empty()) throw std::runtime_error("a call failed: " + error);
  }
  Load all;
  for (const Load& load : loads) {
    all.latency_ms.insert(all.latency_ms.end(), load.latency_ms.begin(), load.latency_ms.end());
    all.found += load.found;
  }
  all.rate = static_cast<double>(all.latency_ms.size()) / seconds;
  return all;
}

// Processor time, us for each call: the generators run on the same processors, and cost the more the faster they are
// answered.
struct Cost {
  double us = 0.0;
  double calls = 0.0;

  template <typename Clock, typename Run>
  double Add(const Clock& processor_s, const Run& run) {
    const double before = processor_s();
    const double done = run();
    us += 1e6 * (processor_s() - before);
    calls += done;
    return done;
  }
  double per_call() const { return us / calls; }
};

template <typename Caller>
nlohmann::json Measure(BenchSystem& system, const std::string& script, int clients, int rounds, int seconds) {
  const std::string& address = system.server().address();
  AskAll<Caller>(address, clients, 1, 0);
  PgbenchRate(system, script, clients, 1);
  Cost server;
  Cost database;
  const auto server_s = [&] { return ProcessorSeconds(system.server().process().pid()); };
  const auto database_s = [&] { return ProcessorSecondsOfTree(system.database_pid()); };
  const auto query = [&] {
    return database.Add(database_s, [&] { return PgbenchRate(system, script, clients, seconds) * seconds; }) / seconds;
  };
  std::vector<double> served;
  std::vector<double> queried;
  std::vector<double> ratios;
  std::vector<double> latencies;
  std::int64_t found = 0;
  for (int i = 0; i < rounds; ++i) {
    const double before = query();
    Load load;
    server.Add(server_s, [&] {
      load = AskAll<Caller>(address, clients, 2 * seconds, static_cast<unsigned>(i + 1));
      return static_cast<double>(load.latency_ms.size());
    });
    queried.push_back((before + query()) / 2.0);
    served.push_back(load.rate);
    ratios.push_back(served.back() / queried.back());
    latencies.insert(latencies.end(), load.latency_ms.begin(), load.latency_ms.end());
    found += load.found;
    std::cerr << clients << " clients: " << served.back() << " / s, pgbench " << queried.back() << " / s\n";
  }
  const auto calls = static_cast<double>(latencies.size());
  return {{"clients", clients},
          {"rounds", rounds},
          {"calls", latencies.size()},
          {"found_per_call", static_cast<double>(found) / calls},
          {"rate", Percentile(served, 0.5)},
          {"pgbench_rate", Percentile(queried, 0.5)},
          {"ratio", Percentile(ratios, 0.5)},
          {"ratio_min", Percentile(ratios, 0.0)},
          {"ratio_max", Percentile(ratios, 1.0)},
          {"server_us_per_call", server.per_call()},
          {"database_us_per_query", database.per_call()},
          {"p50_ms", Percentile(latencies, 0.5)},
          {"p99_ms", Percentile(latencies, 0.99)}};
}

// A link point is moved, then a pose is asked for at the other end of the campus, some 200 link points away.
nlohmann::json MeasureChanges(BenchSystem& system, int rounds) {
  using Points = v1::LinkPointService::Stub;
  const enfilade::client::Connection connection = system.server().Connect();
  v1::GetGlobalPoseRequest ask;
  ask.mutable_map_pose()->set_map("sites/bench/maps/room-9999");
  ask.mutable_map_pose()->mutable_pose_map_robot()->mutable_pose();
  Must(connection, &v1::GraphService::Stub::GetGlobalPose, ask);
  std::vector<double> changed;
  std::vector<double> answered;
  for (int i = 0; i < rounds; ++i) {
    v1::GetLinkPointRequest get;
    get.set_name(fmt::format("sites/bench/linkPoints/door-{}", 1 + i * 3001));
    v1::UpdateLinkPointRequest update;
    *update.mutable_link_point() = Must(connection, &Points::GetLinkPoint, get).link_point();
    v1::Pose2& pose = *update.mutable_link_point()->mutable_anchors(0)->mutable_pose_map_place()->mutable_pose();
    pose.set_x(pose.x() + 0.001);
    update.mutable_update_mask()->add_paths("anchors");
    const Clock::time_point begin = Clock::now();
    const std::int64_t version = Must(connection, &Points::UpdateLinkPoint, update).link_point().graph_version();
    const Clock::time_point done = Clock::now();
    while (Must(connection, &v1::GraphService::Stub::GetGlobalPose, ask).global_pose().graph_version() < version) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // or asking alone would keep both cores busy
    }
    changed.push_back(std::chrono::duration<double, std::milli>(done - begin).count());
    answered.push_back(std::chrono::duration<double, std::milli>(Clock::now() - done).count());
  }
  return {{"rounds", rounds},
          {"change_p50_ms", Percentile(changed, 0.5)},
          {"change_max_ms", Percentile(changed, 1.0)},
          {"answer_p50_ms", Percentile(answered, 0.5)},
          {"answer_max_ms", Percentile(answered, 1.0)}};
}

}  // namespace

int main(int argc, char** argv) {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);  // as all programs of ours
  try {
    const bool quick = argc == 2 && std::string(argv[1]) == "--quick";
    BenchSystem system({"mapping.workers=0"});
    Populate(system);
    const std::string script = WriteScript(system);
    nlohmann::json document = {
        {"benchmark", "link points"}, {"maps", 10'000}, {"link_points", 100'000}, {"radius_m", kRadius}};
    for (const int clients : {1, 4}) {
      const int rounds = quick ? 3 : 7;
      const int seconds = quick ? 1 : 3;
      document["search"].push_back(Measure<BareCaller>(system, script, clients, rounds, seconds));
      document["search_by_grpc_client"].push_back(Measure<GrpcCaller>(system, script, clients, rounds, seconds));
    }
    document["pose_after_change"] = MeasureChanges(system, quick ? 10 : 30);
    std::cout << document.dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_link_points: " << failure.what() << '\n';
    return 1;
  }
}

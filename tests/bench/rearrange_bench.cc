// SPDX-License-Identifier: Apache-2.0
// Prints JSON: the time of a merge of two maps with ten mapped sessions each, and what readers of the graph wait
// meanwhile, beside the same readers while nothing is merged, and while nothing is merged but a thread computes for as
// long: what merging costs readers by waiting, and what by the processor alone.
// usage: bench_rearrange [--quick]
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <variant>
#include <vector>

#include "client/simulator/simulation.h"
#include "core/graph/link_point.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/convert/geometry.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

constexpr int kSessionsOfMap = 10;

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

double MillisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// A drive through the simulated rooms.
std::vector<sensor::Record> DriveOf(std::uint64_t seed) {
  simulator::SimulationOptions options = simulator::RoomsOptions();
  options.seed = seed;
  std::vector<sensor::Record> records;
  for (const simulator::SimulatedRecord& record : Must(simulator::SimulateRooms(options)).records) {
    std::visit(
        [&](const auto& payload) {
          records.push_back({static_cast<std::int64_t>(records.size()) + 1, payload});
        },
        record.payload);
  }
  return records;
}

// Two maps, each with the same ten drives, and a link point where one has its origin in the other.
class TwoMaps {
 public:
  explicit TwoMaps(BenchSystem& system)
      : server_(system.server().Connect()), kept_(system.CreateMap("Hall")), merged_(system.CreateMap("Lab")) {
    for (int i = 0; i < kSessionsOfMap; ++i) {
      const std::vector<sensor::Record> drive = DriveOf(static_cast<std::uint64_t>(i) + 1);
      records_ += 2 * static_cast<std::int64_t>(drive.size());
      scans_ += 2 * std::count_if(drive.begin(), drive.end(), [](const sensor::Record& record) {
                  return sensor::KindOf(record) == sensor::RecordKind::kLaserScan;
                });
      const std::vector<std::string> pair = {CreateSession(kept_), CreateSession(merged_)};
      const std::vector<LoadBatch> batches = ToBatches(drive, 200);
      const LoadResult sent = LoadGenerator({system.server().address(), pair, 8}, batches).Run();
      if (!sent.error.empty()) throw std::runtime_error(sent.error);
      for (const std::string& session : pair) Finish(session, static_cast<std::int64_t>(drive.size()));
    }
    for (const std::string& session : sessions_) AwaitMapped(session);
    Link();
  }

  const client::Connection& server() const { return server_; }
  const std::string& kept() const { return kept_; }
  std::int64_t records() const { return records_; }
  std::int64_t scans() const { return scans_; }
  v1::Rearrangement Merge() const {
    v1::MergeMapsRequest request;
    request.set_name(kept_);
    request.set_merged_map(merged_);
    return Must(server_.Call(&v1::MapService::Stub::MergeMaps, request)).rearrangement();
  }
  void Undo(const v1::Rearrangement& rearrangement) const {
    v1::UndoRearrangementRequest request;
    request.set_name(rearrangement.name());
    Must(server_.Call(&v1::MapService::Stub::UndoRearrangement, request));
  }

 private:
  std::string CreateSession(const std::string& map) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/bench");
    request.mutable_session()->set_robot("sites/bench/robots/robot");
    request.mutable_session()->set_map(map);
    sessions_.push_back(Must(server_.Call(&v1::SessionService::Stub::CreateSession, request)).session().name());
    return sessions_.back();
  }
  void Finish(const std::string& session, std::int64_t last_sequence) const {
    v1::FinishSessionRequest request;
    request.set_name(session);
    request.set_last_sequence(last_sequence);
    Must(server_.Call(&v1::SessionService::Stub::FinishSession, request));
  }
  void AwaitMapped(const std::string& session) const {
    v1::GetSessionRequest request;
    request.set_name(session);
    for (;;) {
      const v1::Session stored = Must(server_.Call(&v1::SessionService::Stub::GetSession, request)).session();
      if (stored.state() == v1::Session::STATE_MAPPED) return;
      if (stored.state() == v1::Session::STATE_FAILED) throw std::runtime_error(stored.error());
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
  }
  void Link() const {
    v1::CreateLinkPointRequest request;
    request.set_parent("sites/bench");
    request.mutable_link_point()->set_kind(v1::LinkPoint::KIND_DOOR);
    for (const auto& [map, pose] : {std::pair(kept_, Pose2{3.0, 2.0, 0.5}), std::pair(merged_, Pose2{})}) {
      v1::Anchor& anchor = *request.mutable_link_point()->add_anchors();
      anchor.set_map(map);
      *anchor.mutable_pose_map_place() = convert::ToProto(PoseWithCovariance{pose, graph::DefaultAnchorCovariance()});
    }
    Must(server_.Call(&v1::LinkPointService::Stub::CreateLinkPoint, request));
  }

  const client::Connection server_;
  const std::string kept_, merged_;
  std::vector<std::string> sessions_;
  std::int64_t records_ = 0;
  std::int64_t scans_ = 0;
};

// Clients that read without a pause, each over a connection of its own; ms per call.
class Readers {
 public:
  Readers(BenchSystem& system, const TwoMaps& maps) : system_(system), maps_(maps) {}

  struct Latencies {
    std::vector<double> global_pose, graph;
  };
  // While `work` runs.
  Latencies During(const std::function<void()>& work) {
    std::atomic<bool> done{false}, failed{false};
    Latencies latencies;
    std::thread poses([&] { Read(GlobalPose(), latencies.global_pose, done, failed); });
    std::thread graphs([&] { Read(Graph(), latencies.graph, done, failed); });
    work();
    done = true;
    poses.join();
    graphs.join();
    if (failed) throw std::runtime_error("a reader's call failed");
    return latencies;
  }

 private:
  using CallOnce = std::function<bool(const client::Connection& server)>;
  CallOnce GlobalPose() const {
    v1::GetGlobalPoseRequest request;
    request.mutable_map_pose()->set_map(maps_.kept());
    *request.mutable_map_pose()->mutable_pose_map_robot() = convert::ToProto(PoseWithCovariance{});
    return [request](const client::Connection& server) {
      return server.Call(&v1::GraphService::Stub::GetGlobalPose, request).ok();
    };
  }
  static CallOnce Graph() {
    v1::GetGraphRequest request;
    request.set_site("sites/bench");
    return [request](const client::Connection& server) {
      return server.Call(&v1::GraphService::Stub::GetGraph, request).ok();
    };
  }
  void Read(const CallOnce& call, std::vector<double>& latencies, const std::atomic<bool>& done,
            std::atomic<bool>& failed) const {
    const client::Connection server(system_.server().address(), std::chrono::seconds(30));
    while (!done) {
      const Clock::time_point begin = Clock::now();
      if (!call(server)) failed = true;
      latencies.push_back(MillisecondsSince(begin));
    }
  }

  BenchSystem& system_;
  const TwoMaps& maps_;
};

void Append(const Readers::Latencies& from, Readers::Latencies& to) {
  to.global_pose.insert(to.global_pose.end(), from.global_pose.begin(), from.global_pose.end());
  to.graph.insert(to.graph.end(), from.graph.begin(), from.graph.end());
}

nlohmann::json Summary(std::vector<double>& milliseconds) {
  return {{"calls", milliseconds.size()},
          {"p50_ms", Percentile(milliseconds, 0.5)},
          {"p99_ms", Percentile(milliseconds, 0.99)},
          {"max_ms", Percentile(milliseconds, 1.0)}};
}

nlohmann::json Compare(std::vector<double>& quiet, std::vector<double>& computing, std::vector<double>& merging) {
  const auto ratio = [&](std::vector<double>& to, double p) { return Percentile(merging, p) / Percentile(to, p); };
  return {{"quiet", Summary(quiet)},
          {"computing", Summary(computing)},
          {"merging", Summary(merging)},
          {"ratio_p50", ratio(quiet, 0.5)},
          {"ratio_p99", ratio(quiet, 0.99)},
          {"ratio_p50_to_computing", ratio(computing, 0.5)},
          {"ratio_p99_to_computing", ratio(computing, 0.99)}};
}

void Compute(double milliseconds) {
  for (const Clock::time_point begin = Clock::now(); MillisecondsSince(begin) < milliseconds;) {
  }
}

void Sleep(double milliseconds) {
  std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(milliseconds));
}

// Of all rounds.
struct Rounds {
  std::vector<double> merge_ms, undo_ms;
  Readers::Latencies quiet, computing, merging;
};

void RunRound(const TwoMaps& maps, Readers& readers, Rounds& rounds) {
  v1::Rearrangement made;
  Clock::time_point begin;
  const auto during = readers.During([&] {
    begin = Clock::now();
    made = maps.Merge();
    rounds.merge_ms.push_back(MillisecondsSince(begin));
  });
  Append(during, rounds.merging);
  begin = Clock::now();
  maps.Undo(made);
  rounds.undo_ms.push_back(MillisecondsSince(begin));
  const double took = rounds.merge_ms.back();
  std::cerr << "merged in " << took << " ms, undone in " << rounds.undo_ms.back() << " ms\n";
  Sleep(1000.0);  // the graph is solved again
  Append(readers.During([&] { Sleep(took); }), rounds.quiet);
  Append(readers.During([&] { Compute(took); }), rounds.computing);
}

nlohmann::json Measure(int count) {
  BenchSystem system({"mapping.workers=2", "survey.share=0"});
  const TwoMaps maps(system);
  Readers readers(system, maps);
  Rounds rounds;
  for (int i = 0; i < count; ++i) RunRound(maps, readers, rounds);
  const auto times = [](std::vector<double>& ms) {
    return nlohmann::json{{"median", Percentile(ms, 0.5)}, {"max", Percentile(ms, 1.0)}};
  };
  Readers::Latencies &quiet = rounds.quiet, &computing = rounds.computing, &merging = rounds.merging;
  return {{"benchmark", "rearrange"},
          {"sessions_of_map", kSessionsOfMap},
          {"records", maps.records()},
          {"scans", maps.scans()},
          {"rounds", count},
          {"merge_ms", times(rounds.merge_ms)},
          {"undo_ms", times(rounds.undo_ms)},
          {"get_global_pose", Compare(quiet.global_pose, computing.global_pose, merging.global_pose)},
          {"get_graph", Compare(quiet.graph, computing.graph, merging.graph)}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const bool quick = arguments.size() == 1 && arguments[0] == "--quick";
    std::cout << Measure(quick ? 3 : 15).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_rearrange: " << failure.what() << '\n';
    return 1;
  }
}

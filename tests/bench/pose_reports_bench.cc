// SPDX-License-Identifier: Apache-2.0
// Prints JSON: what the pose reports of 1,000 robots, one a second each, cost the server and the database
// (docs/benchmarks.md). usage: bench_pose_reports [--quick]
#include <chrono>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/v1/ingest_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "fmt/format.h"
#include "google/protobuf/util/time_util.h"
#include "nlohmann/json.hpp"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/processor_time.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Stream = grpc::ClientReaderWriter<v1::StreamRecordsRequest, v1::StreamRecordsResponse>;

constexpr int kRobots = 1'000;
constexpr std::chrono::nanoseconds kPeriod = std::chrono::seconds(1);

template <typename Service, typename Request, typename Response>
Response Must(const client::Connection& connection,
              grpc::Status (Service::*method)(grpc::ClientContext*, const Request&, Response*),
              const Request& request) {
  auto response = connection.Call(method, request);
  if (!response.ok()) throw std::runtime_error(response.status().ToString());
  return *std::move(response);
}

// The robots of one site, in one map, each with a stream of its own.
class Robots {
 public:
  Robots(const client::Connection& connection, const std::string& site, int count)
      : stub_(v1::IngestService::NewStub(connection.channel())) {
    v1::CreateSiteRequest request;
    request.set_site_id(site);
    request.mutable_site()->set_display_name(site);
    Must(connection, &v1::SiteService::Stub::CreateSite, request);
    v1::CreateMapRequest map;
    map.set_parent("sites/" + site);
    map.mutable_map()->set_display_name("hall");
    map_ = Must(connection, &v1::MapService::Stub::CreateMap, map).map().name();
    for (int i = 0; i < count; ++i) Add(connection, map.parent(), fmt::format("robot-{}", i));
  }

  // One report of each robot a second, spread evenly, until then.
  void Report(Clock::time_point until) {
    const auto step = kPeriod / static_cast<int>(streams_.size());
    Clock::time_point due = Clock::now();
    for (int round = 0; due < until; ++round) {
      for (const auto& stream : streams_) {
        std::this_thread::sleep_until(due);
        if (!stream->Write(ReportOf(round))) return;  // End() tells why
        due += step;
        ++reports_;
      }
    }
  }

  // Ends the streams; how many reports were refused.
  int End() {
    int refused = 0;
    for (const auto& stream : streams_) {
      stream->WritesDone();
      for (v1::StreamRecordsResponse response; stream->Read(&response);) {
        refused += response.has_pose_report_refused() ? 1 : 0;
      }
      if (const grpc::Status status = stream->Finish(); !status.ok()) throw std::runtime_error(status.error_message());
    }
    return refused;
  }

  int reports() const { return reports_; }

 private:
  void Add(const client::Connection& connection, const std::string& parent, const std::string& id) {
    v1::CreateRobotRequest robot;
    robot.set_parent(parent);
    robot.set_robot_id(id);
    robot.mutable_robot()->set_display_name(id);
    Must(connection, &v1::RobotService::Stub::CreateRobot, robot);
    v1::CreateSessionRequest session;
    session.set_parent(parent);
    session.mutable_session()->set_robot(parent + "/robots/" + id);
    session.mutable_session()->set_map(map_);
    const auto created = Must(connection, &v1::SessionService::Stub::CreateSession, session);
    contexts_.push_back(std::make_unique<grpc::ClientContext>());
    streams_.push_back(stub_->StreamRecords(contexts_.back().get()));
    v1::StreamRecordsRequest open;
    open.mutable_open()->set_session(created.session().name());
    v1::StreamRecordsResponse opened;
    if (!streams_.back()->Write(open) || !streams_.back()->Read(&opened)) throw std::runtime_error("no stream opens");
  }

  v1::StreamRecordsRequest ReportOf(int round) const {
    v1::StreamRecordsRequest request;
    v1::PoseReport& report = *request.mutable_pose_report();
    report.set_map(map_);
    report.mutable_pose_map_robot()->mutable_pose()->set_x(0.1 * round);
    for (int i = 0; i < 9; ++i) report.mutable_pose_map_robot()->add_covariance(i % 4 == 0 ? 0.01 : 0.0);
    *report.mutable_time() = google::protobuf::util::TimeUtil::GetCurrentTime();
    return request;
  }

  std::unique_ptr<v1::IngestService::Stub> stub_;
  std::string map_;
  std::vector<std::unique_ptr<grpc::ClientContext>> contexts_;
  std::vector<std::unique_ptr<Stream>> streams_;
  int reports_ = 0;
};

// Processor time of the server and its database.
struct Use {
  double server_s = 0.0;
  double database_s = 0.0;
};

template <typename Task>
Use Measure(BenchSystem& system, const Task& task) {
  const pid_t server = system.server().process().pid();
  const Use before{ProcessorSeconds(server), ProcessorSecondsOfTree(system.database_pid())};
  task();
  return {ProcessorSeconds(server) - before.server_s,
          ProcessorSecondsOfTree(system.database_pid()) - before.database_s};
}

nlohmann::json Run(BenchSystem& system, int sites, std::chrono::seconds time) {
  std::vector<std::unique_ptr<Robots>> fleet;
  for (int i = 0; i < sites; ++i) {
    fleet.push_back(
        std::make_unique<Robots>(system.server().Connect(), fmt::format("of-{}-{}", sites, i), kRobots / sites));
  }
  const Use idle = Measure(system, [&] { std::this_thread::sleep_for(time); });
  const Use busy = Measure(system, [&] {
    const Clock::time_point until = Clock::now() + time;
    std::vector<std::jthread> threads;
    for (const auto& robots : fleet) threads.emplace_back([&] { robots->Report(until); });
  });
  int reports = 0, refused = 0;
  for (const auto& robots : fleet) {
    refused += robots->End();
    reports += robots->reports();
  }
  const auto seconds = static_cast<double>(time.count());
  return {{"sites", sites},
          {"robots", kRobots},
          {"reports_per_s", reports / seconds},
          {"refused", refused},
          {"database_cores", (busy.database_s - idle.database_s) / seconds},
          {"server_cores", (busy.server_s - idle.server_s) / seconds},
          {"database_cores_idle", idle.database_s / seconds},
          {"server_cores_idle", idle.server_s / seconds}};
}

}  // namespace
}  // namespace enfilade::bench

int main(int argc, char** argv) {
  try {
    const bool quick = argc == 2 && std::string(argv[1]) == "--quick";
    enfilade::bench::BenchSystem system;
    nlohmann::json document = {{"benchmark", "pose reports"}};
    for (const int sites : {1, 20}) {
      document["fleets"].push_back(enfilade::bench::Run(system, sites, std::chrono::seconds(quick ? 10 : 60)));
    }
    std::cout << document.dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_pose_reports: " << failure.what() << '\n';
    return 1;
  }
}

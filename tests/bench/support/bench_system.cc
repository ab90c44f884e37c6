// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/bench_system.h"

#include <chrono>
#include <stdexcept>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/robot_service.grpc.pb.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "tests/support/command.h"

namespace enfilade::bench {
namespace {

constexpr char kSite[] = "sites/bench";
constexpr std::chrono::seconds kSettleTimeout{900};

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

}  // namespace

BenchSystem::BenchSystem(std::vector<std::string> settings)
    : cluster_(testing::Cluster::Durability::kDurable),
      server_(directory_.path(), "server", cluster_.url(), std::move(settings)) {
  const auto migrate = testing::RunCommand({testing::ProjectFile("deploy/database/migrate"), "up", cluster_.url()});
  if (migrate.exit_code != 0) throw std::runtime_error("the migrations failed:\n" + migrate.output);
  server_.StartAndWait();
  v1::CreateSiteRequest site;
  site.set_site_id("bench");
  site.mutable_site()->set_display_name("bench");
  Must(server_.Connect().Call(&v1::SiteService::Stub::CreateSite, site));
  v1::CreateRobotRequest robot;
  robot.set_parent(kSite);
  robot.set_robot_id("robot");
  robot.mutable_robot()->set_display_name("robot");
  Must(server_.Connect().Call(&v1::RobotService::Stub::CreateRobot, robot));
}

std::vector<std::string> BenchSystem::CreateSessions(int count) {
  const client::Connection connection = server_.Connect();
  std::vector<std::string> names;
  for (int i = 0; i < count; ++i) {
    v1::CreateSessionRequest request;
    request.set_parent(kSite);
    request.mutable_session()->set_robot(std::string(kSite) + "/robots/robot");
    request.set_session_id("session-" + std::to_string(++sessions_));
    names.push_back(Must(connection.Call(&v1::SessionService::Stub::CreateSession, request)).session().name());
  }
  return names;
}

std::string BenchSystem::CreateMap(const std::string& display_name) {
  v1::CreateMapRequest request;
  request.set_parent(kSite);
  request.mutable_map()->set_display_name(display_name);
  return Must(server_.Connect().Call(&v1::MapService::Stub::CreateMap, request)).map().name();
}

std::int64_t BenchSystem::Settle(const std::string& site) {
  const client::Connection connection(server_.address(), kSettleTimeout);
  v1::OptimizeGraphRequest optimize;
  optimize.set_site(site);
  const std::int64_t version = Must(connection.Call(&v1::GraphService::Stub::OptimizeGraph, optimize)).graph_version();
  v1::FindLinkPointsRequest find;
  find.set_parent(site);
  find.set_radius_m(1.0);
  find.mutable_point_world();
  // Reading a large graph for the first time takes longer than a call waits for a version.
  const auto give_up = std::chrono::steady_clock::now() + kSettleTimeout;
  while (std::chrono::steady_clock::now() < give_up) {
    auto found = connection.Call(&v1::LinkPointService::Stub::FindLinkPoints, find);
    if (!absl::IsUnavailable(found.status()) && Must(std::move(found)).graph_version() >= version) return version;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  throw std::runtime_error(site + " did not settle");
}

}  // namespace enfilade::bench

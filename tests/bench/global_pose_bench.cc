// SPDX-License-Identifier: Apache-2.0
// Prints JSON: the rate of GetGlobalPose beside a gRPC server that echoes a message of the same size.
// usage: bench_global_pose [--quick]
#include <atomic>
#include <chrono>
#include <fstream>
#include <iostream>
#include <thread>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "fmt/format.h"
#include "grpcpp/grpcpp.h"
#include "nlohmann/json.hpp"
#include "storage/postgres/driver/pool.h"
#include "storage/postgres/graph/link_point_store.h"
#include "storage/postgres/maps/map_store.h"
#include "tests/bench/support/bare_echo.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;

constexpr int kClients = 4;
constexpr int kRooms = 40;

enfilade::storage::CallContext Soon() { return enfilade::storage::CallContext::WithTimeout(std::chrono::seconds(60)); }
void Must(const absl::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.ToString());
}

// A row of rooms, each 5 m behind the one before.
void MakeRooms(storage::postgres::Pool& pool) {
  for (int i = 0; i < kRooms; ++i) {
    enfilade::storage::Map map;
    map.site = SiteId("bench");
    map.id = MapId(fmt::format("room-{}", i));
    map.display_name = map.id.value();
    Must(enfilade::storage::postgres::MapStore(pool).Create(Soon(), map, "").status());
    if (i == 0) continue;
    enfilade::storage::StoredLinkPoint door;
    door.site = map.site;
    door.point.id = LinkPointId(fmt::format("door-{}", i));
    door.point.anchors = {{MapId(fmt::format("room-{}", i - 1)), {5, 0, 0}, enfilade::graph::DefaultAnchorCovariance()},
                          {map.id, {}, enfilade::graph::DefaultAnchorCovariance()}};
    Must(enfilade::storage::postgres::LinkPointStore(pool).Create(Soon(), door, "").status());
  }
}

v1::GetGlobalPoseRequest Request() {
  v1::GetGlobalPoseRequest request;
  request.mutable_map_pose()->set_map("sites/bench/maps/room-20");
  v1::PoseWithCovariance& pose = *request.mutable_map_pose()->mutable_pose_map_robot();
  pose.mutable_pose()->set_x(1.5);
  pose.mutable_pose()->set_y(0.25);
  pose.mutable_pose()->set_yaw(0.5);
  for (int i = 0; i < 9; ++i) pose.add_covariance(i % 4 == 0 ? 0.003 : 0.0);
  return request;
}

// Calls per second of kClients threads, each with a connection of its own.
double Rate(const std::string& address, std::chrono::duration<double> time) {
  std::atomic<std::int64_t> calls{0};
  std::atomic<bool> failed{false};
  const auto until = std::chrono::steady_clock::now() + time;
  std::vector<std::thread> threads;
  for (int i = 0; i < kClients; ++i) {
    threads.emplace_back([&] {
      grpc::ChannelArguments arguments;
      arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      const auto stub =
          v1::GraphService::NewStub(grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments));
      const v1::GetGlobalPoseRequest request = Request();
      v1::GetGlobalPoseResponse response;
      while (std::chrono::steady_clock::now() < until) {
        grpc::ClientContext context;
        if (!stub->GetGlobalPose(&context, request, &response).ok()) failed = true;
        ++calls;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  if (failed) throw std::runtime_error("a call failed");
  return static_cast<double>(calls) / time.count();
}

v1::GetGlobalPoseResponse Ask(const enfilade::client::Connection& connection) {
  auto response = connection.Call(&v1::GraphService::Stub::GetGlobalPose, Request());
  if (!response.ok()) throw std::runtime_error(response.status().ToString());
  return *std::move(response);
}

nlohmann::json Measure(int rounds, std::chrono::duration<double> time) {
  BenchSystem system({"mapping.workers=0"});
  storage::postgres::PoolOptions options;
  options.url = system.database_url();
  auto pool = storage::postgres::Pool::Create(options);
  Must(pool.status());
  MakeRooms(**pool);
  const enfilade::client::Connection server = system.server().Connect();
  // Until the graph is solved: its version then stays.
  v1::GetGlobalPoseResponse response = Ask(server);
  while (response.global_pose().solution_version() != response.global_pose().graph_version()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    response = Ask(server);
  }
  const std::filesystem::path file = system.directory() / "response";
  std::ofstream(file, std::ios::binary) << response.SerializeAsString();
  const std::string bare_address = "unix:" + (system.directory() / "bare.sock").string();
  testing::Process bare_server({testing::Program("bench_global_pose"), "--serve-bare", bare_address, file.string()},
                               system.directory() / "bare.log");
  const enfilade::client::Connection bare(bare_address, std::chrono::seconds(60));
  if (!bare.channel()->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(60))) {
    throw std::runtime_error("the echo's server does not come up");
  }
  std::vector<double> served;
  std::vector<double> echoed;
  std::vector<double> ratios;
  Rate(system.server().address(), time / 4);
  Rate(bare_address, time / 4);
  for (int i = 0; i < rounds; ++i) {
    const double before = Rate(bare_address, time / 2);
    served.push_back(Rate(system.server().address(), time));
    echoed.push_back((before + Rate(bare_address, time / 2)) / 2.0);
    ratios.push_back(served.back() / echoed.back());
    std::cerr << "served " << served.back() << " / s, echo " << echoed.back() << " / s\n";
  }
  return {{"benchmark", "global pose"},
          {"clients", kClients},
          {"request_bytes", Request().ByteSizeLong()},
          {"response_bytes", response.ByteSizeLong()},
          {"rounds", rounds},
          {"calls_per_s", Percentile(served, 0.5)},
          {"echo_calls_per_s", Percentile(echoed, 0.5)},
          {"ratio", Percentile(ratios, 0.5)},
          {"ratio_min", Percentile(ratios, 0.0)},
          {"ratio_max", Percentile(ratios, 1.0)}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() == 3 && arguments[0] == "--serve-bare") {
      ServeBareEcho(arguments[1], arguments[2]);
      return 0;
    }
    const bool quick = arguments.size() == 1 && arguments[0] == "--quick";
    std::cout << Measure(quick ? 3 : 9, std::chrono::duration<double>(quick ? 2.0 : 5.0)).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_global_pose: " << failure.what() << '\n';
    return 1;
  }
}

// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long a session takes from its first record until it is mapped, in a map with 400 old layers beside
// the same in a map with one. The layers are copies of one session's.
// usage: bench_layers [--quick]
#include <chrono>
#include <cstdint>
#include <iostream>
#include <stdexcept>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "client/simulator/simulation.h"
#include "enfilade/v1/session_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "proto/convert/geometry.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"
#include "tests/support/command.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

constexpr int kOldLayers = 400;

template <typename T>
T Must(absl::StatusOr<T> value) {
  if (!value.ok()) throw std::runtime_error(value.status().ToString());
  return *std::move(value);
}

std::vector<LoadBatch> Drive(std::uint64_t seed) {
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
  return ToBatches(records, 200);
}

class Replays {
 public:
  explicit Replays(BenchSystem& system) : system_(system), server_(system.server().Connect()) {}

  // Seconds until the drive is mapped as a session of the map.
  double Replay(const std::string& map, const std::vector<LoadBatch>& drive) {
    v1::CreateSessionRequest request;
    request.set_parent("sites/bench");
    request.mutable_session()->set_robot("sites/bench/robots/robot");
    request.mutable_session()->set_map(map);
    *request.mutable_session()->mutable_entry()->mutable_pose_map_robot() = convert::ToProto(PoseWithCovariance{});
    const std::string session = Must(server_.Call(&v1::SessionService::Stub::CreateSession, request)).session().name();
    const Clock::time_point begin = Clock::now();
    const LoadResult sent = LoadGenerator({system_.server().address(), {session}, 8}, drive).Run();
    if (!sent.error.empty()) throw std::runtime_error(sent.error);
    v1::FinishSessionRequest finish;
    finish.set_name(session);
    finish.set_last_sequence(sent.acknowledged);
    Must(server_.Call(&v1::SessionService::Stub::FinishSession, finish));
    v1::GetSessionRequest get;
    get.set_name(session);
    for (;;) {
      const v1::Session stored = Must(server_.Call(&v1::SessionService::Stub::GetSession, get)).session();
      if (stored.state() == v1::Session::STATE_MAPPED) break;
      if (stored.state() == v1::Session::STATE_FAILED) throw std::runtime_error(stored.error());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }
  // Copies of the only layer of the map.
  void AddOldLayers(const std::string& map, int count) const {
    const std::string id = map.substr(map.rfind('/') + 1);
    const std::string sql = fmt::format(
        "SET search_path = enfilade, public;"
        "INSERT INTO sessions SELECT (jsonb_populate_record(s, jsonb_build_object('session_id', 'old' || n,"
        "   'request_id', NULL))).* FROM sessions s, generate_series(1, {1}) n"
        "   WHERE session_id = (SELECT session_id FROM map_layers WHERE map_id = '{0}');"
        "INSERT INTO map_layers (site_id, map_id, position, session_id, raster_header, version)"
        " SELECT l.site_id, l.map_id, 1 + n, 'old' || n, r.raster_header, 1 + n FROM map_layers l"
        "   JOIN map_revisions r USING (site_id, map_id, revision), generate_series(1, {1}) n WHERE l.map_id = '{0}';"
        "INSERT INTO map_layer_tiles SELECT t.site_id, t.map_id, 1 + n, t.tile_row, t.tile_column, t.sha256"
        " FROM map_layers l JOIN map_revision_tiles t USING (site_id, map_id, revision), generate_series(1, {1}) n"
        "   WHERE l.map_id = '{0}';"
        "UPDATE map_layer_stacks SET version = 1 + {1} WHERE map_id = '{0}'",
        id, count);
    const auto result = testing::RunCommand({"psql", system_.database_url(), "-Xqv", "ON_ERROR_STOP=1", "-c", sql});
    if (result.exit_code != 0) throw std::runtime_error(result.output);
  }

 private:
  BenchSystem& system_;
  const client::Connection server_;
};

nlohmann::json Measure(int rounds) {
  BenchSystem system(
      {"mapping.workers=1", "survey.share=0", "mapping.checkpoint_interval_s=0.5", "mapping.revision_interval_s=0.5"});
  Replays replays(system);
  const std::string fresh = system.CreateMap("Fresh"), old = system.CreateMap("Old");
  replays.Replay(fresh, Drive(1));
  replays.Replay(old, Drive(1));
  replays.AddOldLayers(old, kOldLayers);
  const std::vector<LoadBatch> drive = Drive(2);
  const double first = replays.Replay(old, drive);
  std::vector<double> few, many, ratios;
  for (int i = 0; i < rounds; ++i) {
    few.push_back(replays.Replay(fresh, drive));
    many.push_back(replays.Replay(old, drive));
    ratios.push_back(many.back() / few.back());
    std::cerr << fmt::format("{:.2f} s with few layers, {:.2f} s with many\n", few.back(), many.back());
  }
  return {{"benchmark", "layers"},
          {"old_layers", kOldLayers},
          {"rounds", rounds},
          {"few_layers_s", Percentile(few, 0.5)},
          {"many_layers_s", Percentile(many, 0.5)},
          {"ratio", Percentile(ratios, 0.5)},
          {"ratio_min", Percentile(ratios, 0.0)},
          {"ratio_max", Percentile(ratios, 1.0)},
          {"first_with_many_layers_s", first}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    const bool quick = arguments.size() == 1 && arguments[0] == "--quick";
    std::cout << Measure(quick ? 3 : 9).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_layers: " << failure.what() << '\n';
    return 1;
  }
}

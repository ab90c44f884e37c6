// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long AppendMapEdits takes for 100 edits, and PublishMapDraft for 1,000, by gRPC, on a map of
// 4,000 x 4,000 cells (200 m x 200 m).
// usage: bench_map_edits [--quick]
#include <algorithm>
#include <chrono>
#include <iostream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "enfilade/v1/map_edit_service.grpc.pb.h"
#include "fmt/format.h"
#include "nlohmann/json.hpp"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/large_maps.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

constexpr int kEditsOfACall = 100;

// Strokes as people draw them: up to 4 m in 8 segments, 0.1 to 0.5 m wide, anywhere; every fourth is a rectangle.
class Strokes {
 public:
  // Within the cells of the box.
  Strokes(const v1::CellBox& box, std::uint32_t seed) : box_(box), rng_(seed) {}

  v1::MapEdit Next() {
    v1::MapEdit edit;
    edit.set_edit_id(fmt::format("edit-{}", ++count_));
    edit.set_author("bench");
    edit.set_value(count_ % 2 == 0 ? v1::MapEdit::VALUE_OCCUPIED : v1::MapEdit::VALUE_FREE);
    const int x = 256 * box_.first_column() + Within(0, 256 * box_.width() - kReach);
    const int y = 256 * box_.first_row() + Within(0, 256 * box_.height() - kReach);
    if (count_ % 4 == 0) {
      const int width = Within(512, kReach), height = Within(512, kReach);
      v1::LatticeRing& ring = *edit.mutable_polygon()->add_rings();
      for (const auto& [dx, dy] : {std::pair(0, 0), {width, 0}, {width, height}, {0, height}}) {
        AddPoint(x + dx, y + dy, *ring.mutable_points());
      }
      return edit;
    }
    edit.mutable_brush()->set_radius(Within(256, 1'280));
    for (int i = 0; i < 9; ++i) {
      AddPoint(x + i * Within(0, kReach / 8), y + i * Within(0, kReach / 8), *edit.mutable_brush()->mutable_points());
    }
    return edit;
  }

 private:
  int Within(int low, int high) { return std::uniform_int_distribution<int>(low, high)(rng_); }
  template <typename Points>
  static void AddPoint(int x, int y, Points& points) {
    v1::LatticePoint& point = *points.Add();
    point.set_x(x);
    point.set_y(y);
  }

  static constexpr int kReach = 80 * 256;

  const v1::CellBox box_;
  std::mt19937 rng_;
  int count_ = 0;
};

nlohmann::json Summary(std::vector<double> times) {
  std::sort(times.begin(), times.end());
  return {{"calls", times.size()},
          {"p50_ms", times[times.size() / 2]},
          {"p95_ms", times[times.size() * 95 / 100]},
          {"max_ms", times.back()}};
}

// Of a call, in ms.
template <typename Method, typename Request>
double Time(const client::Connection& connection, Method method, const Request& request) {
  const auto begin = Clock::now();
  Must(connection.Call(method, request).status());
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// A room of 20 m in the middle, as one person draws in; the rest of the map is not touched.
v1::CellBox RoomIn(const v1::CellBox& map) {
  constexpr int kSide = 400;
  v1::CellBox room;
  room.set_first_column(map.first_column() + (map.width() - kSide) / 2);
  room.set_first_row(map.first_row() + (map.height() - kSide) / 2);
  room.set_width(kSide);
  room.set_height(kSide);
  return room;
}

v1::MapDraft NewDraft(const client::Connection& connection, const std::string& map) {
  v1::CreateMapDraftRequest create;
  create.set_parent(map);
  create.mutable_draft()->set_author("bench");
  return Must(connection.Call(&v1::MapEditService::Stub::CreateMapDraft, create)).draft();
}

double Append(const client::Connection& connection, const std::string& draft, Strokes& strokes) {
  v1::AppendMapEditsRequest append;
  append.set_name(draft);
  for (int edit = 0; edit < kEditsOfACall; ++edit) *append.add_edits() = strokes.Next();
  return Time(connection, &v1::MapEditService::Stub::AppendMapEdits, append);
}

nlohmann::json Run(int side, int publications, int calls_before_publishing) {
  BenchSystem system({"mapping.workers=0"});
  const auto pool = Must(storage::postgres::Pool::Create({.url = system.database_url()}));
  const client::Connection connection = system.server().Connect();
  const std::string map = StoreMap(system, *pool, "Floor", {grid::FromOccupancyGrid(RobotsFloor(side))});
  std::vector<double> appends_in_a_room, appends, checks, publishes;
  for (int i = 0; i < publications; ++i) {
    const v1::MapDraft draft = NewDraft(connection, map);
    v1::ReadMapDraftTilesRequest extent;
    extent.set_name(draft.name());
    const v1::CellBox box = Must(connection.Call(&v1::MapEditService::Stub::ReadMapDraftTiles, extent)).box();
    Strokes in_a_room(RoomIn(box), static_cast<std::uint32_t>(i) + 1);
    const v1::MapDraft room = NewDraft(connection, map);
    for (int call = 0; call < calls_before_publishing; ++call) {
      appends_in_a_room.push_back(Append(connection, room.name(), in_a_room));
    }
    Strokes strokes(box, static_cast<std::uint32_t>(i) + 1);
    for (int call = 0; call < calls_before_publishing; ++call) {
      appends.push_back(Append(connection, draft.name(), strokes));
    }
    v1::CheckMapDraftRequest check;
    check.set_name(draft.name());
    checks.push_back(Time(connection, &v1::MapEditService::Stub::CheckMapDraft, check));
    v1::PublishMapDraftRequest publish;
    publish.set_name(draft.name());
    publish.set_message(fmt::format("publication {}", i + 1));
    publish.set_confirm_warnings(true);
    publishes.push_back(Time(connection, &v1::MapEditService::Stub::PublishMapDraft, publish));
  }
  return {{"benchmark", "edits of maps"},
          {"cells", std::int64_t{side} * side},
          {"edits of a call", kEditsOfACall},
          {"edits of a publication", kEditsOfACall * calls_before_publishing},
          {"append in a room", Summary(appends_in_a_room)},
          {"append all over", Summary(appends)},
          {"check", Summary(checks)},
          {"publish", Summary(publishes)}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
    std::cout << (quick ? Run(1000, 2, 2) : Run(4000, 11, 10)).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_map_edits: " << failure.what() << '\n';
    return 1;
  }
}

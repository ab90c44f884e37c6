// SPDX-License-Identifier: Apache-2.0
// Prints JSON: the rate of downloads of a large map beside a bare gRPC stream of the same bytes.
// usage: bench_transfer [--quick]
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <random>

#include "enfilade/v1/map_service.grpc.pb.h"
#include "nlohmann/json.hpp"
#include "tests/bench/support/bare_stream.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"
#include "tests/support/command.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using testing::RunCommand;

// A floor of rooms: free rectangles with walls around them, the rest unknown. Square, of about `megabytes`.
std::string WriteMap(const std::filesystem::path& directory, int megabytes) {
  const int side = static_cast<int>(std::sqrt(megabytes * 1e6));
  std::string cells(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), '\xCD');
  std::mt19937_64 random(1);
  const auto fill = [&](int x0, int y0, int width, int height, char value) {
    for (int y = y0; y < y0 + height; ++y) {
      const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(side) + static_cast<std::size_t>(x0);
      std::fill_n(cells.begin() + static_cast<std::ptrdiff_t>(row), width, value);
    }
  };
  for (int i = 0; i < side; ++i) {
    const int width = 50 + static_cast<int>(random() % 400);
    const int height = 50 + static_cast<int>(random() % 400);
    const int x = static_cast<int>(random() % static_cast<unsigned>(side - width));
    const int y = static_cast<int>(random() % static_cast<unsigned>(side - height));
    fill(x, y, width, height, '\0');
    fill(x + 2, y + 2, width - 4, height - 4, '\xFE');
  }
  std::ofstream(directory / "floor.pgm", std::ios::binary) << "P5\n" << side << ' ' << side << "\n255\n" << cells;
  std::ofstream(directory / "floor.yaml") << "image: floor.pgm\nmode: trinary\nresolution: 0.05\norigin: [0, 0, 0]\n"
                                             "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
  return (directory / "floor.yaml").string();
}

struct Download {
  double seconds = 0.0;
  std::int64_t bytes = 0;
};

Download Receive(const enfilade::client::Connection& connection, const std::string& name) {
  v1::ExportMapRequest request;
  request.set_name(name);
  request.set_format(v1::MAP_FORMAT_PGM);
  grpc::ClientContext context;
  const auto begin = std::chrono::steady_clock::now();
  const auto reader = v1::MapService::NewStub(connection.channel())->ExportMap(&context, request);
  Download download;
  v1::ExportMapResponse message;
  while (reader->Read(&message)) download.bytes += static_cast<std::int64_t>(message.chunk().data().size());
  if (const grpc::Status status = reader->Finish(); !status.ok()) throw std::runtime_error(status.error_message());
  download.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return download;
}

nlohmann::json Measure(int megabytes, int rounds) {
  BenchSystem system({"mapping.workers=0"});
  const std::string yaml = WriteMap(system.directory(), megabytes);
  const auto file_bytes = static_cast<std::int64_t>(std::filesystem::file_size(system.directory() / "floor.pgm"));
  const auto import_begin = std::chrono::steady_clock::now();
  const auto imported = RunCommand({testing::Program("enfilade"), "--server", system.server().address(), "--site",
                                    "bench", "--timeout", "600", "map", "import", yaml, "--map", "Floor"});
  if (imported.exit_code != 0) throw std::runtime_error(imported.output);
  const double import_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - import_begin).count();

  const std::string bare_address = "unix:" + (system.directory() / "bare.sock").string();
  testing::Process bare_server(
      {testing::Program("bench_transfer"), "--serve-bare", bare_address, (system.directory() / "floor.pgm").string()},
      system.directory() / "bare.log");
  const enfilade::client::Connection bare(bare_address, std::chrono::seconds(60));
  if (!bare.channel()->WaitForConnected(std::chrono::system_clock::now() + std::chrono::seconds(60))) {
    throw std::runtime_error("the bare stream's server does not come up");
  }
  const enfilade::client::Connection server = system.server().Connect();
  v1::ListMapsRequest list;
  list.set_parent("sites/bench");
  const auto maps = server.Call(&v1::MapService::Stub::ListMaps, list);
  if (!maps.ok() || maps->maps_size() != 1) throw std::runtime_error("the imported map is not there");
  const std::string name = maps->maps(0).name();

  const Download first = Receive(server, name);  // renders the file
  Receive(bare, name);
  std::vector<double> served;
  std::vector<double> streamed;
  std::vector<double> ratios;
  for (int i = 0; i < rounds; ++i) {
    const auto rate = [](const Download& download) {
      return static_cast<double>(download.bytes) / download.seconds / 1e6;
    };
    const double before = rate(Receive(bare, name));
    served.push_back(rate(Receive(server, name)));
    streamed.push_back((before + rate(Receive(bare, name))) / 2.0);
    ratios.push_back(served.back() / streamed.back());
    std::cerr << "served " << served.back() << " MB/s, bare " << streamed.back() << " MB/s\n";
  }
  return {{"benchmark", "map download"},
          {"map_bytes", file_bytes},
          {"rounds", rounds},
          {"mb_per_s", Percentile(served, 0.5)},
          {"bare_mb_per_s", Percentile(streamed, 0.5)},
          {"ratio", Percentile(ratios, 0.5)},
          {"ratio_min", Percentile(ratios, 0.0)},
          {"ratio_max", Percentile(ratios, 1.0)},
          {"first_download_s", first.seconds},
          {"import_s", import_s},
          {"server_peak_rss_mib",
           static_cast<double>(testing::ResidentBytes(system.server().process().pid(), "VmHWM")) / (1 << 20)}};
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> arguments(argv + 1, argv + argc);
    if (arguments.size() == 3 && arguments[0] == "--serve-bare") {
      ServeBareStream(arguments[1], arguments[2]);
      return 0;
    }
    const bool quick = arguments.size() == 1 && arguments[0] == "--quick";
    std::cout << Measure(quick ? 20 : 200, quick ? 3 : 9).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_transfer: " << failure.what() << '\n';
    return 1;
  }
}

// SPDX-License-Identifier: Apache-2.0
// Prints JSON: how long GetSite takes while nine clients export one map of 256 megapixels that is not cached, and ten
// read the graph of a site of 20,000 maps that the server does not have in memory; beside the same when the server is
// quiet. usage: bench_heavy_calls [--quick]
#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"
#include "grpcpp/grpcpp.h"
#include "nlohmann/json.hpp"
#include "tests/bench/growth/big_site.h"
#include "tests/bench/support/bench_system.h"
#include "tests/bench/support/load_generator.h"
#include "tests/support/command.h"

namespace {

using namespace enfilade;
using namespace enfilade::bench;
using Clock = std::chrono::steady_clock;

constexpr int kNicenessOfClients = 10;
constexpr int kExports = 9;
constexpr int kGraphs = 10;
constexpr auto kPause = std::chrono::milliseconds(2);  // between two calls of GetSite
constexpr auto kQuiet = std::chrono::seconds(5);

struct Sizes {
  int side = 16'384;  // of the map, pixels
  int maps = 20'000;
};

double MillisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

// Imports a map of stripes. Its resource name.
std::string ImportLargeMap(BenchSystem& system, int side) {
  const auto pixels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  std::string cells(pixels, '\xFE');
  for (std::size_t i = 0; i < pixels; i += 97) cells[i] = '\0';
  std::ofstream(system.directory() / "large.pgm", std::ios::binary) << "P5\n"
                                                                    << side << ' ' << side << "\n255\n"
                                                                    << cells;
  const std::string yaml = (system.directory() / "large.yaml").string();
  std::ofstream(yaml) << "image: large.pgm\nmode: trinary\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
                         "occupied_thresh: 0.65\nfree_thresh: 0.196\n";
  const auto imported =
      testing::RunCommand({testing::Program("enfilade"), "--server", system.server().address(), "--site", "bench",
                           "--timeout", "600", "map", "import", yaml, "--map", "Large"});
  if (imported.exit_code != 0) throw std::runtime_error(imported.output);
  v1::ListMapsRequest request;
  request.set_parent("sites/bench");
  const auto maps = system.server().Connect().Call(&v1::MapService::Stub::ListMaps, request);
  if (!maps.ok() || maps->maps_size() != 1) throw std::runtime_error("the imported map is not there");
  return maps->maps(0).name();
}

// Not shared with other channels of this process.
std::shared_ptr<grpc::Channel> ConnectAlone(BenchSystem& system) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return grpc::CreateCustomChannel(system.server().address(), grpc::InsecureChannelCredentials(), arguments);
}

void Check(const grpc::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

void Export(const std::shared_ptr<grpc::Channel>& channel, const std::string& map) {
  v1::ExportMapRequest request;
  request.set_name(map);
  request.set_format(v1::MAP_FORMAT_PGM);
  grpc::ClientContext context;
  const auto reader = v1::MapService::NewStub(channel)->ExportMap(&context, request);
  v1::ExportMapResponse message;
  while (reader->Read(&message)) {
  }
  Check(reader->Finish());
}

void ReadFirstPage(const std::shared_ptr<grpc::Channel>& channel, const std::string& site) {
  v1::GetGraphRequest request;
  request.set_site(site);
  request.set_page_size(1000);
  grpc::ClientContext context;
  v1::GetGraphResponse page;
  Check(v1::GraphService::NewStub(channel)->GetGraph(&context, request, &page));
}

// Calls GetSite until `done`.
nlohmann::json MeasureGetSite(v1::SiteService::Stub& stub, const std::function<bool()>& done) {
  v1::GetSiteRequest request;
  request.set_name("sites/bench");
  std::vector<double> times;
  while (!done()) {
    const auto begin = Clock::now();
    grpc::ClientContext context;
    v1::GetSiteResponse site;
    Check(stub.GetSite(&context, request, &site));
    times.push_back(MillisecondsSince(begin));
    std::this_thread::sleep_for(kPause);
  }
  const std::size_t calls = times.size();
  return {{"calls", calls},
          {"p50_ms", Percentile(times, 0.5)},
          {"p99_ms", Percentile(times, 0.99)},
          {"max_ms", Percentile(times, 1.0)}};
}

// Each with a connection of its own, all at the same time.
class HeavyCalls {
 public:
  HeavyCalls(BenchSystem& system, const std::string& map, const std::string& site) {
    for (int i = 0; i < kExports; ++i) {
      Start(exports_ms_, [map, channel = ConnectAlone(system)] { Export(channel, map); });
    }
    for (int i = 0; i < kGraphs; ++i) {
      Start(graphs_ms_, [site, channel = ConnectAlone(system)] { ReadFirstPage(channel, site); });
    }
  }
  ~HeavyCalls() {
    for (std::thread& thread : threads_) thread.join();
  }
  bool done() const { return running_ == 0; }
  nlohmann::json Times() {
    if (!error_.empty()) throw std::runtime_error(error_);
    return {{"exports_s", Percentile(exports_ms_, 1.0) / 1e3}, {"graphs_s", Percentile(graphs_ms_, 1.0) / 1e3}};
  }

 private:
  void Start(std::vector<double>& times, std::function<void()> call) {
    ++running_;
    threads_.emplace_back([this, &times, call = std::move(call)] {
      // They stand for other machines: what they compute must not be what is measured.
      setpriority(PRIO_PROCESS, 0, kNicenessOfClients);
      const auto begin = Clock::now();
      std::string error;
      try {
        call();
      } catch (const std::exception& failure) {
        error = failure.what();
      }
      const std::lock_guard lock(mutex_);
      times.push_back(MillisecondsSince(begin));
      if (!error.empty()) error_ = error;
      --running_;
    });
  }

  std::mutex mutex_;
  std::vector<double> exports_ms_;
  std::vector<double> graphs_ms_;
  std::string error_;
  std::atomic<int> running_ = 0;
  std::vector<std::thread> threads_;
};

nlohmann::json Measure(const Sizes& sizes, int rounds) {
  BenchSystem system({"mapping.workers=0", "survey.share=0"});
  AddSites(system, 1, sizes.maps);
  const std::string map = ImportLargeMap(system, sizes.side);
  nlohmann::json document = {{"benchmark", "heavy calls"}, {"map_pixels", std::int64_t{sizes.side} * sizes.side},
                             {"maps", sizes.maps},         {"exports", kExports},
                             {"graphs", kGraphs},          {"rounds", nlohmann::json::array()}};
  for (int i = 0; i < rounds; ++i) {
    system.server().Kill();
    system.server().StartAndWait();  // with neither files nor graphs
    const auto stub = v1::SiteService::NewStub(ConnectAlone(system));
    const auto begin = Clock::now();
    nlohmann::json round = {{"quiet", MeasureGetSite(*stub, [begin] { return Clock::now() - begin > kQuiet; })}};
    HeavyCalls heavy(system, map, "sites/size-" + std::to_string(sizes.maps) + "-0");
    round["meanwhile"] = MeasureGetSite(*stub, [&heavy] { return heavy.done(); });
    round["heavy_calls"] = heavy.Times();
    std::cerr << round.dump() << '\n';
    document["rounds"].push_back(std::move(round));
  }
  return document;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
    std::cout << Measure(quick ? Sizes{4'096, 2'000} : Sizes{}, quick ? 1 : 3).dump(2) << '\n';
  } catch (const std::exception& failure) {
    std::cerr << "bench_heavy_calls: " << failure.what() << '\n';
    return 1;
  }
}

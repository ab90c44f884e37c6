// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/fleet/fleet_readers.h"

#include <chrono>
#include <utility>

#include "client/sdk/api/map_export.h"
#include "core/base/resource_name.h"
#include "enfilade/v1/graph_service.grpc.pb.h"
#include "enfilade/v1/map_service.grpc.pb.h"
#include "enfilade/v1/site_service.grpc.pb.h"

namespace enfilade::bench {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kProbeEvery = std::chrono::milliseconds(50);
constexpr auto kExportEvery = std::chrono::seconds(1);
constexpr double kWatchHz = 5.0;

}  // namespace

FleetReaders::FleetReaders(const client::Connection& connection, std::vector<SiteId> sites, int watchers, int exporters,
                           std::filesystem::path folder)
    : connection_(connection), sites_(std::move(sites)), folder_(std::move(folder)) {
  for (int i = 0; i < watchers; ++i) watches_.push_back(std::make_unique<grpc::ClientContext>());
  for (std::size_t i = 0; i < watches_.size(); ++i) {
    threads_.emplace_back([this, i] { Watch(sites_[i % sites_.size()], *watches_[i]); });
  }
  for (int i = 0; i < exporters; ++i) {
    threads_.emplace_back(
        [this, i] { Export(static_cast<std::size_t>(i), folder_ / ("export-" + std::to_string(i))); });
  }
  threads_.emplace_back([this] { Probe(); });
}

FleetReaders::~FleetReaders() { Stop(); }

FleetReaders::Counts FleetReaders::Stop() {
  stop_ = true;
  for (const auto& context : watches_) context->TryCancel();
  for (std::thread& thread : threads_) thread.join();
  threads_.clear();
  MutexLock lock(mutex_);
  return std::exchange(counts_, {});
}

void FleetReaders::Watch(const SiteId& site, grpc::ClientContext& context) {
  const auto stub = v1::GraphService::NewStub(connection_.channel());
  v1::WatchGlobalPosesRequest request;
  request.set_parent(NameOf(site));
  request.set_rate_hz(kWatchHz);
  const auto stream = stub->WatchGlobalPoses(&context, request);
  v1::WatchGlobalPosesResponse response;
  while (stream->Read(&response)) {
    MutexLock lock(mutex_);
    ++counts_.pose_messages;
  }
  const grpc::Status status = stream->Finish();
  MutexLock lock(mutex_);
  if (!stop_) counts_.errors.push_back(status.error_message());
}

void FleetReaders::Export(std::size_t first_site, const std::filesystem::path& folder) {
  for (std::size_t site = first_site; !stop_; ++site) {
    v1::ListMapsRequest request;
    request.set_parent(NameOf(sites_[site % sites_.size()]));
    const auto maps = connection_.Call(&v1::MapService::Stub::ListMaps, request);
    for (int i = 0; maps.ok() && i < maps->maps_size() && !stop_; ++i) {
      v1::ExportMapRequest wanted;
      wanted.set_name(maps->maps(i).name());
      wanted.set_format(v1::MAP_FORMAT_PGM);
      const auto exported = client::ExportMap(connection_, wanted, folder);
      std::this_thread::sleep_for(kExportEvery);
      MutexLock lock(mutex_);
      // A map without a revision yet, or one that became part of another meanwhile.
      const bool usual = absl::IsFailedPrecondition(exported.status()) || absl::IsNotFound(exported.status());
      counts_.exports += exported.ok() ? 1 : 0;
      counts_.exported_bytes += exported.ok() ? exported->bytes : 0;
      if (!exported.ok() && !usual) ++counts_.failed_exports[exported.status().ToString()];
    }
    if (!maps.ok() || maps->maps_size() == 0) std::this_thread::sleep_for(kExportEvery);
  }
}

void FleetReaders::Probe() {
  v1::GetSiteRequest request;
  for (std::size_t i = 0; !stop_; ++i) {
    request.set_name(NameOf(sites_[i % sites_.size()]));
    const Clock::time_point begin = Clock::now();
    const bool ok = connection_.Call(&v1::SiteService::Stub::GetSite, request).ok();
    const double took = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    {
      MutexLock lock(mutex_);
      counts_.get_site_ms.push_back(took);
      counts_.failed_calls += ok ? 0 : 1;
    }
    std::this_thread::sleep_until(begin + kProbeEvery);
  }
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
#include "server/app/runtime/metrics.h"

#include <exception>
#include <map>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/mutex.h"
#include "prometheus/counter.h"
#include "prometheus/exposer.h"
#include "prometheus/gauge.h"
#include "prometheus/histogram.h"
#include "prometheus/registry.h"

namespace enfilade::server {
namespace {

const prometheus::Histogram::BucketBoundaries kLatencyBuckets = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                                                 0.1,    0.25,  0.5,    1.0,   2.5,  5.0,   10.0};

}  // namespace

class Metrics::Impl {
 public:
  using Counters = prometheus::Family<prometheus::Counter>;
  using Gauges = prometheus::Family<prometheus::Gauge>;

  Counters& Counter(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(*registry);
  }
  prometheus::Gauge& Gauge(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(*registry).Add({});
  }

  // The time series of one RPC and outcome. Kept, because finding them by label takes several microseconds.
  struct CallSeries {
    prometheus::Counter* calls;
    prometheus::Histogram* seconds;
  };
  CallSeries SeriesOf(const char* name, absl::StatusCode code) {
    const MutexLock lock(mutex);
    const auto [found, is_new] = call_series.try_emplace({name, code});
    if (is_new) {
      found->second = {&calls.Add({{"rpc", name}, {"code", absl::StatusCodeToString(code)}}),
                       &call_seconds.Add({{"rpc", name}}, kLatencyBuckets)};
    }
    return found->second;
  }

  std::shared_ptr<prometheus::Registry> registry = std::make_shared<prometheus::Registry>();
  Counters& calls = Counter("enfilade_calls_total", "RPCs by name and status code");
  prometheus::Family<prometheus::Histogram>& call_seconds =
      prometheus::BuildHistogram().Name("enfilade_call_seconds").Help("RPC latency").Register(*registry);
  prometheus::Counter& records = Counter("enfilade_records_stored_total", "Records stored").Add({});
  prometheus::Counter& duplicates = Counter("enfilade_records_duplicate_total", "Records sent again").Add({});
  prometheus::Counter& refused = Counter("enfilade_batches_refused_total", "Batches refused").Add({});
  prometheus::Gauge& buffered = Gauge("enfilade_ingest_buffered_bytes", "Received and not yet stored");
  prometheus::Family<prometheus::Gauge>& uploads = prometheus::BuildGauge()
                                                       .Name("enfilade_uploads_held_bytes")
                                                       .Help("What uploads under way hold")
                                                       .Register(*registry);
  prometheus::Gauge& uploads_memory = uploads.Add({{"in", "memory"}});
  prometheus::Gauge& uploads_disk = uploads.Add({{"in", "disk"}});
  prometheus::Gauge& streams = Gauge("enfilade_streams_open", "Open record streams");
  Counters& scans = Counter("enfilade_scans_mapped_total", "Scans by whether they were used in the trajectory");
  prometheus::Counter& scans_used = scans.Add({{"used", "true"}});
  prometheus::Counter& scans_not_used = scans.Add({{"used", "false"}});
  prometheus::Gauge& mapping = Gauge("enfilade_sessions_mapping", "Sessions being mapped by this process");
  prometheus::Gauge& mapping_waiting =
      Gauge("enfilade_mapping_waiting_sessions", "Sessions with records to map, of all processes");
  prometheus::Gauge& mapping_lag =
      Gauge("enfilade_mapping_lag_seconds", "How long the oldest record that is not mapped has waited, at most");
  prometheus::Gauge& without_map =
      Gauge("enfilade_sessions_without_map", "Sessions that wait for the verdict on the door that they came through");
  prometheus::Gauge& door_lag =
      Gauge("enfilade_door_lag_seconds", "How long the longest of them has waited since the session before it ended");
  Counters& rows_deleted =
      Counter("enfilade_rows_deleted_total", "Rows deleted in the background, by what they were of");
  Counters& sessions_closed =
      Counter("enfilade_idle_sessions_closed_total", "Sessions that nobody had finished, by what they were closed as");
  prometheus::Counter& sessions_finished = sessions_closed.Add({{"as", "finished"}});
  prometheus::Counter& sessions_failed = sessions_closed.Add({{"as", "failed"}});
  prometheus::Gauge& sites_deleting = Gauge("enfilade_sites_deleting", "Sites that are being deleted");
  prometheus::Gauge& watchers = Gauge("enfilade_watchers", "Open watches of poses and sites");
  prometheus::Counter& pyramids =
      Counter("enfilade_raster_pyramids_made_total", "Revisions whose tiles were made for viewers").Add({});
  prometheus::Gauge& certificate_end =
      Gauge("enfilade_tls_certificate_end_seconds", "When the own TLS certificate ends, s since 1970; 0 without TLS");
  prometheus::Counter& tls_failures =
      Counter("enfilade_tls_reload_failures_total", "Changed TLS files that are not used, because they are wrong")
          .Add({});
  prometheus::Gauge& ready = Gauge("enfilade_ready", "1 if the server accepts work");
  prometheus::Gauge& connections_open = Gauge("enfilade_database_connections_open", "Connections of the pool");
  prometheus::Gauge& connections_busy = Gauge("enfilade_database_connections_busy", "Connections in use");
  prometheus::Gauge& connections_waiting =
      Gauge("enfilade_database_connections_waiting", "Callers waiting for a connection");
  Mutex mutex;
  std::map<std::pair<std::string_view, absl::StatusCode>, CallSeries> call_series ABSL_GUARDED_BY(mutex);
  std::unique_ptr<prometheus::Exposer> exposer;
};

Metrics::Metrics(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Metrics::~Metrics() = default;

absl::StatusOr<std::unique_ptr<Metrics>> Metrics::Create(const std::string& address) {
  auto impl = std::make_unique<Impl>();
  if (!address.empty()) {
    try {
      impl->exposer = std::make_unique<prometheus::Exposer>(address, 1);
      impl->exposer->RegisterCollectable(impl->registry);
    } catch (const std::exception& error) {
      return Unavailable("cannot serve metrics at {} ({}): choose another metrics.address, or \"\" to disable them",
                         address, error.what());
    }
  }
  return std::unique_ptr<Metrics>(new Metrics(std::move(impl)));
}

void Metrics::CountCall(const char* name, absl::StatusCode code, std::chrono::steady_clock::duration took) {
  const Impl::CallSeries series = impl_->SeriesOf(name, code);
  series.calls->Increment();
  series.seconds->Observe(std::chrono::duration<double>(took).count());
}
void Metrics::CountRecordsStored(std::int64_t inserted, std::int64_t duplicates) {
  impl_->records.Increment(static_cast<double>(inserted));
  impl_->duplicates.Increment(static_cast<double>(duplicates));
}
void Metrics::CountBatchRefused() { impl_->refused.Increment(); }
void Metrics::AddIngestBuffered(std::int64_t bytes) { impl_->buffered.Increment(static_cast<double>(bytes)); }
void Metrics::SetUploadsHeld(std::int64_t memory_bytes, std::int64_t disk_bytes) {
  impl_->uploads_memory.Set(static_cast<double>(memory_bytes));
  impl_->uploads_disk.Set(static_cast<double>(disk_bytes));
}
void Metrics::AddStreamsOpen(int streams) { impl_->streams.Increment(streams); }
void Metrics::CountScansMapped(std::int64_t used, std::int64_t not_used) {
  impl_->scans_used.Increment(static_cast<double>(used));
  impl_->scans_not_used.Increment(static_cast<double>(not_used));
}
void Metrics::AddSessionsMapping(int sessions) { impl_->mapping.Increment(sessions); }
void Metrics::SetMappingBacklog(const storage::MappingBacklog& backlog) {
  impl_->mapping_waiting.Set(static_cast<double>(backlog.sessions));
  impl_->mapping_lag.Set(backlog.oldest_s);
  impl_->without_map.Set(static_cast<double>(backlog.without_map));
  impl_->door_lag.Set(backlog.longest_without_map_s);
}
void Metrics::CountRowsDeleted(const std::string& of, std::int64_t rows) {
  impl_->rows_deleted.Add({{"of", of}}).Increment(static_cast<double>(rows));
}
void Metrics::CountIdleSessionsClosed(std::int64_t finished, std::int64_t failed) {
  impl_->sessions_finished.Increment(static_cast<double>(finished));
  impl_->sessions_failed.Increment(static_cast<double>(failed));
}
void Metrics::SetSitesDeleting(int sites) { impl_->sites_deleting.Set(sites); }
void Metrics::SetWatchers(int watchers) { impl_->watchers.Set(watchers); }
void Metrics::CountRasterPyramidMade() { impl_->pyramids.Increment(); }
void Metrics::SetCertificateEnd(std::chrono::system_clock::time_point end) {
  impl_->certificate_end.Set(std::chrono::duration<double>(end.time_since_epoch()).count());
}
void Metrics::CountTlsReloadFailure() { impl_->tls_failures.Increment(); }
void Metrics::SetReady(bool ready) { impl_->ready.Set(ready ? 1.0 : 0.0); }
void Metrics::SetDatabaseConnections(int open, int busy, int waiting) {
  impl_->connections_open.Set(open);
  impl_->connections_busy.Set(busy);
  impl_->connections_waiting.Set(waiting);
}
int Metrics::streams_open() const { return static_cast<int>(impl_->streams.Value()); }
int Metrics::sessions_mapping() const { return static_cast<int>(impl_->mapping.Value()); }

}  // namespace enfilade::server

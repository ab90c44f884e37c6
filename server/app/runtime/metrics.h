// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "storage/sessions/mapping_store.h"

namespace enfilade::server {

// The server's metrics, in Prometheus' format. Thread-safe.
class Metrics {
 public:
  // Serves http://`address`/metrics; with an empty address metrics are only collected. UNAVAILABLE if the port is
  // taken.
  static absl::StatusOr<std::unique_ptr<Metrics>> Create(const std::string& address);
  ~Metrics();

  // `name` must outlive the metrics.
  void CountCall(const char* name, absl::StatusCode code, std::chrono::steady_clock::duration took);
  void CountRecordsStored(std::int64_t inserted, std::int64_t duplicates);
  void CountBatchRefused();
  void AddIngestBuffered(std::int64_t bytes);  // negative when written
  // What uploads under way hold.
  void SetUploadsHeld(std::int64_t memory_bytes, std::int64_t disk_bytes);
  void AddStreamsOpen(int streams);
  void CountScansMapped(std::int64_t used, std::int64_t not_used);
  void AddSessionsMapping(int sessions);
  // Of all processes: how many sessions wait to be mapped, and for how long the oldest unmapped record has waited.
  void SetMappingBacklog(const storage::MappingBacklog& backlog);
  // Rows that retention and deletion in the background have deleted, by what they belonged to.
  void CountRowsDeleted(const std::string& of, std::int64_t rows);
  // Sessions that nobody had finished.
  void CountIdleSessionsClosed(std::int64_t finished, std::int64_t failed);
  void SetSitesDeleting(int sites);
  // Open watches of poses and sites.
  void SetWatchers(int watchers);
  // For somebody who looked at a revision first.
  void CountRasterPyramidMade();
  // Of the server's own TLS certificate.
  void SetCertificateEnd(std::chrono::system_clock::time_point end);
  // TLS files that have changed and are not used, because something is wrong with them.
  void CountTlsReloadFailure();
  void SetReady(bool ready);
  void SetDatabaseConnections(int open, int busy, int waiting);

  int streams_open() const;
  int sessions_mapping() const;

 private:
  class Impl;
  explicit Metrics(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::server

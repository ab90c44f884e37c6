// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/support/recorded_scans.h"

#include <optional>
#include <utility>

#include "client/sources/log_reader.h"

namespace enfilade::bench {

absl::StatusOr<std::vector<sensor::PairedScan>> ReadPairedScans(const std::string& path, bool odometry) {
  sources::LogOptions options;
  options.odometry = odometry;
  absl::StatusOr<sources::LogReader> reader = sources::LogReader::Open(path, options);
  if (!reader.ok()) return reader.status();
  sensor::ScanPairing pairing{sensor::ScanPairingOptions{}};
  std::vector<sensor::PairedScan> scans;
  for (std::int64_t sequence = 1;; ++sequence) {
    absl::StatusOr<std::optional<sources::LogEntry>> entry = reader->Next();
    if (!entry.ok()) return entry.status();
    if (!*entry) break;
    pairing.Add(sequence, std::move((*entry)->payload), scans);
  }
  pairing.Flush(scans);
  return scans;
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
#include "client/cli/log_mapping.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "client/cli/output.h"
#include "core/base/status_macros.h"

namespace enfilade::cli {

using Clock = std::chrono::steady_clock;

absl::StatusOr<Clock::duration> MapToEnd(const Globals& globals, sources::LogReader& reader, slam::LogMapper& mapper) {
  ProgressBar bar(globals, "mapping", reader.facts().scans);
  Clock::duration spent{};
  for (std::int64_t sequence = 1;; ++sequence) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<sources::LogEntry> entry, reader.Next());
    if (!entry) break;
    const Clock::time_point begin = Clock::now();
    mapper.Add(sensor::Record{sequence, std::move(entry->payload)});
    spent += Clock::now() - begin;
    bar.Update(reader.counts().scans);
  }
  const Clock::time_point begin = Clock::now();
  mapper.Finish();
  bar.Finish();
  return spent + (Clock::now() - begin);
}

absl::StatusOr<std::vector<sensor::PairedScan>> ReadScans(sources::LogReader& reader) {
  sensor::ScanPairing pairing{sensor::ScanPairingOptions{}};
  std::vector<sensor::PairedScan> scans;
  for (std::int64_t sequence = 1;; ++sequence) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<sources::LogEntry> entry, reader.Next());
    if (!entry) break;
    pairing.Add(sequence, std::move(entry->payload), scans);
  }
  pairing.Flush(scans);
  return scans;
}

}  // namespace enfilade::cli

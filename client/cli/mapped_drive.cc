// SPDX-License-Identifier: Apache-2.0
#include "client/cli/mapped_drive.h"

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "client/cli/log_mapping.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/sensor/laser_scan.h"
#include "core/slam/mapper/log_mapper.h"

namespace enfilade::cli {
namespace {

// The scans are read once more: the map has them no longer.
absl::Status AddLooks(const slam::SlamMap& map, const slam::SlamOptions& options, sources::LogReader reader,
                      prior::MappedDrive& drive) {
  std::map<std::int64_t, const slam::SlamNode*> by_sequence;
  for (const auto& [id, node] : map.nodes) by_sequence[node.sequence] = &node;
  for (std::int64_t sequence = 1;; ++sequence) {
    ENFILADE_ASSIGN_OR_RETURN(const std::optional<sources::LogEntry> entry, reader.Next());
    if (!entry) return absl::OkStatus();
    const auto found = by_sequence.find(sequence);
    const auto* scan = std::get_if<sensor::LaserScan>(&entry->payload);
    if (found == by_sequence.end() || scan == nullptr) continue;
    prior::AddLook(*found->second, *scan, options, drive);
  }
}

}  // namespace

absl::StatusOr<prior::MappedDrive> MapDrive(const Globals& globals, const std::string& log,
                                            const sources::LogOptions& reading) {
  const slam::SlamOptions options;
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(log, reading));
  slam::LogMapper mapper(sensor::ScanPairingOptions{}, options);
  ENFILADE_RETURN_IF_ERROR(MapToEnd(globals, reader, mapper).status());
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  if (map.nodes.empty()) return InvalidArgument("{}: no scan of it could be mapped", log);
  prior::MappedDrive drive;
  ENFILADE_ASSIGN_OR_RETURN(drive.submaps, prior::SubmapsOf(map, options));
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader again, sources::LogReader::Open(log, reading));
  ENFILADE_RETURN_IF_ERROR(AddLooks(map, options, std::move(again), drive));
  return drive;
}

}  // namespace enfilade::cli

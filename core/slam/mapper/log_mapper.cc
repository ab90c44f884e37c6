// SPDX-License-Identifier: Apache-2.0
#include "core/slam/mapper/log_mapper.h"

#include <utility>

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/state/checkpoint.h"

namespace enfilade::slam {
namespace {

constexpr std::uint8_t kLogMapperVersion = 1;

// Of a checkpoint.
struct Parts {
  LogMapperCounts counts;
  std::string_view pairing;
  std::string_view mapper;
};

absl::StatusOr<Parts> Divide(std::string_view checkpoint) {
  BinaryReader reader(checkpoint);
  if (reader.Get<std::uint8_t>() != kLogMapperVersion) {
    return DataLoss("the checkpoint has a version that this program does not know");
  }
  Parts parts;
  parts.counts.used = reader.Get<std::int64_t>();
  parts.counts.keyframes = reader.Get<std::int64_t>();
  parts.counts.lost = reader.Get<std::int64_t>();
  parts.pairing = reader.GetString();
  parts.mapper = reader.GetString();
  if (!reader.at_end()) return DataLoss("the checkpoint is truncated or has trailing bytes");
  return parts;
}

}  // namespace

void LogMapper::Add(sensor::Record record) {
  pairing_.Add(record.sequence, std::move(record.payload), settled_);
  MapSettled();
}

void LogMapper::Finish() {
  pairing_.Flush(settled_);
  MapSettled();
  mapper_.Finish();
}

void LogMapper::MapSettled() {
  for (const sensor::PairedScan& scan : settled_) {
    const ScanReport report = mapper_.AddScan(scan);
    counts_.used += report.used;
    counts_.keyframes += report.keyframe;
    counts_.lost += report.lost;
  }
  settled_.clear();
}

LogMapperCounts LogMapper::counts() const {
  LogMapperCounts counts = counts_;
  counts.pairing = pairing_.counts();
  return counts;
}

std::string LogMapper::Checkpoint() const {
  std::string bytes;
  BinaryWriter writer(bytes);
  writer.Put(kLogMapperVersion);
  writer.Put(counts_.used);
  writer.Put(counts_.keyframes);
  writer.Put(counts_.lost);
  writer.PutString(pairing_.Serialize());
  writer.PutString(mapper_.Checkpoint());
  return bytes;
}

absl::StatusOr<LogMapper> LogMapper::Restore(const sensor::ScanPairingOptions& pairing_options,
                                             const SlamOptions& slam_options, const SlamMap& stored,
                                             std::string_view checkpoint) {
  ENFILADE_ASSIGN_OR_RETURN(const Parts parts, Divide(checkpoint));
  ENFILADE_ASSIGN_OR_RETURN(sensor::ScanPairing pairing, sensor::ScanPairing::Restore(pairing_options, parts.pairing));
  ENFILADE_ASSIGN_OR_RETURN(Mapper mapper, Mapper::Restore(slam_options, stored, parts.mapper));
  LogMapper log_mapper(std::move(pairing), std::move(mapper));
  log_mapper.counts_ = parts.counts;
  return log_mapper;
}

absl::StatusOr<ErrorStatistics> LogMapper::ErrorsAt(std::string_view checkpoint) {
  ENFILADE_ASSIGN_OR_RETURN(const Parts parts, Divide(checkpoint));
  return DecodeErrors(parts.mapper);
}

}  // namespace enfilade::slam

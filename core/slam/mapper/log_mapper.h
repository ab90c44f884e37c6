// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "core/sensor/record.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/state/variance_factor.h"

namespace enfilade::slam {

struct LogMapperCounts {
  sensor::ScanPairingCounts pairing;
  std::int64_t used = 0;       // scans that are in the trajectory
  std::int64_t keyframes = 0;  // scans that became keyframes
  std::int64_t lost = 0;       // scans at which the robot was lost
};

// Makes a map from a session's log: pairs scans with odometry by time and feeds them to the mapper. The server and the
// offline tool both use it, so both give the same result. Deterministic like the mapper, also across Checkpoint and
// Restore at any record.
class LogMapper {
 public:
  LogMapper(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam) : pairing_(pairing), mapper_(slam) {}
  // Continues an existing map.
  LogMapper(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam, const ExistingMap& existing_map)
      : pairing_(pairing), mapper_(slam, existing_map) {}

  // `stored`: the sum of the deltas up to the checkpoint. DATA_LOSS if they do not belong together.
  static absl::StatusOr<LogMapper> Restore(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam,
                                           const SlamMap& stored, std::string_view checkpoint);

  // What a mapper knew of its errors at a checkpoint. DATA_LOSS if it is damaged.
  static absl::StatusOr<ErrorStatistics> ErrorsAt(std::string_view checkpoint);

  // In the order of the log. Images, clouds and withheld records are ignored.
  void Add(sensor::Record record);
  // The log is complete: maps the scans that still wait for odometry and finishes the map.
  void Finish();

  SlamDelta TakeDelta() { return mapper_.TakeDelta(); }
  std::string Checkpoint() const;
  grid::OccupancyGrid RenderGrid() const { return mapper_.RenderGrid(); }
  grid::OccupancyGrid RenderGrid(MapRenderer& renderer) const { return mapper_.RenderGrid(renderer); }
  std::optional<PresentPose> FindPresentPose() const { return mapper_.FindPresentPose(); }
  double variance_factor() const { return mapper_.variance_factor(); }
  Footprint footprint() const { return mapper_.footprint(); }
  LogMapperCounts counts() const;

 private:
  LogMapper(sensor::ScanPairing pairing, Mapper mapper) : pairing_(std::move(pairing)), mapper_(std::move(mapper)) {}
  void MapSettled();

  sensor::ScanPairing pairing_;
  Mapper mapper_;
  LogMapperCounts counts_;                   // without the pairing's
  std::vector<sensor::PairedScan> settled_;  // empty between calls
};

}  // namespace enfilade::slam

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

namespace enfilade::slam {

struct LogMapperCounts {
  sensor::ScanPairingCounts pairing;
  std::int64_t used = 0;       // scans with a place in the trajectory
  std::int64_t keyframes = 0;  // among them
  std::int64_t lost = 0;       // scans at which the robot was lost
};

// A session's log in, a map out: pairs the records by time and gives the scans to the mapper. The one way from a log to
// a map, taken by the server and by the offline tool alike, so that both give the same result. Pure, like the mapper:
// also across Checkpoint and Restore anywhere.
class LogMapper {
 public:
  LogMapper(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam) : pairing_(pairing), mapper_(slam) {}
  // Goes on in a map that is there already.
  LogMapper(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam, const ExistingMap& existing_map)
      : pairing_(pairing), mapper_(slam, existing_map) {}

  // `stored` is the sum of the deltas up to the checkpoint. DATA_LOSS where they do not fit.
  static absl::StatusOr<LogMapper> Restore(const sensor::ScanPairingOptions& pairing, const SlamOptions& slam,
                                           const SlamMap& stored, std::string_view checkpoint);

  // In the order of the log. Images, clouds and withheld records pass by.
  void Add(sensor::Record record);
  // The log is complete: settles what waits and finishes the map.
  void Finish();

  SlamDelta TakeDelta() { return mapper_.TakeDelta(); }
  std::string Checkpoint() const;
  grid::OccupancyGrid RenderGrid() const { return mapper_.RenderGrid(); }
  std::optional<PresentPose> FindPresentPose() const { return mapper_.FindPresentPose(); }
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

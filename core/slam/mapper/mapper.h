// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/existing_map.h"
#include "core/slam/mapper/present_pose.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"

namespace enfilade::slam {

// What became of one scan.
struct ScanReport {
  bool used = false;  // it has a place in the trajectory
  bool keyframe = false;
  bool lost = false;           // the last good match is too long ago, or too little of the scan fits the map
  double matched_share = 0.0;  // of the scan's hits, 0..1
  double match_age = 0.0;      // s since the last scan that matched well: 0 where this one did
  std::string reason;          // why it was not used
};

// Bytes of memory that a mapper holds, by what they grow with. What a call needs for its own time is not in here.
struct Footprint {
  std::size_t working = 0;  // the active submap and loop closing's cache: bounded by the options
  std::size_t kept = 0;     // finished submaps, keyframes, closures: grows with the way driven
  std::size_t raster = 0;   // what RenderGrid keeps: grows with the area seen; nothing before its first call

  std::size_t total() const { return working + kept + raster; }
};

// Makes one map out of one session's scans. The seam between the algorithm and its callers (the server's mapping
// worker, the tool): they own the log, time, storage and leases; the mapper is pure. The same scans in the same order
// with the same options give the same result, bit for bit, also when Checkpoint and Restore happen anywhere between.
//
// Not thread-safe: one mapper belongs to one worker. Movable.
class Mapper {
 public:
  explicit Mapper(const SlamOptions& options);
  // Goes on in a map that is there already, in its frame. Submap 0 is the old map, as rows are, and never moves; where
  // the robot is in it is first the entry's word, then what the scans say: keyframes are looked for in it from the
  // first on, within three standard deviations of the entry until they are found. Where they are not, the closures'
  // rows say why, and the entry alone holds the new to the old.
  Mapper(const SlamOptions& options, const ExistingMap& existing_map);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  // Goes on from `checkpoint`, taken just after the delta that made `stored` what it is. DATA_LOSS where the two do
  // not fit together or the bytes are not a checkpoint's.
  static absl::StatusOr<Mapper> Restore(const SlamOptions& options, const SlamMap& stored, std::string_view checkpoint);

  // A scan that cannot be used is no error: the report says so.
  ScanReport AddScan(const sensor::PairedScan& scan);

  // No more scans will come: the last submap is finished and the graph solved. Again, after closures were suspended or
  // resumed in the stored rows: the graph is solved anew.
  void Finish();

  // Takes a closure out of the graph, or lets the graph judge it again, and solves. Also after Finish. NOT_FOUND; or
  // FAILED_PRECONDITION where it is to be taken up but never matched.
  absl::Status SetLoopClosureSuspended(std::int64_t id, bool suspended);

  // What has changed since the last call, to be stored by the caller; empties the account.
  SlamDelta TakeDelta();

  // The state needed to go on, together with the stored rows; finished submaps are in the rows, not in here.
  std::string Checkpoint() const;

  Footprint footprint() const;

  // The map by the present estimate: what the scans have shown, without the old map that they were laid in.
  grid::OccupancyGrid RenderGrid() const;
  // Where the robot was at the last used scan; unset before the first.
  std::optional<PresentPose> FindPresentPose() const;

 private:
  class Impl;
  explicit Mapper(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::slam

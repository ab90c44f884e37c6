// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "core/grid/occupancy_grid.h"
#include "core/sensor/scan_pairing.h"
#include "core/slam/mapper/map_renderer.h"
#include "core/slam/mapper/present_pose.h"
#include "core/slam/slam_map.h"
#include "core/slam/slam_options.h"
#include "core/slam/state/existing_map.h"

namespace enfilade::slam {

// What happened to one scan.
struct ScanReport {
  bool used = false;  // it is in the trajectory
  bool keyframe = false;
  bool lost = false;           // no good match for too many scans, or not yet recognised after being lost
  double matched_share = 0.0;  // share of the scan's hits, 0..1
  double match_age = 0.0;      // s since the last scan that matched well; 0 if this one did
  std::string reason;          // why it was not used
};

// Bytes of memory that a mapper holds between calls, by what they grow with.
struct Footprint {
  std::size_t working = 0;  // the active submap and loop closing's cache: bounded by the options
  std::size_t kept = 0;     // finished submaps, keyframes, loop closures: grows with the distance driven
  std::size_t raster = 0;   // what RenderGrid keeps: grows with the area seen; 0 before its first call

  std::size_t total() const { return working + kept + raster; }
};

// Makes one map from one session's scans. The callers (the server's mapping worker, the tool) own the log, time,
// storage and leases; the mapper is pure. The same scans in the same order with the same options give the same result,
// bit for bit, also with Checkpoint and Restore anywhere in between.
//
// Not thread-safe: one mapper belongs to one worker. Movable.
class Mapper {
 public:
  explicit Mapper(const SlamOptions& options);
  // Continues an existing map, in its frame. The existing map becomes submap 0, also in the rows, and never moves. The
  // robot starts at the entry's pose. From the first keyframe on, loop closing looks for it in submap 0, within three
  // standard deviations of the entry until it is found. If it is not found, the rows of the loop closures say why, and
  // only the entry ties the new submaps to the existing map.
  Mapper(const SlamOptions& options, const ExistingMap& existing_map);
  ~Mapper();
  Mapper(Mapper&&) noexcept;
  Mapper& operator=(Mapper&&) noexcept;

  // Continues from `checkpoint`, taken right after the last delta in `stored`. DATA_LOSS if they do not belong together
  // or the checkpoint is damaged.
  static absl::StatusOr<Mapper> Restore(const SlamOptions& options, const SlamMap& stored, std::string_view checkpoint);

  // A scan that cannot be used is not an error: the report says why.
  ScanReport AddScan(const sensor::PairedScan& scan);

  // There are no more scans: finishes the last submap and solves the graph. Called again, it solves the graph again: to
  // suspend or resume loop closures of a finished map, change their state in the stored rows, Restore and Finish.
  void Finish();

  // The rows that have changed since the last call, to be stored by the caller.
  SlamDelta TakeDelta();

  // What is needed to continue, together with the stored rows (which hold the finished submaps).
  std::string Checkpoint() const;

  Footprint footprint() const;

  // By how much errors are smaller (below 1) or larger than the options state (state/variance_factor.h). The map's
  // covariances contain it.
  double variance_factor() const;

  // The map by the current estimate: what the scans have shown, without the existing map.
  grid::OccupancyGrid RenderGrid() const;
  // The same by a renderer that has drawn earlier states of this map, also those before Restore: faster.
  grid::OccupancyGrid RenderGrid(MapRenderer& renderer) const;
  // Where the robot was at the last used scan; unset before the first.
  std::optional<PresentPose> FindPresentPose() const;

 private:
  class Impl;
  explicit Mapper(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::slam

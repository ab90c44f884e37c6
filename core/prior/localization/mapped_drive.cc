// SPDX-License-Identifier: Apache-2.0
#include "core/prior/localization/mapped_drive.h"

#include <cstddef>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::prior {

absl::StatusOr<std::vector<DriveSubmap>> SubmapsOf(const slam::SlamMap& map, const slam::SlamOptions& options) {
  std::vector<DriveSubmap> submaps;
  for (const auto& [id, row] : map.submaps) {
    if (row.content.empty()) continue;
    ENFILADE_ASSIGN_OR_RETURN(const slam::SubmapContent content,
                              slam::DecodeSubmapContent(row.content, options.occupancy));
    submaps.push_back({id, row.T_map_submap, content.grid.OccupiedPoints()});
  }
  return submaps;
}

void AddLook(const slam::SlamNode& node, const sensor::LaserScan& scan, const slam::SlamOptions& options,
             MappedDrive& drive) {
  drive.times.push_back(node.time);
  drive.looks.push_back({{node.T_map_node, sensor::HitPoints(scan, options.max_range)}, node.submap});
}

absl::StatusOr<MappedScans> MapScans(const std::vector<sensor::PairedScan>& scans, const slam::SlamOptions& options,
                                     const KeepGoing& keep_going) {
  slam::Mapper mapper(options);
  for (const sensor::PairedScan& scan : scans) {
    ENFILADE_RETURN_IF_ERROR(keep_going());
    mapper.AddScan(scan);
  }
  mapper.Finish();
  slam::SlamMap map;
  map.Apply(mapper.TakeDelta());
  const auto present = mapper.FindPresentPose();
  if (map.nodes.empty() || !present) return InvalidArgument("none of the {} scans could be mapped", scans.size());
  MappedScans mapped{{}, present->T_map_robot.pose};
  for (const auto& [id, node] : map.nodes) {
    AddLook(node, scans.at(static_cast<std::size_t>(node.sequence) - 1).scan, options, mapped.drive);
  }
  ENFILADE_ASSIGN_OR_RETURN(mapped.drive.submaps, SubmapsOf(map, options));
  return mapped;
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/growing_drive.h"

#include <algorithm>
#include <utility>

#include "core/base/status_macros.h"
#include "core/slam/mapper/log_mapper.h"

namespace enfilade::server {
namespace {

slam::LogMapper MakeMapper(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
                           const std::optional<slam::ExistingMap>& existing) {
  return existing ? slam::LogMapper(pairing, slam, *existing) : slam::LogMapper(pairing, slam);
}

}  // namespace

GrowingDrive::GrowingDrive(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
                           const std::optional<slam::ExistingMap>& existing)
    : pairing_(pairing), slam_(slam) {
  slam::LogMapper mapper = MakeMapper(pairing, slam, existing);
  stored_.Apply(mapper.TakeDelta());
  checkpoint_ = mapper.Checkpoint();
}

absl::StatusOr<MappedDrive> GrowingDrive::Extend(const Feed& feed) {
  ENFILADE_ASSIGN_OR_RETURN(slam::LogMapper mapper, slam::LogMapper::Restore(pairing_, slam_, stored_, checkpoint_));
  ENFILADE_RETURN_IF_ERROR(feed([&](sensor::Record record) { mapper.Add(std::move(record)); }));
  stored_.Apply(mapper.TakeDelta());
  checkpoint_ = mapper.Checkpoint();
  mapper.Finish();
  slam::SlamMap finished = stored_;
  finished.Apply(mapper.TakeDelta());
  MappedDrive mapped{mapper.RenderGrid(), slam::TrajectoryOf(finished), mapper.variance_factor()};
  std::sort(mapped.trajectory.begin(), mapped.trajectory.end(),
            [](const slam::StampedPose& a, const slam::StampedPose& b) { return a.time < b.time; });
  return mapped;
}

std::size_t GrowingDrive::bytes() const {
  std::size_t bytes = sizeof(*this) + checkpoint_.size() + stored_.nodes.size() * sizeof(slam::SlamNode) +
                      stored_.trajectory.size() * sizeof(slam::TrajectoryPoint);
  for (const auto& [id, submap] : stored_.submaps) bytes += sizeof(submap) + submap.content.size();
  return bytes;
}

}  // namespace enfilade::server

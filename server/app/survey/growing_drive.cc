// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/growing_drive.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "core/base/status_macros.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/submaps/submap_grid.h"

namespace enfilade::server {
namespace {

// Bytes. Larger pictures are drawn from the start each time.
constexpr std::size_t kMostTiles = 64U << 20U;

// Nearly all of a session's keyframes are to be keyframes of the drive, though their distances differ a little there.
slam::SlamOptions ForKeyframes(slam::SlamOptions slam) {
  constexpr double kNearly = 0.9;
  slam.keyframe.distance *= kNearly;
  slam.keyframe.angle *= kNearly;
  return slam;
}

bool IsScan(const sensor::Record& record) { return std::holds_alternative<sensor::LaserScan>(record.payload); }

// Adds the odometry of the records.
void AddWithoutScan(const std::vector<sensor::Record>& records, slam::LogMapper& mapper) {
  for (const sensor::Record& record : records) {
    if (!IsScan(record)) mapper.Add(record);
  }
}

slam::LogMapper MakeMapper(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
                           const std::optional<slam::ExistingMap>& existing) {
  return existing ? slam::LogMapper(pairing, slam, *existing) : slam::LogMapper(pairing, slam);
}

}  // namespace

GrowingDrive::GrowingDrive(const sensor::ScanPairingOptions& pairing, const slam::SlamOptions& slam,
                           const std::optional<slam::ExistingMap>& existing)
    : pairing_(pairing), slam_(ForKeyframes(slam)) {
  slam::LogMapper mapper = MakeMapper(pairing, slam_, existing);
  stored_.Apply(mapper.TakeDelta());
  checkpoint_ = mapper.Checkpoint();
}

absl::StatusOr<MappedDrive> GrowingDrive::Extend(const Feed& feed) {
  ENFILADE_ASSIGN_OR_RETURN(slam::LogMapper mapper, slam::LogMapper::Restore(pairing_, slam_, stored_, checkpoint_));
  std::vector<sensor::Record> tail = tail_;
  ENFILADE_RETURN_IF_ERROR(feed([&](sensor::Record record, bool is_keyframe) {
    if (IsScan(record)) {
      AddWithoutScan(std::exchange(tail, {}), mapper);
      if (!is_keyframe) return tail.push_back(std::move(record));
    } else if (!std::holds_alternative<sensor::Odometry>(record.payload)) {
      return;
    }
    if (!tail.empty()) return tail.push_back(std::move(record));
    mapper.Add(std::move(record));
  }));
  stored_.Apply(mapper.TakeDelta());
  checkpoint_ = mapper.Checkpoint();
  tail_ = tail;
  for (sensor::Record& record : tail) mapper.Add(std::move(record));
  mapper.Finish();
  slam::SlamMap finished = stored_;
  finished.Apply(mapper.TakeDelta());
  if (!renderer_) renderer_.emplace(slam_.resolution, slam::LogOddsOptionsOf(slam_.occupancy));
  MappedDrive mapped{mapper.RenderGrid(*renderer_), slam::TrajectoryOf(finished), mapper.variance_factor()};
  if (renderer_->bytes() > kMostTiles) renderer_.reset();
  std::sort(mapped.trajectory.begin(), mapped.trajectory.end(),
            [](const slam::StampedPose& a, const slam::StampedPose& b) { return a.time < b.time; });
  return mapped;
}

std::size_t GrowingDrive::bytes() const {
  std::size_t bytes = sizeof(*this) + checkpoint_.size() + stored_.nodes.size() * sizeof(slam::SlamNode) +
                      stored_.trajectory.size() * sizeof(slam::TrajectoryPoint) +
                      tail_.size() * sizeof(sensor::Record) + (renderer_ ? renderer_->bytes() : 0);
  for (const auto& [id, submap] : stored_.submaps) bytes += sizeof(submap) + submap.content.size();
  return bytes;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "server/app/survey/chained_sessions.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/slam/mapper/log_mapper.h"
#include "core/slam/mapper/mapper.h"
#include "core/slam/state/checkpoint.h"
#include "core/slam/submaps/submap.h"

namespace enfilade::server {
namespace {

// Nearly all of a session's keyframes are to be keyframes again, though their distances differ a little.
slam::SlamOptions ForKeyframes(slam::SlamOptions slam) {
  constexpr double kNearly = 0.9;
  slam.keyframe.distance *= kNearly;
  slam.keyframe.angle *= kNearly;
  return slam;
}

// Keyframes are numbered from 0 on, and keep their numbers when a session is cut.
bool IsRestOf(const slam::SlamMap& before, const slam::SlamMap& map) {
  return !before.nodes.empty() && !map.nodes.empty() && map.nodes.begin()->first == before.nodes.rbegin()->first + 1;
}

// The map frames of two pieces, which may lie in different maps by now.
absl::StatusOr<Pose2> RestInFrameOf(const slam::SlamMap& map, const slam::SlamMap& rest,
                                    const slam::OccupancyOptions& options) {
  const auto& [last_id, last] = *map.submaps.rbegin();
  const auto& [first_id, first] = *rest.submaps.begin();
  // Both have the submap that was cut.
  if (first_id == last_id) return last.T_map_submap * Inverse(first.T_map_submap);
  ENFILADE_ASSIGN_OR_RETURN(const slam::SubmapContent content, slam::DecodeSubmapContent(last.content, options));
  if (first_id != last_id + 1 || !content.next) {
    return FailedPrecondition("the submaps between {} and {} are missing", last_id, first_id);
  }
  return last.T_map_submap * content.next->T_submap_next * Inverse(first.T_map_submap);
}

absl::Status Add(slam::SlamMap rest, const slam::OccupancyOptions& options, slam::SlamMap& map) {
  ENFILADE_ASSIGN_OR_RETURN(const Pose2 T_map_rest, RestInFrameOf(map, rest, options));
  for (auto& [id, node] : rest.nodes) node.T_map_node = T_map_rest * node.T_map_node;
  for (auto& [id, submap] : rest.submaps) submap.T_map_submap = T_map_rest * submap.T_map_submap;
  map.nodes.merge(rest.nodes);
  map.submaps.merge(rest.submaps);
  map.loop_closures.merge(rest.loop_closures);
  map.trajectory.insert(map.trajectory.end(), rest.trajectory.begin(), rest.trajectory.end());
  return absl::OkStatus();
}

}  // namespace

absl::Status ChainedSessions::AppendNext(slam::SessionChain& chain) {
  ENFILADE_ASSIGN_OR_RETURN(Whole session, ReadNext());
  const std::set<std::int64_t> wanted = ScansOf(session.mapping.map);
  absl::Status status = FailedPrecondition("only a part of it is used");
  if (!IsInPart(session.mapping.map)) {
    slam::ChainedSession mapped;
    mapped.map = std::move(session.mapping.map);
    // What a rest of a cut knew is with the session's beginning.
    if (const auto errors = slam::LogMapper::ErrorsAt(session.mapping.checkpoint); errors.ok()) mapped.errors = *errors;
    ENFILADE_ASSIGN_OR_RETURN(mapped.scans, ReadScans(session.pieces, wanted));
    status = chain.Append(mapped);
  }
  if (absl::IsFailedPrecondition(status) || absl::IsDataLoss(status)) {
    ENFILADE_ASSIGN_OR_RETURN(const slam::ChainedSession again, MapAgain(session.pieces, wanted));
    status = chain.Append(again);
  }
  if (status.ok()) appended_ += session.pieces.size();
  return status;
}

absl::StatusOr<storage::StoredMapping> ChainedSessions::Load(const storage::Session& session) const {
  ENFILADE_ASSIGN_OR_RETURN(std::optional<storage::StoredMapping> stored, reader_.LoadMapping(session.id));
  if (!stored) return storage::StoredMapping{};
  // The map that it continued.
  if (session.entry.T_map_robot) stored->map.submaps.erase(0);
  return *std::move(stored);
}

absl::StatusOr<ChainedSessions::Whole> ChainedSessions::ReadNext() {
  Whole whole;
  for (std::size_t i = appended_; i < sessions_.size(); ++i) {
    if (!next_) {
      ENFILADE_ASSIGN_OR_RETURN(next_, Load(*sessions_[i]));
    }
    if (whole.pieces.empty()) {
      whole.mapping = *std::exchange(next_, std::nullopt);
    } else {
      // A rest whose way to the beginning is lost is like any session that follows.
      if (!IsRestOf(whole.mapping.map, next_->map) || !Add(next_->map, slam_.occupancy, whole.mapping.map).ok()) break;
      next_.reset();
    }
    whole.pieces.push_back(sessions_[i]);
  }
  return whole;
}

bool ChainedSessions::IsInPart(const slam::SlamMap& map) const {
  return (!map.nodes.empty() && IsAfter(map.nodes.rbegin()->second.time)) ||
         (!map.trajectory.empty() && IsAfter(map.trajectory.back().time));
}

std::set<std::int64_t> ChainedSessions::ScansOf(const slam::SlamMap& map) const {
  std::set<std::int64_t> sequences;
  for (const auto& [id, node] : map.nodes) {
    if (!IsAfter(node.time)) sequences.insert(node.sequence);
  }
  const auto last = std::find_if(map.trajectory.rbegin(), map.trajectory.rend(),
                                 [&](const slam::TrajectoryPoint& point) { return !IsAfter(point.time); });
  if (last != map.trajectory.rend()) sequences.insert(last->sequence);
  return sequences;
}

absl::StatusOr<std::vector<sensor::PairedScan>> ChainedSessions::ReadScans(const Pieces& pieces,
                                                                           const Wanted& wanted) const {
  sensor::ScanPairing pairing(pairing_);
  std::vector<sensor::PairedScan> scans;
  std::vector<sensor::PairedScan> settled;
  const auto take = [&] {
    for (sensor::PairedScan& scan : settled) {
      if (!wanted || wanted->contains(scan.sequence)) scans.push_back(std::move(scan));
    }
    settled.clear();
  };
  for (const storage::Session* piece : pieces) {
    ENFILADE_RETURN_IF_ERROR(reader_.ReadRecords(*piece, until_, [&](sensor::Record record) {
      pairing.Add(record.sequence, std::move(record.payload), settled);
      take();
      return absl::OkStatus();
    }));
  }
  pairing.Flush(settled);
  take();
  return scans;
}

absl::StatusOr<slam::ChainedSession> ChainedSessions::MapAgain(const Pieces& pieces,
                                                               const std::set<std::int64_t>& keyframes) const {
  // Without odometry nothing else bridges the way from keyframe to keyframe.
  const bool all = std::any_of(pieces.begin(), pieces.end(),
                               [](const storage::Session* piece) { return piece->record_counts.odometry == 0; });
  slam::ChainedSession again;
  ENFILADE_ASSIGN_OR_RETURN(again.scans, ReadScans(pieces, all ? Wanted() : Wanted(keyframes)));
  slam::Mapper mapper(ForKeyframes(slam_));
  for (const sensor::PairedScan& scan : again.scans) mapper.AddScan(scan);
  mapper.Finish();
  again.map.Apply(mapper.TakeDelta());
  ENFILADE_ASSIGN_OR_RETURN(again.errors, slam::DecodeErrors(mapper.Checkpoint()));
  return again;
}

}  // namespace enfilade::server

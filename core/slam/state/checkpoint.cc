// SPDX-License-Identifier: Apache-2.0
#include "core/slam/state/checkpoint.h"

#include <utility>

#include "core/base/binary.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/compression/compression.h"
#include "core/geometry/pose_codec.h"
#include "core/slam/submaps/robot_rays.h"

namespace enfilade::slam {
namespace {

constexpr std::uint8_t kVersionWithSeen = 6;  // only before the first scan: programs before it can read all others
constexpr std::uint8_t kCheckpointVersion = 5;
constexpr std::uint8_t kVersionWithoutErrors = 4;
constexpr std::uint8_t kVersionWithoutEntry = 3;
constexpr std::size_t kMaxCheckpointBytes = std::size_t{1} << 30;

void PutOptionalPose(BinaryWriter& writer, const std::optional<Pose2>& pose) {
  writer.Put<std::uint8_t>(pose.has_value());
  PutPose(writer, pose.value_or(Pose2{}));
}

void PutStep(BinaryWriter& writer, const std::optional<Step>& step) {
  writer.Put<std::uint8_t>(step.has_value());
  PutPose(writer, step.value_or(Step{}).T_from_to);
  writer.Put(step.value_or(Step{}).seconds);
}

std::optional<Step> GetStep(BinaryReader& reader) {
  const bool has_value = reader.Get<std::uint8_t>() != 0;
  Step step;
  step.T_from_to = GetPose(reader);
  step.seconds = reader.Get<double>();
  return has_value ? std::optional(step) : std::nullopt;
}

std::optional<Pose2> GetOptionalPose(BinaryReader& reader) {
  const bool has_value = reader.Get<std::uint8_t>() != 0;
  const Pose2 pose = GetPose(reader);
  return has_value ? std::optional(pose) : std::nullopt;
}

void PutErrors(BinaryWriter& writer, const ErrorStatistics& errors) {
  writer.Put(errors.match_squares);
  writer.Put(errors.matches);
  writer.Put(errors.graph_chi2);
  writer.Put(errors.redundancy);
}

ErrorStatistics GetErrors(BinaryReader& reader) {
  ErrorStatistics errors;
  errors.match_squares = reader.Get<double>();
  errors.matches = reader.Get<std::int64_t>();
  errors.graph_chi2 = reader.Get<double>();
  errors.redundancy = reader.Get<std::int64_t>();
  return errors;
}

void PutTrack(BinaryWriter& writer, const std::optional<Track>& track) {
  writer.Put<std::uint8_t>(track.has_value());
  if (!track) return;
  PutPose(writer, track->T_submap_robot);
  PutOptionalPose(writer, track->T_odom_robot);
  writer.Put(track->time);
  writer.Put(track->matched_at);
  PutStep(writer, track->last_step);
  writer.Put(track->length_since_keyframe);
  writer.Put(track->quality.poor);
  writer.Put(track->quality.contradicting);
}

std::optional<Track> GetTrack(BinaryReader& reader) {
  if (reader.Get<std::uint8_t>() == 0) return std::nullopt;
  Track track;
  track.T_submap_robot = GetPose(reader);
  track.T_odom_robot = GetOptionalPose(reader);
  track.time = reader.Get<TimeNs>();
  track.matched_at = reader.Get<TimeNs>();
  track.last_step = GetStep(reader);
  track.length_since_keyframe = reader.Get<double>();
  track.quality.poor = reader.Get<int>();
  track.quality.contradicting = reader.Get<int>();
  return track;
}

void PutActive(BinaryWriter& writer, const std::optional<Submap>& active) {
  writer.Put<std::uint8_t>(active.has_value());
  if (!active) return;
  writer.Put(active->id);
  writer.Put(active->version);
  Serialize(active->content, writer);
}

absl::Status GetActive(BinaryReader& reader, const SlamMap& stored, const OccupancyOptions& options,
                       std::optional<Submap>& active) {
  if (reader.Get<std::uint8_t>() == 0) return absl::OkStatus();
  const auto id = reader.Get<std::int64_t>();
  const auto version = reader.Get<std::int64_t>();
  ENFILADE_ASSIGN_OR_RETURN(SubmapContent content, DeserializeSubmapContent(reader, options));
  Submap submap{id, version, Pose2{}, std::move(content)};
  const auto row = stored.submaps.find(submap.id);
  if (row == stored.submaps.end() || row->second.finished || row->second.version != submap.version) {
    return DataLoss("the checkpoint continues submap {} version {}, which is not the stored one", submap.id,
                    submap.version);
  }
  submap.T_map_submap = row->second.T_map_submap;
  active = std::move(submap);
  return absl::OkStatus();
}

// What a checkpoint begins with.
struct Beginning {
  std::uint8_t version = 0;
  std::uint64_t nodes = 0;
  std::uint64_t finished = 0;
  std::uint64_t closures = 0;
  MapperState state;  // without what follows
};

absl::StatusOr<Beginning> GetBeginning(BinaryReader& reader) {
  Beginning beginning;
  beginning.version = reader.Get<std::uint8_t>();
  if (beginning.version < kVersionWithoutEntry || beginning.version > kVersionWithSeen) {
    return DataLoss("the checkpoint has version {}, which this program does not know", beginning.version);
  }
  beginning.nodes = reader.Get<std::uint64_t>();
  beginning.finished = reader.Get<std::uint64_t>();
  beginning.closures = reader.Get<std::uint64_t>();
  MapperState& state = beginning.state;
  state.ended = reader.Get<std::uint8_t>() != 0;
  state.nodes_at_solve = reader.Get<std::int64_t>();
  state.unsolved_closures = reader.Get<std::uint8_t>() != 0;
  state.urgent_closures = reader.Get<std::uint8_t>() != 0;
  if (const auto since = reader.Get<std::int64_t>(); since >= 0) state.adrift_since = since;
  if (beginning.version > kVersionWithoutErrors) state.errors = GetErrors(reader);
  return beginning;
}

}  // namespace

std::string EncodeCheckpoint(const MapperState& state) {
  std::string bytes;
  BinaryWriter writer(bytes);
  const bool has_seen = state.entry && state.entry->seen;
  writer.Put(has_seen ? kVersionWithSeen : kCheckpointVersion);
  writer.Put<std::uint64_t>(state.nodes.size());
  writer.Put<std::uint64_t>(state.finished.size());
  writer.Put<std::uint64_t>(state.loop_closures.size());
  writer.Put<std::uint8_t>(state.ended);
  writer.Put(state.nodes_at_solve);
  writer.Put<std::uint8_t>(state.unsolved_closures);
  writer.Put<std::uint8_t>(state.urgent_closures);
  writer.Put<std::int64_t>(state.adrift_since.value_or(-1));
  PutErrors(writer, state.errors);
  PutEntry(writer, state.entry);
  if (has_seen) PutRays(writer, *state.entry->seen);
  PutTrack(writer, state.track);
  PutActive(writer, state.active);
  return Compress(bytes);
}

absl::StatusOr<MapperState> DecodeCheckpoint(std::string_view checkpoint, const SlamMap& stored,
                                             const OccupancyOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, Decompress(checkpoint, kMaxCheckpointBytes));
  BinaryReader reader(bytes);
  ENFILADE_ASSIGN_OR_RETURN(Beginning beginning, GetBeginning(reader));
  MapperState& state = beginning.state;
  if (beginning.version > kVersionWithoutEntry) state.entry = GetEntry(reader);
  if (beginning.version == kVersionWithSeen && state.entry) state.entry->seen = GetRays(reader);
  state.track = GetTrack(reader);
  ENFILADE_RETURN_IF_ERROR(GetActive(reader, stored, options, state.active));
  if (!reader.at_end()) return DataLoss("the checkpoint is truncated or has trailing bytes");
  for (const auto& [id, row] : stored.submaps) {
    if (!row.finished) continue;
    ENFILADE_ASSIGN_OR_RETURN(state.finished[id], RestoreFinishedSubmap(row, options));
  }
  state.nodes = stored.nodes;
  state.loop_closures = stored.loop_closures;
  if (state.nodes.size() != beginning.nodes || state.finished.size() != beginning.finished ||
      state.loop_closures.size() != beginning.closures) {
    return DataLoss(
        "the checkpoint belongs to {} nodes, {} finished submaps and {} loop closures, but {}, {} and {} are stored",
        beginning.nodes, beginning.finished, beginning.closures, state.nodes.size(), state.finished.size(),
        state.loop_closures.size());
  }
  JoinAll(state);
  return std::move(state);
}

absl::StatusOr<ErrorStatistics> DecodeErrors(std::string_view checkpoint) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, Decompress(checkpoint, kMaxCheckpointBytes));
  BinaryReader reader(bytes);
  ENFILADE_ASSIGN_OR_RETURN(const Beginning beginning, GetBeginning(reader));
  if (!reader.ok()) return DataLoss("the checkpoint is truncated");
  return beginning.state.errors;
}

}  // namespace enfilade::slam

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "core/base/binary.h"
#include "core/doors/door_event.h"
#include "core/geometry/pose_codec.h"

namespace enfilade::doors {

// Codecs for parts of the detectors' states.

inline void PutOptional(BinaryWriter& writer, const std::optional<Pose2>& pose) {
  writer.Put<std::uint8_t>(pose.has_value());
  PutPose(writer, pose.value_or(Pose2{}));
}
inline std::optional<Pose2> GetOptional(BinaryReader& reader) {
  const bool has = reader.Get<std::uint8_t>() != 0;
  const Pose2 pose = GetPose(reader);
  return has ? std::optional<Pose2>(pose) : std::nullopt;
}

inline void PutVerdict(BinaryWriter& writer, const CriterionVerdict& verdict) {
  writer.Put(verdict.state);
  writer.PutString(verdict.reason);
}
inline CriterionVerdict GetVerdict(BinaryReader& reader) {
  CriterionVerdict verdict;
  verdict.state = reader.Get<CriterionVerdict::State>();
  verdict.reason = std::string(reader.GetString());
  return verdict;
}

}  // namespace enfilade::doors

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/pose2.h"
#include "core/rooms/room_partition.h"
#include "core/survey/level_survey.h"
#include "core/survey/survey_options.h"

namespace enfilade::survey {

// A robot took something ahead of it for a door.
struct Sighting {
  Pose2 T_level_robot = {};         // when it saw it
  std::optional<SeenGap> gap = {};  // from T_level_robot; unset: somewhere ahead
};

// Tells whether what a robot took for a door can still be one that nobody knows, by the rooms of the level. Keeps
// references.
class DoorsAhead {
 public:
  // `passed`: T_level_door of the doors that robots went through.
  DoorsAhead(const rooms::RoomPartition& partition, const SurveyOptions& options, const std::vector<Pose2>& passed)
      : partition_(partition), options_(options), passed_(passed) {}

  bool MayBeUnknown(const Sighting& sighting) const;

 private:
  bool IsPassed(const rooms::Door& door) const;
  bool IsPassedDoor(const Pose2& T_level_gap) const;
  bool LeadsNowhere(const Pose2& T_level_gap, double width) const;
  bool IsInsideRoom(const Pose2& T_level_gap, double width, const Eigen::Vector2d& before,
                    const Eigen::Vector2d& behind) const;
  bool IsJoinedAt(const Pose2& T_level_gap, int room, int other) const;
  std::optional<Eigen::Vector2d> GroundBeside(const Pose2& T_level_gap, double way) const;
  std::optional<double> AsideOf(const Eigen::Vector2d& place, const Pose2& T_level_robot) const;
  bool IsPassedDoorAhead(const Pose2& T_level_robot) const;
  bool IsOpenAhead(const Pose2& T_level_robot) const;

  const rooms::RoomPartition& partition_;
  const SurveyOptions& options_;
  const std::vector<Pose2>& passed_;
};

}  // namespace enfilade::survey

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "core/base/time.h"
#include "core/closure/door_verdict.h"
#include "core/survey/level_survey.h"
#include "server/app/survey/drive_reader.h"
#include "server/app/survey/lift_rides.h"
#include "storage/sessions/session_store.h"

namespace enfilade::server {

// How a level and the cabins of lifts lie to each other, as the rides show it that ended or began on the level. The
// arguments must outlive it.
class CabinReader {
 public:
  CabinReader(const DriveReader& reader, const LiftRides& rides) : reader_(reader), rides_(rides) {}

  // Where the cabin is that the level's first robot came in, by its first session there. When it came out, the server
  // knew the hall by its first metres only.
  absl::Status PlaceCabin(const storage::Session& stored, const survey::SurveyedSession& first,
                          survey::LevelSurvey& level) const;

  // What `session`, with all its visits, recorded in a cabin, from `left` on. Unset if the door at its end is no
  // cabin's, or none of the visits is beyond it.
  std::optional<survey::CabinEntry> EntryOf(const closure::DoorVerdict& verdict, const survey::SurveyedSession& session,
                                            TimeNs left) const;

  // The session that goes on in a cabin where `last` ended, if there is one.
  absl::Status AddRideBegun(const survey::SurveyedSession& last, survey::LevelSurvey& level) const;

 private:
  const DriveReader& reader_;
  const LiftRides& rides_;
};

}  // namespace enfilade::server

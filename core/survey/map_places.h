// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "core/base/ids.h"
#include "core/geometry/pose2.h"
#include "core/survey/level_survey.h"
#include "core/survey/survey_options.h"

namespace enfilade::survey {

// T_level_map of all maps that sessions with visits are in: where most of what was driven in them has them. Sessions of
// one map may disagree, because the survey that put them there knew less of how the drives bend.
std::map<MapId, Pose2> PlaceMaps(const LevelSurvey& survey, const SurveyOptions& options);

// Whether the survey has a session elsewhere than `T_level_map`, the place of its map, says: by more than
// `options.apart` where the robot was on average, or turned by more than `options.turned`. False without visits.
bool IsOutOfPlace(const SurveyedSession& session, const Pose2& T_level_map, const SurveyOptions& options);

}  // namespace enfilade::survey

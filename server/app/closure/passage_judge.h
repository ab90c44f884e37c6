#pragma once

#include "absl/status/status.h"
#include "server/app/closure/passage_scene.h"
#include "server/app/closure/place_comparison.h"
#include "server/app/closure/stored_views.h"

namespace enfilade::server {

// Judges a passage: a link point of the map itself, one that images and clouds tell of, or a new one. Fills in all of
// `change` but what belongs to the report: session, sequence and graph version. Errors are the stores'.
absl::Status JudgePassage(const CallContext& context, const PassageScene& passage, StoredViews& views,
                          DoorChange& change);

}  // namespace enfilade::server

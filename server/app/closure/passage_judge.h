// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "server/app/closure/passage_scene.h"
#include "server/app/closure/place_comparison.h"
#include "server/app/closure/stored_views.h"

namespace enfilade::server {

// Judges a passage: a link point of the map itself; one that images and clouds tell of; a known map in which the
// robot's scans are found; or a new one. Fills in all of `change` but what belongs to the report: session, sequence and
// graph version. Where it is too early to say (others are in the middle of mapping what may be the same place), tells
// what for, and `change` is not to be stored; empty otherwise. Errors are the stores'.
absl::StatusOr<std::string> JudgePassage(const storage::CallContext& context, const PassageScene& passage,
                                         StoredViews& views, storage::DoorChange& change);

}  // namespace enfilade::server

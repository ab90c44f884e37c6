// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/command.h"
#include "client/sdk/connection.h"
#include "core/edit/map_edit.h"
#include "enfilade/v1/map_edit.pb.h"
#include "enfilade/v1/map_edit_service.pb.h"
#include "nlohmann/json.hpp"

namespace enfilade::cli {

// What the commands of drafts share.

// sites/S/maps/M/drafts/DRAFT of a map that a person means; `draft`: its id or resource name.
absl::StatusOr<std::string> FindDraftName(const client::Connection& connection, const Globals& globals,
                                          const std::string& map, const std::string& draft);

edit::Lattice LatticeOf(const v1::MapLattice& lattice);

std::string ValueText(v1::MapEdit::Value value);   // "occupied"
std::string StateText(const v1::MapDraft& draft);  // "open", "published as 3"
// "2.35 x 0.40 m at (1.00, -3.25)": of the lower-left corner, in metres of the map's frame.
std::string PlaceText(const v1::CellBox& box, const edit::Lattice& lattice);
// "12 cells become free, 3 occupied"; "no cell changes".
std::string ChangesText(const v1::MapChangeCounts& changes);
// "ann, bob"; "nobody named" for none.
std::string PeopleText(const google::protobuf::RepeatedPtrField<std::string>& people);

nlohmann::json DraftToJson(const v1::MapDraft& draft);
nlohmann::json ChangesToJson(const v1::MapChangeCounts& changes);
nlohmann::json BoxToJson(const v1::CellBox& box);

}  // namespace enfilade::cli

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "enfilade/v1/map_edit.pb.h"
#include "enfilade/v1/map_edit_service.pb.h"
#include "proto/convert/names.h"
#include "server/app/edits/map_edits.h"
#include "server/rpc/call/call.h"
#include "storage/maps/map_edit_store.h"

namespace enfilade::server {

v1::MapDraft ToProto(const storage::MapDraft& draft);
v1::MapEdit ToProto(const storage::StoredMapEdit& edit);
v1::CellBox ToProto(const edit::CellBox& box);
v1::MapLattice ToProto(const edit::Lattice& lattice);
v1::LatticePoint ToProto(const edit::LatticePoint& point);
v1::MapChangeCounts ToProto(const ChangeCounts& changes);
v1::MapEdit::Value ToProto(edit::Instruction instruction);
v1::MapEditTile ToProto(const ChangedTile& tile);

edit::CellBox FromProto(const v1::CellBox& box);
edit::LatticePoint FromProto(const v1::LatticePoint& point);
// INVALID_ARGUMENT naming the field. `author`: of an edit that names none.
absl::StatusOr<DrawnEdit> FromProto(const std::string& field, const v1::MapEdit& edit, const std::string& author);

storage::MapDraftKey KeyOf(const convert::MapDraftName& name);

// At most 64 characters, or who calls. INVALID_ARGUMENT naming the field.
absl::StatusOr<std::string> AuthorOr(const char* field, const std::string& author, const Call& call);
// INVALID_ARGUMENT naming the field, unless it has 1 to 500 characters.
absl::Status CheckMessage(const char* field, const std::string& message);

}  // namespace enfilade::server

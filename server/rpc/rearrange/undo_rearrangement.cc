// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/rearrange/handlers.h"
#include "server/rpc/rearrange/messages.h"

namespace enfilade::server {

absl::StatusOr<v1::UndoRearrangementResponse> UndoRearrangement(const Services& services, const Call& call,
                                                                const v1::UndoRearrangementRequest& request) {
  v1::UndoRearrangementResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::RearrangementName name,
                            convert::ParseRearrangementName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::StoredRearrangement undone,
      services.rearrangements.Undo(call.context(), name.site, rearrange::RearrangementId(name.rearrangement)));
  *response.mutable_rearrangement() = ToProto(undone);
  return response;
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/named_revision.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::GetMapRevisionResponse> GetMapRevision(const Services& services, const Call& call,
                                                          const v1::GetMapRevisionRequest& request) {
  v1::GetMapRevisionResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName name,
                            ResolveRevision(services, call.context(), "name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            services.revisions.Get(call.context(), name.site, name.map, name.revision));
  *response.mutable_revision() = ToProto(revision);
  return response;
}

}  // namespace enfilade::server

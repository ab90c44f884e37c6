// SPDX-License-Identifier: Apache-2.0
#include "core/base/status_macros.h"
#include "server/app/rasters/stored_revisions.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/map/named_revision.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::RestoreMapRevisionResponse> RestoreMapRevision(const Services& services, const Call& call,
                                                                  const v1::RestoreMapRevisionRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName name,
                            ResolveRevision(services, call.context(), "name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision older,
                            services.revisions.Get(call.context(), name.site, name.map, name.revision));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision restored,
                            RestoreRevision(call.context(), services.revisions, services.pyramids, older));
  v1::RestoreMapRevisionResponse response;
  *response.mutable_revision() = ToProto(restored);
  // Who restores a map will look at it. As after an import, whoever looks first makes it otherwise.
  services.raster_pyramids.Get(call.context(), restored).IgnoreError();
  return response;
}

}  // namespace enfilade::server

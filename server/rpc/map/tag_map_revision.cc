// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/map/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {

absl::StatusOr<v1::TagMapRevisionResponse> TagMapRevision(const Services& services, const Call& call,
                                                          const v1::TagMapRevisionRequest& request) {
  v1::TagMapRevisionResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const convert::RevisionName name, convert::ParseRevisionName("name", request.name()));
  ENFILADE_RETURN_IF_ERROR(CheckTag("tag", request.tag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapRevision revision,
                            services.revisions.Tag(call.context(), name.site, name.map, name.revision, request.tag()));
  *response.mutable_revision() = ToProto(revision);
  return response;
}

}  // namespace enfilade::server

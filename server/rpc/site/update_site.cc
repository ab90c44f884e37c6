// SPDX-License-Identifier: Apache-2.0
#include <google/protobuf/util/field_mask_util.h>

#include <initializer_list>

#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/resources.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {
namespace {

using google::protobuf::util::FieldMaskUtil;

constexpr std::initializer_list<const char*> kEditable = {
    "display_name", "raw_retention", "session_retention", "revision_retention", "history_retention", "audit_retention"};

google::protobuf::FieldMask UpdatedFields(const v1::UpdateSiteRequest& request) {
  google::protobuf::FieldMask updated;
  for (const char* name : kEditable) {
    const auto* field = v1::Site::descriptor()->FindFieldByName(name);
    const bool is_set = request.site().GetReflection()->HasField(request.site(), field);
    if (IsUpdated(request.update_mask(), name, is_set)) updated.add_paths(name);
  }
  return updated;
}

}  // namespace

absl::StatusOr<v1::UpdateSiteResponse> UpdateSite(const Services& services, const Call& call,
                                                  const v1::UpdateSiteRequest& request) {
  v1::UpdateSiteResponse response;
  ENFILADE_RETURN_IF_ERROR(CheckMask(request.update_mask(), kEditable));
  ENFILADE_ASSIGN_OR_RETURN(const SiteId id, convert::ParseSiteName("site.name", request.site().name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.site().etag()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site stored, services.sites.Get(call.context(), id));

  v1::Site changed = ToProto(stored);
  FieldMaskUtil::MergeOptions replacing;
  replacing.set_replace_message_fields(true);
  FieldMaskUtil::MergeMessageTo(request.site(), UpdatedFields(request), replacing, &changed);
  ENFILADE_ASSIGN_OR_RETURN(storage::Site site, FromProto(changed));
  site.id = id;
  site.etag = etag != 0 ? etag : stored.etag;
  ENFILADE_ASSIGN_OR_RETURN(const storage::Site updated, services.sites.Update(call.context(), site));
  *response.mutable_site() = ToProto(updated);
  return response;
}

}  // namespace enfilade::server

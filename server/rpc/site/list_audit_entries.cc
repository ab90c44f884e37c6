// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "proto/convert/record.h"
#include "server/rpc/paging.h"
#include "server/rpc/site/handlers.h"

namespace enfilade::server {
namespace {

v1::AuditEntry ToProto(const std::string& site_name, const storage::AuditEntry& entry) {
  v1::AuditEntry out;
  *out.mutable_time() = convert::ToTimestamp(entry.time);
  out.set_actor(entry.actor);
  static_assert(static_cast<int>(storage::AuditAction::kDeleted) == v1::AuditEntry::ACTION_DELETED);
  out.set_action(static_cast<v1::AuditEntry::Action>(entry.action));
  out.set_resource(entry.resource.empty() ? site_name : site_name + "/" + entry.resource);
  out.set_before(entry.before);
  out.set_after(entry.after);
  out.set_id(std::to_string(entry.id));
  return out;
}

}  // namespace

absl::StatusOr<v1::ListAuditEntriesResponse> ListAuditEntries(const Services& services, const Call& call,
                                                              const v1::ListAuditEntriesRequest& request) {
  v1::ListAuditEntriesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  const std::string within = NameOf(site) + "/";
  if (!request.resource().empty() && !request.resource().starts_with(within)) {
    return InvalidArgument("resource is \"{}\": expected one of {}", request.resource(), NameOf(site));
  }
  const std::string resource = request.resource().empty() ? "" : request.resource().substr(within.size());
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t before, FromNumericPageToken(request.page_token(), 0));
  ENFILADE_ASSIGN_OR_RETURN(auto entries, services.audit.List(call.context(), site, resource, before, size + 1));
  // The trail outlives its site.
  if (entries.empty()) ENFILADE_RETURN_IF_ERROR(services.sites.Get(call.context(), site).status());
  if (CutToPage(entries, size)) response.set_next_page_token(ToPageToken(std::to_string(entries.back().id)));
  for (const storage::AuditEntry& entry : entries) *response.add_entries() = ToProto(NameOf(site), entry);
  return response;
}

}  // namespace enfilade::server

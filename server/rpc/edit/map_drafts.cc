// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/edit/convert.h"
#include "server/rpc/edit/handlers.h"
#include "server/rpc/paging.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
absl::StatusOr<v1::CreateMapDraftResponse> CreateMapDraft(const Services& services, const Call& call,
                                                          const v1::CreateMapDraftRequest& request) {
  v1::CreateMapDraftResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto map, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::RequestId request_id, RequestIdOf(request));
  const bool is_named = !request.draft_id().empty() || request_id.empty();
  ENFILADE_ASSIGN_OR_RETURN(std::string id,
                            IdOrNew("draft_id", is_named ? request.draft_id() : IdOfRequest(request_id.value)));
  storage::MapDraft draft;
  draft.key = {map.site, map.map, MapDraftId(std::move(id))};
  draft.display_name = request.draft().display_name();
  if (draft.display_name.size() > 800) {
    return InvalidArgument("draft.display_name has {} bytes: at most 800", draft.display_name.size());
  }
  ENFILADE_ASSIGN_OR_RETURN(draft.author, AuthorOr("draft.author", request.draft().author(), call));
  absl::StatusOr<storage::MapDraft> created = services.map_edits.Create(call.context(), draft);
  if (absl::IsAlreadyExists(created.status()) && !request_id.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(storage::MapDraft before, services.map_edit_store.Get(call.context(), draft.key));
    if (before.display_name != draft.display_name || before.author != draft.author) {
      return InvalidArgument("request_id \"{}\" was used for another draft already", request_id.value);
    }
    created = std::move(before);
  }
  ENFILADE_RETURN_IF_ERROR(created.status());
  *response.mutable_draft() = ToProto(*created);
  return response;
}

absl::StatusOr<v1::GetMapDraftResponse> GetMapDraft(const Services& services, const Call& call,
                                                    const v1::GetMapDraftRequest& request) {
  v1::GetMapDraftResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapDraft draft, services.map_edit_store.Get(call.context(), KeyOf(name)));
  *response.mutable_draft() = ToProto(draft);
  return response;
}

absl::StatusOr<v1::ListMapDraftsResponse> ListMapDrafts(const Services& services, const Call& call,
                                                        const v1::ListMapDraftsRequest& request) {
  v1::ListMapDraftsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto map, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string after, FromPageToken(request.page_token()));
  std::optional<bool> published;
  if (request.state() == v1::MapDraft::STATE_OPEN) published = false;
  if (request.state() == v1::MapDraft::STATE_PUBLISHED) published = true;
  ENFILADE_ASSIGN_OR_RETURN(auto drafts, services.map_edit_store.List(call.context(), map.site, map.map, published,
                                                                      MapDraftId(after), size + 1));
  if (CutToPage(drafts, size)) response.set_next_page_token(ToPageToken(drafts.back().key.draft.value()));
  for (const storage::MapDraft& draft : drafts) *response.add_drafts() = ToProto(draft);
  return response;
}

absl::StatusOr<v1::DeleteMapDraftResponse> DeleteMapDraft(const Services& services, const Call& call,
                                                          const v1::DeleteMapDraftRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t etag, ParseEtag(request.etag()));
  ENFILADE_RETURN_IF_ERROR(services.map_edit_store.Delete(call.context(), KeyOf(name), etag));
  return v1::DeleteMapDraftResponse();
}

}  // namespace enfilade::server

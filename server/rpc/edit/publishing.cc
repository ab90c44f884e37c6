// SPDX-License-Identifier: Apache-2.0
#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "server/rpc/edit/convert.h"
#include "server/rpc/edit/handlers.h"
#include "server/rpc/resources.h"

namespace enfilade::server {
namespace {

v1::MapEditConflict ConflictMessage(const edit::Conflict& conflict) {
  v1::MapEditConflict out;
  *out.mutable_box() = ToProto(conflict.region.box);
  out.set_cells(conflict.region.cells);
  out.mutable_my_authors()->Assign(conflict.mine.begin(), conflict.mine.end());
  out.mutable_their_authors()->Assign(conflict.theirs.begin(), conflict.theirs.end());
  return out;
}

v1::ContestedEdit ContestMessage(const SiteId& site, const ContestedPlace& place) {
  v1::ContestedEdit out;
  const edit::Contest& contest = place.contest;
  *out.mutable_box() = ToProto(contest.region.box);
  *out.mutable_lattice() = ToProto(place.lattice);
  out.set_cells(contest.region.cells);
  out.set_edited(ToProto(contest.edited));
  out.set_seen(contest.edited == edit::Instruction::kFree ? v1::MapEdit::VALUE_OCCUPIED : v1::MapEdit::VALUE_FREE);
  out.set_session(NameOf(site, place.session));
  out.set_edit_version(contest.edit_version);
  out.mutable_authors()->Assign(contest.authors.begin(), contest.authors.end());
  out.set_message(contest.message);
  return out;
}

absl::StatusOr<v1::MapRevision> RevisionOf(const Services& services, const Call& call, const storage::MapDraft& draft) {
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::MapRevision revision,
      services.revisions.Get(call.context(), draft.key.site, draft.key.map, draft.published->revision));
  return ToProto(revision);
}

}  // namespace

absl::StatusOr<v1::CheckMapDraftResponse> CheckMapDraft(const Services& services, const Call& call,
                                                        const v1::CheckMapDraftRequest& request) {
  v1::CheckMapDraftResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const DraftCheck check, services.map_edits.Check(call.context(), KeyOf(name)));
  *response.mutable_changes() = ToProto(check.changes);
  if (!check.box.empty()) *response.mutable_box() = ToProto(check.box);
  for (const DraftProblem& problem : check.problems) {
    v1::MapEditProblem& out = *response.add_problems();
    out.set_severity(problem.is_error ? v1::MapEditProblem::SEVERITY_ERROR : v1::MapEditProblem::SEVERITY_WARNING);
    out.set_message(problem.message);
    if (problem.box) *out.mutable_box() = ToProto(*problem.box);
  }
  for (const edit::Conflict& conflict : check.conflicts) *response.add_conflicts() = ConflictMessage(conflict);
  response.set_edit_version(check.edit_version);
  response.set_head(check.head);
  return response;
}

absl::StatusOr<v1::RebaseMapDraftResponse> RebaseMapDraft(const Services& services, const Call& call,
                                                          const v1::RebaseMapDraftRequest& request) {
  v1::RebaseMapDraftResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string author, AuthorOr("author", request.author(), call));
  std::vector<ConflictResolution> resolutions;
  for (int i = 0; i < request.resolutions_size(); ++i) {
    const v1::MapEditResolution& resolution = request.resolutions(i);
    if (resolution.choice() != v1::MapEditResolution::CHOICE_MINE &&
        resolution.choice() != v1::MapEditResolution::CHOICE_THEIRS) {
      return InvalidArgument("resolutions[{}].choice is {}: expected mine or theirs", i,
                             static_cast<int>(resolution.choice()));
    }
    resolutions.push_back(
        {server::FromProto(resolution.box()), resolution.choice() == v1::MapEditResolution::CHOICE_MINE});
  }
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::MapDraft draft,
      services.map_edits.Rebase(call.context(), KeyOf(name), request.edit_version(), resolutions, author));
  *response.mutable_draft() = ToProto(draft);
  return response;
}

absl::StatusOr<v1::PublishMapDraftResponse> PublishMapDraft(const Services& services, const Call& call,
                                                            const v1::PublishMapDraftRequest& request) {
  v1::PublishMapDraftResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  ENFILADE_RETURN_IF_ERROR(CheckMessage("message", request.message()));
  PublishRequest wanted;
  ENFILADE_ASSIGN_OR_RETURN(wanted.etag, ParseEtag(request.etag()));
  wanted.expected_head = request.expected_head();
  wanted.message = request.message();
  wanted.confirm_warnings = request.confirm_warnings();
  ENFILADE_ASSIGN_OR_RETURN(const PublishedDraft published,
                            services.map_edits.Publish(call.context(), KeyOf(name), wanted));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_revision(), RevisionOf(services, call, published.draft));
  *response.mutable_draft() = ToProto(published.draft);
  *response.mutable_changes() = ToProto(published.changes);
  response.set_merged_publications(published.merged_publications);
  return response;
}

absl::StatusOr<v1::ListContestedEditsResponse> ListContestedEdits(const Services& services, const Call& call,
                                                                  const v1::ListContestedEditsRequest& request) {
  v1::ListContestedEditsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const auto places, services.map_edits.ListContested(call.context(), {name.site, name.map}));
  for (const ContestedPlace& place : places) *response.add_contested() = ContestMessage(name.site, place);
  return response;
}

absl::StatusOr<v1::SettleContestedEditsResponse> SettleContestedEdits(const Services& services, const Call& call,
                                                                      const v1::SettleContestedEditsRequest& request) {
  v1::SettleContestedEditsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapName("parent", request.parent()));
  ENFILADE_RETURN_IF_ERROR(CheckMessage("message", request.message()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string author, AuthorOr("author", request.author(), call));
  if (request.settlements().empty()) return InvalidArgument("settlements is empty: there is nothing to settle");
  std::vector<ContestSettlement> settlements;
  for (int i = 0; i < request.settlements_size(); ++i) {
    const v1::ContestSettlement& settlement = request.settlements(i);
    const std::string field = fmt::format("settlements[{}].session", i);
    ENFILADE_ASSIGN_OR_RETURN(const auto session, convert::ParseSessionName(field, settlement.session()));
    if (settlement.choice() != v1::ContestSettlement::CHOICE_KEEP &&
        settlement.choice() != v1::ContestSettlement::CHOICE_DROP) {
      return InvalidArgument("settlements[{}].choice is {}: expected keep or drop", i,
                             static_cast<int>(settlement.choice()));
    }
    settlements.push_back({server::FromProto(settlement.box()), session.session,
                           settlement.choice() == v1::ContestSettlement::CHOICE_KEEP});
  }
  ENFILADE_ASSIGN_OR_RETURN(
      const storage::MapDraft draft,
      services.map_edits.Settle(call.context(), {name.site, name.map}, settlements, request.message(), author));
  ENFILADE_ASSIGN_OR_RETURN(*response.mutable_revision(), RevisionOf(services, call, draft));
  return response;
}

}  // namespace enfilade::server

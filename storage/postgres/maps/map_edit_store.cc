// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/map_edit_store.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/layer_rows.h"
#include "storage/postgres/maps/map_edit_rows.h"
#include "storage/postgres/maps/overlay_rows.h"
#include "storage/postgres/maps/revision_rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::NameOfDraft;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr Statement kSelectMapOfDrafts{"looking for the map",
                                       "SELECT true FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"};
constexpr Statement kLockMapOfDrafts{
    "locking the map", "SELECT true FROM enfilade.maps WHERE site_id = $1 AND map_id = $2 FOR NO KEY UPDATE"};
constexpr Statement kListDrafts{
    "listing drafts",
    "SELECT " ENFILADE_DRAFT_COLUMNS
    " FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2"
    " AND ($3::boolean IS NULL OR (publish_time IS NOT NULL) = $3)"
    " AND ($4 = '' OR (create_time, draft_id) < (SELECT a.create_time, a.draft_id::text FROM enfilade.map_drafts a"
    "   WHERE a.site_id = $1 AND a.map_id = $2 AND a.draft_id = $4))"
    " ORDER BY create_time DESC, draft_id DESC LIMIT $5"};
constexpr Statement kDeleteDraft{
    "deleting the draft", "DELETE FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2 AND draft_id = $3"};
constexpr Statement kFindEdits{"looking for edits",
                               "SELECT edit_id, author FROM enfilade.map_edits WHERE site_id = $1 AND map_id = $2"
                               " AND draft_id = $3 AND edit_id = ANY ($4)"};
constexpr Statement kSwitchEdits{
    "switching edits",
    "WITH e AS (UPDATE enfilade.map_edits SET active = $5, head = $6 WHERE site_id = $1 AND map_id = $2"
    "   AND draft_id = $3 AND edit_id = ANY ($4) AND active <> $5 RETURNING 1)"
    " UPDATE enfilade.map_drafts SET head = $6, active_edits = active_edits + (CASE WHEN $5 THEN 1 ELSE -1 END)"
    "   * (SELECT count(*) FROM e) WHERE site_id = $1 AND map_id = $2 AND draft_id = $3 AND EXISTS (SELECT FROM e)"
    " RETURNING head"};
constexpr Statement kRebaseDraft{"rebasing the draft",
                                 "UPDATE enfilade.map_drafts SET base_edit_version = $4, etag = $5"
                                 " WHERE site_id = $1 AND map_id = $2 AND draft_id = $3"
                                 " RETURNING " ENFILADE_DRAFT_COLUMNS};

Params KeyOf(const MapDraftKey& key) { return Params(key.site, key.map, key.draft); }

// To publish: the map before its draft, in the order in which deleting a map locks them.
absl::Status LockMapOfDraft(Transaction& transaction, const MapDraftKey& key) {
  return transaction.Execute(kLockMapOfDrafts, Params(key.site, key.map)).status();
}

// NOT_FOUND; FAILED_PRECONDITION if it is published.
absl::StatusOr<MapDraft> LockOpenDraft(Transaction& transaction, const MapDraftKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(MapDraft draft, postgres::LockDraft(transaction, key));
  if (!draft.published) return draft;
  return FailedPrecondition("{} is published as revision {}: make a new draft", NameOfDraft(key),
                            draft.published->revision);
}

absl::Status CheckSwitched(const postgres::Result& found, absl::Span<const std::string> ids,
                           const std::optional<std::string>& author, const MapDraftKey& key) {
  std::vector<std::string> known;
  for (int i = 0; i < found.rows(); ++i) {
    Row row(found, i);
    known.emplace_back(row.Text());
    const std::string_view drawn_by = row.Text();
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (author && drawn_by != *author) {
      return FailedPrecondition("edit {} of {} is by \"{}\", not by \"{}\": set `others` to undo it all the same",
                                known.back(), NameOfDraft(key), drawn_by, *author);
    }
  }
  for (const std::string& id : ids) {
    if (std::find(known.begin(), known.end(), id) == known.end()) {
      return NotFound("{} has no edit {}", NameOfDraft(key), id);
    }
  }
  return absl::OkStatus();
}

absl::Status ExplainDraft(const absl::Status& status, const MapDraftKey& key) {
  if (absl::IsNotFound(status)) return status;
  if (absl::IsAlreadyExists(status)) return AlreadyExists("{} exists already", NameOfDraft(key));
  if (postgres::SqlStateOf(status) == "23503") return NotFound("{} does not exist", NameOf(key.site, key.map));
  return WithContext(status, NameOfDraft(key));
}

// In a transaction that has locked or made the draft, whose publications' number is that of the overlay.
absl::StatusOr<MapDraft> PublishDraft(Transaction& transaction, const MapDraftKey& key,
                                      const NewPublication& publication) {
  const postgres::MapKey map{key.site, key.map};
  const auto number = postgres::StoreRevision(transaction, map, publication.revision, {}, MapState::kReady);
  if (!number.ok()) return postgres::ExplainRevisionError(number.status(), key.site, key.map);
  postgres::QueueLayersVersion(transaction, map);
  postgres::QueuePublished(transaction, key, publication.revision.edits->overlay.edit_version, *number,
                           publication.message);
  const auto results = transaction.FlushAndCommit();
  if (!results.ok()) return postgres::ExplainRevisionError(results.status(), key.site, key.map);
  return postgres::ReadOne(results->back(), postgres::ReadDraft, NameOfDraft(key));
}

}  // namespace

absl::StatusOr<MapDraft> MapEditStore::Create(const CallContext& context, const MapDraft& draft) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  const auto created = postgres::InsertDraft(transaction, draft);
  if (!created.ok()) return ExplainDraft(created.status(), draft.key);
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOfDraft(draft.key)));
  return created;
}

absl::StatusOr<MapDraft> MapEditStore::Get(const CallContext& context, const MapDraftKey& key) const {
  return postgres::ReadDraftOf(pool_, context, key);
}

absl::StatusOr<std::vector<MapDraft>> MapEditStore::List(const CallContext& context, const SiteId& site,
                                                         const MapId& map, std::optional<bool> published,
                                                         const MapDraftId& after, int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kSelectMapOfDrafts, Params(site, map));
  transaction.Queue(kListDrafts, Params(site, map, published, after, static_cast<std::int64_t>(limit)));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  if (results[0].rows() == 0) return NotFound("{} does not exist", NameOf(site, map));
  return postgres::ReadRows(results[1], postgres::ReadDraft);
}

absl::Status MapEditStore::Delete(const CallContext& context, const MapDraftKey& key, std::int64_t etag) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, LockOpenDraft(transaction, key));
  if (etag != 0 && etag != draft.etag) return StaleEtag(NameOfDraft(key));
  transaction.Queue(kDeleteDraft, KeyOf(key));
  return transaction.Commit();
}

absl::StatusOr<std::int64_t> MapEditStore::Append(const CallContext& context, const MapDraftKey& key,
                                                  absl::Span<const NewMapEdit> edits) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, LockOpenDraft(transaction, key));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t head, postgres::InsertEdits(transaction, draft, edits));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return head;
}

absl::StatusOr<std::int64_t> MapEditStore::SetActive(const CallContext& context, const MapDraftKey& key,
                                                     absl::Span<const std::string> ids, bool active,
                                                     const std::optional<std::string>& author) const {
  const std::vector<std::string_view> views(ids.begin(), ids.end());
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, LockOpenDraft(transaction, key));
  ENFILADE_ASSIGN_OR_RETURN(const auto found,
                            transaction.Execute(kFindEdits, Params(key.site, key.map, key.draft, views)));
  ENFILADE_RETURN_IF_ERROR(CheckSwitched(found, ids, author, key));
  const std::int64_t next = draft.head + 1;
  ENFILADE_ASSIGN_OR_RETURN(const auto switched, transaction.Execute(kSwitchEdits, Params(key.site, key.map, key.draft,
                                                                                          views, active, next)));
  ENFILADE_RETURN_IF_ERROR(transaction.Commit());
  return switched.rows() == 0 ? draft.head : next;
}

absl::StatusOr<std::vector<StoredMapEdit>> MapEditStore::ListEdits(const CallContext& context, const MapDraft& draft,
                                                                   std::int64_t after_head, std::int64_t after_sequence,
                                                                   int limit) const {
  return postgres::ReadEdits(pool_, context, draft, after_head, after_sequence, limit);
}

absl::StatusOr<MapDraft> MapEditStore::Rebase(const CallContext& context, const MapDraftKey& key, std::int64_t from,
                                              std::int64_t to, absl::Span<const NewMapEdit> edits) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, LockOpenDraft(transaction, key));
  if (draft.base_edit_version != from) {
    return Aborted("{} was put over publication {} meanwhile: check it again", NameOfDraft(key),
                   draft.base_edit_version);
  }
  if (!edits.empty()) ENFILADE_RETURN_IF_ERROR(postgres::InsertEdits(transaction, draft, edits).status());
  transaction.Queue(kRebaseDraft, Params(key.site, key.map, key.draft, to, postgres::NewEtag()));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return postgres::ReadOne(results.back(), postgres::ReadDraft, NameOfDraft(key));
}

absl::StatusOr<OverlayState> MapEditStore::ReadOverlay(const CallContext& context, const SiteId& site,
                                                       const MapId& map) const {
  const postgres::MapKey key{site, map};
  // The version first: if the map changes in between, it is no longer the map's.
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, postgres::ReadLayersVersion(pool_, context, key));
  ENFILADE_ASSIGN_OR_RETURN(OverlayState state, postgres::ReadOverlayRows(pool_, context, key));
  state.layers_version = version;
  return state;
}

absl::StatusOr<std::vector<LayerWitness>> MapEditStore::ReadWitnesses(const CallContext& context, const SiteId& site,
                                                                      const MapId& map) const {
  return postgres::ReadWitnessRows(pool_, context, {site, map});
}

absl::StatusOr<MapDraft> MapEditStore::Publish(const CallContext& context, const MapDraftKey& key,
                                               const NewPublication& publication) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(LockMapOfDraft(transaction, key));
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, LockOpenDraft(transaction, key));
  if (publication.etag != 0 && publication.etag != draft.etag) return StaleEtag(NameOfDraft(key));
  if (publication.expected_head != 0 && publication.expected_head != draft.head) {
    return Aborted("{} has been edited meanwhile: its head is {}, not {}; look at it again", NameOfDraft(key),
                   draft.head, publication.expected_head);
  }
  return PublishDraft(transaction, key, publication);
}

absl::StatusOr<MapDraft> MapEditStore::PublishAtOnce(const CallContext& context, const MapDraft& draft,
                                                     absl::Span<const NewMapEdit> edits,
                                                     const NewPublication& publication) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(LockMapOfDraft(transaction, draft.key));
  const auto created = postgres::InsertDraft(transaction, draft);
  if (!created.ok()) return ExplainDraft(created.status(), draft.key);
  ENFILADE_RETURN_IF_ERROR(postgres::InsertEdits(transaction, *created, edits).status());
  return PublishDraft(transaction, draft.key, publication);
}

absl::Status MapEditStore::StoreRecomposed(const CallContext& context, const SiteId& site, const MapId& map,
                                           const NewRevision& revision) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  absl::Status status = postgres::StoreRevision(transaction, {site, map}, revision, {}, MapState::kReady).status();
  if (status.ok()) status = transaction.Commit();
  return status.ok() ? status : postgres::ExplainRevisionError(status, site, map);
}

}  // namespace enfilade::storage

// SPDX-License-Identifier: Apache-2.0
#include "storage/sites/site_store.h"

#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage {
namespace {

using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

#define ENFILADE_SITE_COLUMNS                                                                          \
  "site_id, display_name, raw_retention_s, session_retention_s, revisions_kept, revision_retention_s," \
  " history_retention_s, audit_retention_s, etag, create_time, update_time, delete_time, delete_actor, deleted_rows"

constexpr Statement kInsertSite{
    "creating the site",
    "INSERT INTO enfilade.sites (site_id, display_name, request_id, request_sha256,"
    " raw_retention_s, session_retention_s, revisions_kept, revision_retention_s,"
    " history_retention_s, audit_retention_s) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)"
    " RETURNING " ENFILADE_SITE_COLUMNS};
// Waits for a creation under way with the same request id.
constexpr Statement kPutRequest{"storing the request",
                                "INSERT INTO enfilade.site_requests (request_id, site_id) VALUES ($1, $2)"};
constexpr Statement kFindRequest{"looking for an earlier request",
                                 "SELECT site_id FROM enfilade.site_requests WHERE request_id = $1"};
constexpr Statement kSelectRequestedSite{"reading the site", "SELECT " ENFILADE_SITE_COLUMNS ENFILADE_SAME_REQUEST(
                                                                 "$2") " FROM enfilade.sites WHERE site_id = $1"};
constexpr Statement kSelectSite{"reading the site",
                                "SELECT " ENFILADE_SITE_COLUMNS " FROM enfilade.sites WHERE site_id = $1"};
constexpr Statement kListSites{"listing sites", "SELECT " ENFILADE_SITE_COLUMNS
                                                " FROM enfilade.sites WHERE site_id > $1 ORDER BY site_id LIMIT $2"};
constexpr Statement kUpdateSite{
    "updating the site",
    "UPDATE enfilade.sites SET display_name = $3, etag = $4, raw_retention_s = $5, session_retention_s = $6,"
    " revisions_kept = $7, revision_retention_s = $8, history_retention_s = $9, audit_retention_s = $10,"
    " update_time = now()"
    " WHERE site_id = $1 AND etag = $2 AND delete_time IS NULL RETURNING " ENFILADE_SITE_COLUMNS};
// Another retention may make some due before they would have been.
constexpr Statement kReviewAllMaps{"looking for revisions past their retention",
                                   "UPDATE enfilade.revision_reviews SET due_time = now()"
                                   " WHERE site_id = $1 AND due_time > now()"};
// Waits for those who are adding to the site, and makes others wait.
constexpr Statement kLockSite{"locking the site",
                              "SELECT " ENFILADE_SITE_COLUMNS " FROM enfilade.sites WHERE site_id = $1 FOR UPDATE"};
constexpr Statement kCountContent{
    "looking for what belongs to the site",
    "SELECT (SELECT count(*) FROM enfilade.maps WHERE site_id = $1 AND redirect_map_id IS NULL),"
    " (SELECT count(*) FROM enfilade.robots WHERE site_id = $1),"
    " (SELECT count(*) FROM enfilade.sessions WHERE site_id = $1 AND delete_time IS NULL)"};
constexpr Statement kMarkSiteDeleted{"deleting the site",
                                     "UPDATE enfilade.sites SET delete_time = now(), delete_actor = $2,"
                                     " etag = $3, update_time = now() WHERE site_id = $1"
                                     " RETURNING " ENFILADE_SITE_COLUMNS};

std::optional<std::chrono::seconds> ReadSeconds(Row& row) {
  if (const auto seconds = row.OptionalInt64()) return std::chrono::seconds(*seconds);
  return std::nullopt;
}

Site ReadSite(Row& row) {
  Site site;
  site.id = SiteId(std::string(row.Text()));
  site.display_name = row.Text();
  site.raw_retention = ReadSeconds(row);
  site.session_retention = ReadSeconds(row);
  const std::optional<std::int64_t> revisions_kept = row.OptionalInt64();
  const std::optional<std::chrono::seconds> revision_age = ReadSeconds(row);
  if (revisions_kept) site.revision_retention = RevisionRetention{static_cast<int>(*revisions_kept), revision_age};
  site.history_retention = ReadSeconds(row);
  site.audit_retention = ReadSeconds(row);
  site.etag = row.Int64();
  site.create_time = row.Time();
  site.update_time = row.Time();
  const std::optional<TimeNs> delete_time = row.OptionalTime();
  std::string actor(row.OptionalText().value_or(""));
  const std::int64_t deleted_rows = row.Int64();
  if (delete_time) site.deletion = Site::Deletion{*delete_time, std::move(actor), deleted_rows};
  return site;
}

absl::Status IsBeingDeleted(const Site& site) { return FailedPrecondition("{} is being deleted", NameOf(site.id)); }

// The site that an earlier creation has made, if that is the same as this one.
absl::StatusOr<Site> InUse(absl::StatusOr<Site> site) {
  if (site.ok() && site->deletion) return IsBeingDeleted(*site);
  return site;
}

// The site that an earlier creation with this request id has made; unset if there was none.
absl::StatusOr<std::optional<Site>> FindRequested(postgres::Pool& pool, const CallContext& context,
                                                  const RequestId& request_id) {
  if (request_id.empty()) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(const auto request,
                            ExecuteAlone(pool, context, kFindRequest, Params(postgres::IdOrNull(request_id))));
  if (request.rows() == 0) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(const std::string id,
                            postgres::ReadOne(
                                request, [](Row& row) { return std::string(row.Text()); }, "the request"));
  ENFILADE_ASSIGN_OR_RETURN(const auto earlier, ExecuteAlone(pool, context, kSelectRequestedSite,
                                                             Params(id, postgres::DigestOrNull(request_id))));
  if (earlier.rows() == 0) return std::nullopt;
  ENFILADE_ASSIGN_OR_RETURN(Site site, InUse(postgres::ReadRequested(earlier, ReadSite, NameOf(SiteId(id)))));
  return site;
}

std::optional<std::int64_t> Count(const std::optional<std::chrono::seconds>& duration) {
  if (!duration) return std::nullopt;
  return duration->count();
}

// `first` and the columns of the retentions, in the order of the table.
template <typename... First>
Params WithRetentions(const Site& site, const First&... first) {
  const std::optional<RevisionRetention>& revisions = site.revision_retention;
  const auto kept = revisions ? std::optional(std::int64_t{revisions->newest}) : std::nullopt;
  return Params(first..., Count(site.raw_retention), Count(site.session_retention), kept,
                revisions ? Count(revisions->age) : std::nullopt, Count(site.history_retention),
                Count(site.audit_retention));
}

// ALREADY_EXISTS if the site exists, or the request does.
absl::StatusOr<Site> Insert(postgres::Pool& pool, const CallContext& context, const Site& site,
                            const RequestId& request_id) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  if (!request_id.empty()) {
    transaction.Queue(kPutRequest, Params(postgres::IdOrNull(request_id), site.id));
  }
  transaction.Queue(kInsertSite, WithRetentions(site, site.id, site.display_name, postgres::IdOrNull(request_id),
                                                postgres::DigestOrNull(request_id)));
  ENFILADE_ASSIGN_OR_RETURN(const auto results, transaction.FlushAndCommit());
  return postgres::ReadOne(results.back(), ReadSite, NameOf(site.id));
}

// `content`: the answer of kCountContent.
absl::Status CheckEmpty(const SiteId& site, const postgres::Result& content) {
  Row row(content, 0);
  const std::int64_t maps = row.Int64();
  const std::int64_t robots = row.Int64();
  const std::int64_t sessions = row.Int64();
  ENFILADE_RETURN_IF_ERROR(row.status());
  if (maps + robots + sessions == 0) return absl::OkStatus();
  return FailedPrecondition("{} still has {} maps, {} robots and {} sessions: delete them first, or use force",
                            NameOf(site), maps, robots, sessions);
}

}  // namespace

absl::StatusOr<Site> SiteStore::Create(const CallContext& context, const Site& site,
                                       const RequestId& request_id) const {
  const absl::StatusOr<Site> inserted = Insert(pool_, context, site, request_id);
  if (inserted.ok()) return inserted;
  if (!absl::IsAlreadyExists(inserted.status())) return WithContext(inserted.status(), NameOf(site.id));
  ENFILADE_ASSIGN_OR_RETURN(const std::optional<Site> earlier, FindRequested(pool_, context, request_id));
  if (earlier) return *earlier;
  const absl::StatusOr<Site> other = Get(context, site.id);
  if (other.ok() && other->deletion) {
    return FailedPrecondition("{} is being deleted: its id can be used again when it is gone", NameOf(site.id));
  }
  return AlreadyExists("{} exists already", NameOf(site.id));
}

absl::StatusOr<Site> SiteStore::Get(const CallContext& context, const SiteId& site) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kSelectSite, Params(site)));
  return storage::postgres::ReadOne(result, ReadSite, NameOf(site));
}

absl::StatusOr<std::vector<Site>> SiteStore::List(const CallContext& context, const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListSites,
                                                            Params(page.after, static_cast<std::int64_t>(page.limit))));
  return storage::postgres::ReadRows(result, ReadSite);
}

absl::StatusOr<Site> SiteStore::Update(const CallContext& context, const Site& site) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kUpdateSite, WithRetentions(site, site.id, site.etag, site.display_name, postgres::NewEtag()));
  transaction.Queue(kReviewAllMaps, Params(site.id));
  const auto results = transaction.FlushAndCommit();
  if (!results.ok()) return WithContext(results.status(), NameOf(site.id));
  if (results->front().rows() > 0) return storage::postgres::ReadOne(results->front(), ReadSite, NameOf(site.id));
  ENFILADE_RETURN_IF_ERROR(InUse(Get(context, site.id)).status());
  return postgres::StaleEtag(NameOf(site.id));
}

absl::StatusOr<Site> SiteStore::Delete(const CallContext& context, const SiteId& site, std::int64_t etag,
                                       bool force) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  transaction.Queue(kLockSite, Params(site));
  transaction.Queue(kCountContent, Params(site));
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Flush());
  ENFILADE_ASSIGN_OR_RETURN(Site stored, storage::postgres::ReadOne(found[0], ReadSite, NameOf(site)));
  if (stored.deletion) return stored;
  if (etag != 0 && etag != stored.etag) return postgres::StaleEtag(NameOf(site));
  if (!force) ENFILADE_RETURN_IF_ERROR(CheckEmpty(site, found[1]));
  transaction.Queue(kMarkSiteDeleted, Params(site, context.actor, postgres::NewEtag()));
  ENFILADE_ASSIGN_OR_RETURN(const auto marked, transaction.FlushAndCommit());
  return storage::postgres::ReadOne(marked[0], ReadSite, NameOf(site));
}

}  // namespace enfilade::storage

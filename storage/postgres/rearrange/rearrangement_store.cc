// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/rearrangement_store.h"

#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/pose_columns.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/graph/site_locks.h"
#include "storage/postgres/maps/revision_rows.h"
#include "storage/postgres/rearrange/rearrangement_changes.h"
#include "storage/postgres/rearrange/rearrangement_rows.h"
#include "storage/postgres/rearrange/rearrangement_undo.h"
#include "storage/postgres/rearrange/session_cuts.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kResolveMap{"following redirects", "SELECT map_id, x, y, yaw FROM enfilade.resolve_map($1, $2)"};

// An error of the schema in terms of the API.
absl::Status ExplainRearrangement(const absl::Status& status, const SiteId& site,
                                  const rearrange::RearrangementId& id) {
  const std::string constraint = ConstraintOf(status);
  if (constraint == "rearrangements_pkey") return AlreadyExists("{} exists already", NameOfRearrangement(site, id));
  if (constraint == "sessions_pkey") {
    return AlreadyExists("the id of a session's rest is taken: {}", std::string(status.message()));
  }
  if (constraint == "maps_pkey") return AlreadyExists("a new map's id is taken: {}", std::string(status.message()));
  return ExplainRevisionError(status, site, MapId());
}

}  // namespace

absl::StatusOr<StoredRearrangement> RearrangementStore::Apply(const CallContext& context, const SiteLease& lease,
                                                              const RearrangementChange& change) const {
  const SiteId& site = lease.site;
  ENFILADE_RETURN_IF_ERROR(ValidateToApply(change.rearrangement));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_RETURN_IF_ERROR(LockGraphAt(transaction, site, change.graph_version));
  ENFILADE_RETURN_IF_ERROR(LockSiteLease(transaction, lease));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version, RaiseGraphVersion(transaction, site, GraphCause::kRearranged,
                                                                          ResourceOfRearrangement(change.id)));
  QueueRearrangement(transaction, site, change, version);
  QueueRearranging(transaction, change.id);
  ENFILADE_RETURN_IF_ERROR(ExplainRearrangement(transaction.Flush().status(), site, change.id));
  ENFILADE_RETURN_IF_ERROR(LockAndCheck(transaction, site, change));
  QueueImagesBefore(transaction, site, change.id);
  QueueCuts(transaction, site, change);
  ENFILADE_RETURN_IF_ERROR(ExplainRearrangement(AddMaps(transaction, site, change, version), site, change.id));
  QueueMoves(transaction, site, change.id);
  ENFILADE_RETURN_IF_ERROR(ChangeLinkPoints(transaction, site, change, version));
  ENFILADE_RETURN_IF_ERROR(ChangeRasters(transaction, site, change));
  QueueDraftMoves(transaction, site, change);
  QueueRedirects(transaction, site, change.id);
  if (change.by_people) QueuePins(transaction, site, change.id);
  QueueImagesAfter(transaction, site, change.id);
  ENFILADE_RETURN_IF_ERROR(ExplainRearrangement(transaction.Flush().status(), site, change.id));
  ENFILADE_ASSIGN_OR_RETURN(StoredRearrangement stored, ReadRearrangement(transaction, site, change.id));
  ENFILADE_RETURN_IF_ERROR(ExplainRearrangement(transaction.Commit(), site, change.id));
  return stored;
}

absl::StatusOr<StoredRearrangement> RearrangementStore::Undo(const CallContext& context, const SiteLease& lease,
                                                             const rearrange::RearrangementId& id) const {
  const SiteId& site = lease.site;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  QueueGraphLock(transaction, site);
  ENFILADE_RETURN_IF_ERROR(LockSiteLease(transaction, lease));
  ENFILADE_ASSIGN_OR_RETURN(const StoredRearrangement applied, ReadRearrangement(transaction, site, id));
  ENFILADE_RETURN_IF_ERROR(LockAndCheckUnchanged(transaction, site, applied));
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t version,
                            RaiseGraphVersion(transaction, site, GraphCause::kRearranged, ResourceOfRearrangement(id)));
  QueueRearranging(transaction, id);
  ENFILADE_RETURN_IF_ERROR(RestoreImages(transaction, site, id, version));
  QueuePins(transaction, site, id);
  ENFILADE_ASSIGN_OR_RETURN(StoredRearrangement stored, ReadRearrangement(transaction, site, id));
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOfRearrangement(site, id)));
  return stored;
}

absl::StatusOr<rearrange::MapRedirect> RearrangementStore::Resolve(const CallContext& context, const SiteId& site,
                                                                   const MapId& map) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kResolveMap, Params(site, map)));
  return ReadOne(
      result,
      [&](Row& row) {
        MapId to{std::string(row.Text())};
        return rearrange::MapRedirect{map, std::move(to), ReadPose(row)};
      },
      NameOf(site, map));
}

absl::StatusOr<StoredRearrangement> RearrangementStore::Get(const CallContext& context, const SiteId& site,
                                                            const rearrange::RearrangementId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  return ReadRearrangement(transaction, site, id);
}

absl::StatusOr<std::vector<StoredRearrangement>> RearrangementStore::List(const CallContext& context,
                                                                          const SiteId& site, std::int64_t before,
                                                                          int limit) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  return ReadRearrangements(transaction, site, before, limit);
}

}  // namespace enfilade::storage::postgres

// SPDX-License-Identifier: Apache-2.0
#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "storage/link_point_store.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_changes.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

// FOR KEY SHARE: it is not collected meanwhile.
constexpr Statement kLockBlob{"looking for the blob",
                              "SELECT size FROM enfilade.blobs WHERE site_id = $1 AND sha256 = $2 FOR KEY SHARE"};
constexpr Statement kListEvidence{"listing the evidence",
                                  "SELECT e.link_point_id, e.map_id, e.kind, e.encoding, e.sha256, b.size, e.time_ns,"
                                  " e.x, e.y, e.yaw"
                                  " FROM enfilade.link_point_evidence e JOIN enfilade.blobs b"
                                  "   ON b.site_id = e.site_id AND b.sha256 = e.sha256"
                                  " WHERE e.site_id = $1 AND e.link_point_id = ANY ($2)"
                                  " ORDER BY e.link_point_id, e.map_id, e.kind, e.ordinal"};

Evidence ReadEvidence(Row& row) {
  Evidence evidence;
  evidence.link_point = LinkPointId(std::string(row.Text()));
  evidence.map = MapId(std::string(row.Text()));
  evidence.kind = static_cast<EvidenceKind>(row.Int16());
  evidence.encoding = row.Int16();
  evidence.content.sha256 = row.Bytes();
  evidence.content.size = row.Int64();
  evidence.time = row.Int64();
  const std::optional<double> x = row.OptionalDouble();
  const std::optional<double> y = row.OptionalDouble();
  const std::optional<double> yaw = row.OptionalDouble();
  if (x && y && yaw) evidence.T_map_robot = Pose2{*x, *y, *yaw};
  return evidence;
}

}  // namespace

absl::Status LinkPointStore::PutEvidence(const CallContext& context, const SiteId& site,
                                         const Evidence& evidence) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto blob,
                            transaction.Execute(kLockBlob, Params(site, Bytes{evidence.content.sha256})));
  if (blob.rows() == 0) {
    return InvalidArgument("the blob {} is not stored in {}: send it first", ToHex(evidence.content.sha256),
                           NameOf(site));
  }
  postgres::QueueEvidence(transaction, site, {evidence});
  const absl::Status committed = transaction.Commit();
  if (postgres::SqlStateOf(committed) == "23503") {
    return NotFound("{} has no anchor in the map \"{}\"", NameOf(site, evidence.link_point), evidence.map.value());
  }
  return WithContext(committed, NameOf(site, evidence.link_point));
}

absl::StatusOr<std::vector<Evidence>> LinkPointStore::ListEvidence(const CallContext& context, const SiteId& site,
                                                                   const std::vector<LinkPointId>& link_points) const {
  if (link_points.empty()) return std::vector<Evidence>();
  std::vector<std::string_view> ids;
  for (const LinkPointId& id : link_points) ids.push_back(id.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result,
                            storage::postgres::ExecuteAlone(pool_, context, kListEvidence, Params(site, ids)));
  return storage::postgres::ReadRows(result, ReadEvidence);
}

}  // namespace enfilade::storage

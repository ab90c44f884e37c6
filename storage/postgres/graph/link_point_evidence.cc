// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/graph/link_point_evidence.h"

#include <algorithm>
#include <optional>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "storage/postgres/driver/rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kDropEvidence{"replacing evidence",
                                  "DELETE FROM enfilade.link_point_evidence"
                                  " WHERE site_id = $1 AND link_point_id = $2 AND map_id = $3 AND kind = $4"};
// Its number follows those of its kind.
constexpr Statement kPutEvidence{
    "storing the evidence",
    "INSERT INTO enfilade.link_point_evidence"
    " (site_id, link_point_id, map_id, kind, ordinal, encoding, sha256, time_ns, x, y, yaw)"
    " SELECT $1, $2, $3, $4, (SELECT coalesce(max(ordinal), 0) + 1 FROM enfilade.link_point_evidence"
    "   WHERE site_id = $1 AND link_point_id = $2 AND map_id = $3 AND kind = $4), $5, $6, $7, $8, $9, $10"
    " ON CONFLICT (site_id, link_point_id, map_id, kind, ordinal) DO UPDATE SET encoding = excluded.encoding,"
    " sha256 = excluded.sha256, time_ns = excluded.time_ns, x = excluded.x, y = excluded.y, yaw = excluded.yaw"};
// FOR KEY SHARE: Maintenance cannot collect it before the commit.
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

void QueueEvidence(Transaction& transaction, const SiteId& site, const std::vector<Evidence>& evidence) {
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const Evidence& item = evidence[i];
    const auto kind = static_cast<std::int16_t>(item.kind);
    const bool is_first =
        std::none_of(evidence.begin(), evidence.begin() + static_cast<std::ptrdiff_t>(i), [&](const Evidence& before) {
          return before.link_point == item.link_point && before.map == item.map && before.kind == item.kind;
        });
    if (is_first) transaction.Queue(kDropEvidence, Params(site, item.link_point, item.map, kind));
    std::optional<double> x, y, yaw;
    if (item.T_map_robot) {
      x = item.T_map_robot->x;
      y = item.T_map_robot->y;
      yaw = item.T_map_robot->yaw;
    }
    transaction.Queue(kPutEvidence, Params(site, item.link_point, item.map, kind, item.encoding,
                                           Bytes{item.content.sha256}, item.time, x, y, yaw));
  }
}

absl::Status PutEvidence(Pool& pool, const CallContext& context, const SiteId& site, const Evidence& evidence) {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool, context));
  ENFILADE_ASSIGN_OR_RETURN(const auto blob,
                            transaction.Execute(kLockBlob, Params(site, Bytes{evidence.content.sha256})));
  if (blob.rows() == 0) {
    return InvalidArgument("the blob {} is not stored in {}: send it first", ToHex(evidence.content.sha256),
                           NameOf(site));
  }
  QueueEvidence(transaction, site, {evidence});
  const absl::Status committed = transaction.Commit();
  if (SqlStateOf(committed) == "23503") {
    return NotFound("{} has no anchor in the map \"{}\"", NameOf(site, evidence.link_point), evidence.map.value());
  }
  return WithContext(committed, NameOf(site, evidence.link_point));
}

absl::StatusOr<std::vector<Evidence>> ListEvidence(Pool& pool, const CallContext& context, const SiteId& site,
                                                   const std::vector<LinkPointId>& link_points) {
  if (link_points.empty()) return std::vector<Evidence>();
  std::vector<std::string_view> ids;
  for (const LinkPointId& id : link_points) ids.push_back(id.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool, context, kListEvidence, Params(site, ids)));
  return ReadRows(result, ReadEvidence);
}

}  // namespace enfilade::storage::postgres

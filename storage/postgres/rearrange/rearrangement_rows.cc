// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/rearrange/rearrangement_rows.h"

#include <map>
#include <optional>
#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/link_point_rows.h"
#include "storage/postgres/graph/placement.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kInsertRearrangement{"storing the rearrangement",
                                         "INSERT INTO enfilade.rearrangements (site_id, rearrangement_id, reason, "
                                         "version_before, version_after, prior_map_id)"
                                         " VALUES ($1, $2, $3, $4, $5, $6)"};
// The rest of a cut session comes from its map. A cut is made at a keyframe: scans are relative to the one before them.
constexpr Statement kInsertParts{
    "storing the rearrangement's parts",
    "INSERT INTO enfilade.rearrangement_parts (site_id, rearrangement_id, kind, subject, source, target,"
    " first_sequence, x, y, yaw, ordinal)"
    " SELECT $1, $2, $3, u.subject, CASE WHEN $3 = 6 THEN u.subject WHEN $3 IN (2, 3) THEN (SELECT s.map_id"
    "   FROM enfilade.sessions s WHERE s.site_id = $1 AND s.session_id = coalesce((SELECT c.subject"
    "     FROM enfilade.rearrangement_parts c WHERE c.site_id = $1 AND c.rearrangement_id = $2 AND c.kind = 2"
    "     AND c.target = u.subject), u.subject)) END, nullif(u.target, ''),"
    " CASE WHEN $3 = 2 THEN (SELECT coalesce(min(n.sequence), u.first_sequence) FROM enfilade.slam_nodes n"
    "   WHERE n.site_id = $1 AND n.session_id = u.subject AND n.sequence >= u.first_sequence) END, CASE WHEN $3 IN (3, "
    "6) THEN u.x END,"
    " CASE WHEN $3 IN (3, 6) THEN u.y END, CASE WHEN $3 IN (3, 6) THEN u.yaw END, u.n"
    " FROM unnest($4::text[], $5::text[], $6::bigint[], $7::float8[], $8::float8[], $9::float8[])"
    " WITH ORDINALITY AS u (subject, target, first_sequence, x, y, yaw, n)"};
#define ENFILADE_REARRANGEMENT_COLUMNS                                                                       \
  "rearrangement_id, reason, actor, version_before, version_after, version_undone, create_time, undo_time, " \
  "undo_expired"
constexpr Statement kSelectRearrangement{"reading the rearrangement",
                                         "SELECT " ENFILADE_REARRANGEMENT_COLUMNS
                                         " FROM enfilade.rearrangements WHERE site_id = $1 AND rearrangement_id = $2"};
constexpr Statement kListRearrangements{"listing rearrangements",
                                        "SELECT " ENFILADE_REARRANGEMENT_COLUMNS
                                        " FROM enfilade.rearrangements WHERE site_id = $1"
                                        " AND ($2 = 0 OR version_after < $2) ORDER BY version_after DESC LIMIT $3"};
constexpr Statement kSelectParts{
    "reading the rearrangements' parts",
    "SELECT rearrangement_id, kind, subject, coalesce(target::text, ''), coalesce(first_sequence, 0), coalesce(x, 0),"
    " coalesce(y, 0), coalesce(yaw, 0) FROM enfilade.rearrangement_parts"
    " WHERE site_id = $1 AND rearrangement_id = ANY ($2) ORDER BY rearrangement_id, kind, ordinal"};
constexpr Statement kSelectLinkPointsOf{
    "reading the rearranged link points",
    "SELECT " ENFILADE_LINK_POINT_COLUMNS " FROM enfilade.link_points p" ENFILADE_JOIN_ANCHORS
    " WHERE p.site_id = $1 AND p.link_point_id IN (SELECT subject FROM enfilade.rearrangement_parts"
    "   WHERE site_id = $1 AND rearrangement_id = $2 AND kind IN (4, 5)) ORDER BY p.link_point_id, a.ordinal"};

// The columns of parts of one kind, as arrays.
class PartColumns {
 public:
  void Add(const std::string& subject, const std::string& target, std::int64_t first_sequence, const Pose2& pose) {
    subjects_.push_back(subject);
    targets_.push_back(target);
    first_sequences_.push_back(first_sequence);
    x_.push_back(pose.x);
    y_.push_back(pose.y);
    yaw_.push_back(pose.yaw);
  }
  void QueueTo(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id,
               RearrangementPart kind) const {
    if (subjects_.empty()) return;
    transaction.Queue(kInsertParts, Params(site, id, static_cast<std::int16_t>(kind), subjects_, targets_,
                                           first_sequences_, x_, y_, yaw_));
  }

 private:
  std::vector<std::string_view> subjects_, targets_;
  std::vector<std::int64_t> first_sequences_;
  std::vector<double> x_, y_, yaw_;
};

StoredRearrangement ReadRearrangementRow(Row& row) {
  StoredRearrangement stored;
  stored.id = rearrange::RearrangementId(std::string(row.Text()));
  stored.reason = row.Text();
  stored.actor = row.Text();
  stored.version_before = row.Int64();
  stored.version_after = row.Int64();
  stored.version_undone = row.Int64();
  stored.create_time = row.Time();
  stored.undo_time = row.OptionalTime();
  stored.undo_expired = row.Bool();
  return stored;
}

void AddPart(RearrangementPart kind, Row& row, StoredRearrangement& stored) {
  std::string subject(row.Text());
  std::string target(row.Text());
  const std::int64_t first_sequence = row.Int64();
  const double x = row.Double();
  const double y = row.Double();
  const Pose2 pose{x, y, row.Double()};
  switch (kind) {
    case RearrangementPart::kNewMap:
      stored.new_maps.emplace_back(std::move(subject));
      break;
    case RearrangementPart::kCut:
      stored.cuts.push_back({SessionId(std::move(subject)), first_sequence, SessionId(std::move(target))});
      break;
    case RearrangementPart::kMove:
      stored.moves.push_back({SessionId(std::move(subject)), MapId(std::move(target)), pose});
      break;
    case RearrangementPart::kStoredLinkPoint:
      stored.changed_link_points.emplace_back(std::move(subject));
      break;
    case RearrangementPart::kRemovedLinkPoint:
      stored.removed_link_points.emplace_back(std::move(subject));
      break;
    case RearrangementPart::kRedirect:
      stored.redirects.push_back({MapId(std::move(subject)), MapId(std::move(target)), pose});
      break;
  }
}

absl::StatusOr<std::vector<StoredRearrangement>> WithParts(Transaction& transaction, const SiteId& site,
                                                           std::vector<StoredRearrangement> stored) {
  std::map<std::string, StoredRearrangement*, std::less<>> by_id;
  std::vector<std::string_view> ids;
  for (StoredRearrangement& rearrangement : stored) {
    rearrangement.site = site;
    by_id[rearrangement.id.value()] = &rearrangement;
    ids.push_back(rearrangement.id.value());
  }
  ENFILADE_ASSIGN_OR_RETURN(const Result parts, transaction.Execute(kSelectParts, Params(site, ids)));
  for (int i = 0; i < parts.rows(); ++i) {
    Row row(parts, i);
    const auto found = by_id.find(row.Text());
    const auto kind = static_cast<RearrangementPart>(row.Int16());
    if (found != by_id.end()) AddPart(kind, row, *found->second);
    ENFILADE_RETURN_IF_ERROR(row.status());
  }
  return stored;
}

}  // namespace

void QueueRearrangement(Transaction& transaction, const SiteId& site, const RearrangementChange& change,
                        std::int64_t version) {
  const rearrange::Rearrangement& rearrangement = change.rearrangement;
  transaction.Queue(kInsertRearrangement, Params(site, change.id, rearrangement.reason, change.graph_version, version,
                                                 NullIfEmpty(rearrangement.plan.value())));
  PartColumns maps, cuts, moves, stored, removed, redirects;
  for (const auto& map : rearrangement.new_maps) maps.Add(map.id.value(), "", 0, {});
  for (const auto& cut : rearrangement.cuts) cuts.Add(cut.session.value(), cut.rest.value(), cut.first_sequence, {});
  for (const auto& move : rearrangement.moves) moves.Add(move.session.value(), move.to.value(), 0, move.T_to_from);
  for (const auto& point : rearrangement.link_points) stored.Add(point.id.value(), "", 0, {});
  for (const auto& id : rearrangement.removed_link_points) removed.Add(id.value(), "", 0, {});
  for (const auto& redirect : rearrangement.redirects) {
    redirects.Add(redirect.from.value(), redirect.to.value(), 0, redirect.T_to_from);
  }
  maps.QueueTo(transaction, site, change.id, RearrangementPart::kNewMap);
  cuts.QueueTo(transaction, site, change.id, RearrangementPart::kCut);
  moves.QueueTo(transaction, site, change.id, RearrangementPart::kMove);
  stored.QueueTo(transaction, site, change.id, RearrangementPart::kStoredLinkPoint);
  removed.QueueTo(transaction, site, change.id, RearrangementPart::kRemovedLinkPoint);
  redirects.QueueTo(transaction, site, change.id, RearrangementPart::kRedirect);
}

absl::StatusOr<StoredRearrangement> ReadRearrangement(Transaction& transaction, const SiteId& site,
                                                      const rearrange::RearrangementId& id) {
  ENFILADE_ASSIGN_OR_RETURN(const Result found, transaction.Execute(kSelectRearrangement, Params(site, id)));
  ENFILADE_ASSIGN_OR_RETURN(StoredRearrangement stored,
                            ReadOne(found, ReadRearrangementRow, NameOfRearrangement(site, id)));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredRearrangement> one, WithParts(transaction, site, {std::move(stored)}));
  return std::move(one.front());
}

absl::StatusOr<std::vector<StoredRearrangement>> ReadRearrangements(Transaction& transaction, const SiteId& site,
                                                                    std::int64_t before, int limit) {
  ENFILADE_ASSIGN_OR_RETURN(const Result found,
                            transaction.Execute(kListRearrangements, Params(site, before, std::int64_t{limit})));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<StoredRearrangement> stored, ReadRows(found, ReadRearrangementRow));
  return WithParts(transaction, site, std::move(stored));
}

absl::Status PlaceLinkPointsOf(Transaction& transaction, const SiteId& site, const rearrange::RearrangementId& id,
                               std::int64_t version) {
  ENFILADE_ASSIGN_OR_RETURN(const Result found, transaction.Execute(kSelectLinkPointsOf, Params(site, id)));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<StoredLinkPoint> link_points, ReadLinkPoints(found));
  for (const StoredLinkPoint& link_point : link_points) {
    ENFILADE_RETURN_IF_ERROR(PlaceLinkPoint(transaction, site, version, link_point.point));
  }
  return absl::OkStatus();
}

}  // namespace enfilade::storage::postgres

// SPDX-License-Identifier: Apache-2.0
#include "storage/maps/prior_map_store.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "core/base/resource_name.h"
#include "core/base/sha256.h"
#include "fmt/format.h"
#include "fmt/ranges.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/graph/graph_versions.h"
#include "storage/postgres/maps/blob_store.h"
#include "storage/postgres/maps/prior_map_rows.h"

namespace enfilade::storage {
namespace {

using postgres::Bytes;
using postgres::ExecuteAlone;
using postgres::Params;
using postgres::Row;
using postgres::Statement;
using postgres::Transaction;

constexpr Statement kInsertPriorMap{
    "creating the prior map",
    "INSERT INTO enfilade.prior_maps (site_id, prior_map_id, display_name, level, state, reason, file_name, warnings,"
    " walls, corners, doors, rooms, shafts, metres_per_unit, etag)"
    " VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15)"
    " RETURNING " ENFILADE_PRIOR_MAP_COLUMNS};
constexpr Statement kInsertPriorMapFiles{
    "storing the prior map's files",
    "INSERT INTO enfilade.prior_map_files (site_id, prior_map_id, product, name, size_bytes, sha256)"
    " SELECT $1, $2, u.product, u.name, u.size_bytes, u.sha256"
    " FROM unnest($3::smallint[], $4::text[], $5::bigint[], $6::bytea[]) AS u (product, name, size_bytes, sha256)"};
constexpr Statement kDeleteFilesFrom{"deleting the last alignment's files",
                                     "DELETE FROM enfilade.prior_map_files"
                                     " WHERE site_id = $1 AND prior_map_id = $2 AND product >= $3"};
constexpr Statement kSelectPriorMap{"reading the prior map",
                                    "SELECT " ENFILADE_PRIOR_MAP_COLUMNS
                                    " FROM enfilade.prior_maps WHERE site_id = $1 AND prior_map_id = $2"};
constexpr Statement kListPriorMaps{"listing prior maps",
                                   "SELECT " ENFILADE_PRIOR_MAP_COLUMNS
                                   " FROM enfilade.prior_maps WHERE site_id = $1 AND prior_map_id > $2"
                                   " ORDER BY prior_map_id LIMIT $3"};
constexpr Statement kListOutgrown{
    "listing prior maps whose maps have grown",
    "SELECT " ENFILADE_PRIOR_MAP_COLUMNS
    " FROM enfilade.prior_maps p WHERE state = 3 AND align_time < now() - $1 * interval '1 second'"
    " AND EXISTS (SELECT FROM enfilade.maps m JOIN enfilade.map_revisions r"
    "   ON r.site_id = m.site_id AND r.map_id = m.map_id AND r.revision = m.current_revision"
    "   WHERE m.site_id = p.site_id AND m.level = p.level AND r.create_time > p.align_time)"
    " ORDER BY align_time LIMIT $2"};
#define ENFILADE_UPDATE_PRIOR_MAP(assignments)  \
  "UPDATE enfilade.prior_maps SET " assignments \
  ", etag = $4, update_time = now()"            \
  " WHERE site_id = $1 AND prior_map_id = $2 AND ($3 = 0 OR etag = $3) RETURNING " ENFILADE_PRIOR_MAP_COLUMNS
constexpr Statement kRenamePriorMap{"renaming the prior map", ENFILADE_UPDATE_PRIOR_MAP("display_name = $5")};
constexpr Statement kSetPriorMapState{"changing the prior map's state",
                                      ENFILADE_UPDATE_PRIOR_MAP("state = $5, reason = $6")};
constexpr Statement kSetPriorMapAlignment{
    "storing the alignment",
    ENFILADE_UPDATE_PRIOR_MAP("state = $5, reason = $6, affine = $7, model = $8, explained = $9, contradicted = $10,"
                              " rival_ratio = $11, aligned_maps = $12, graph_version = $13, pair_maps = $14,"
                              " pair_points = $15, tied_walls = $16, joined_maps = $17, align_time = now()")};
constexpr Statement kSetPriorMapElements{
    "storing the corrected plan",
    ENFILADE_UPDATE_PRIOR_MAP("state = $5, reason = $6, walls = $7, corners = $8, doors = $9, rooms = $10,"
                              " shafts = $11, metres_per_unit = $12")};
constexpr Statement kIsInUse{"looking whether the prior map is in use",
                             "SELECT count(*) FROM enfilade.prior_maps"
                             " WHERE site_id = $1 AND prior_map_id = $2 AND state = 3"};
constexpr Statement kSelectMapTimes{"looking for the alignment's maps",
                                    "SELECT map_id, create_time FROM enfilade.maps"
                                    " WHERE site_id = $1 AND map_id = ANY ($2) AND redirect_map_id IS NULL"};
constexpr Statement kFindUnlisted{
    "looking for other prior maps in use",
    "SELECT o.prior_map_id FROM enfilade.prior_maps p JOIN enfilade.prior_maps o USING (site_id, level)"
    " WHERE p.site_id = $1 AND p.prior_map_id = $2 AND o.prior_map_id <> $2 AND o.state = 3 AND o.etag <> ALL ($3)"
    " ORDER BY o.prior_map_id LIMIT 1"};
constexpr Statement kFindTied{"looking for the maps that the prior map ties",
                              "SELECT coalesce(aligned_maps, '{}') FROM enfilade.prior_maps"
                              " WHERE site_id = $1 AND prior_map_id = $2 AND state = 3 AND ($3 = 0 OR etag = $3)"};
constexpr Statement kDeletePriorMap{"deleting the prior map",
                                    "DELETE FROM enfilade.prior_maps"
                                    " WHERE site_id = $1 AND prior_map_id = $2 AND ($3 = 0 OR etag = $3)"};
constexpr Statement kListPriorMapFiles{"listing the prior map's files",
                                       "SELECT product, name, size_bytes, sha256 FROM enfilade.prior_map_files"
                                       " WHERE site_id = $1 AND prior_map_id = $2 ORDER BY product, name"};

PriorMapFile ReadFile(Row& row) {
  PriorMapFile file;
  file.product = static_cast<PriorMapProduct>(row.Int16());
  file.name = row.Text();
  file.size = row.Int64();
  file.sha256 = row.Bytes();
  return file;
}

absl::Status Explain(const absl::Status& status, const SiteId& site, const PriorMapId& id,
                     const std::string& display_name) {
  if (postgres::ConstraintOf(status) == "prior_maps_site_id_display_name_key") {
    return AlreadyExists("{} has a prior map with the display name \"{}\" already", NameOf(site), display_name);
  }
  if (absl::IsAlreadyExists(status)) return AlreadyExists("{} exists already", NameOf(site, id));
  if (postgres::SqlStateOf(status) == "23503") return NotFound("{} does not exist", NameOf(site));
  return WithContext(status, NameOf(site, id));
}

// Locks the site's graph, before the prior map, and tells whether the graph has ties of the prior map.
absl::StatusOr<bool> LockUse(Transaction& transaction, const SiteId& site, const PriorMapId& id) {
  ENFILADE_RETURN_IF_ERROR(postgres::LockGraph(transaction, site).status());
  ENFILADE_ASSIGN_OR_RETURN(const auto in_use, transaction.Execute(kIsInUse, Params(site, id)));
  return postgres::ReadOne(
      in_use, [](Row& row) { return row.Int64() > 0; }, NameOf(site, id));
}

// The alignment without maps that were deleted since it was begun.
absl::StatusOr<PriorMapAlignment> OfPresentMaps(Transaction& transaction, const SiteId& site,
                                                PriorMapAlignment alignment, const std::vector<TimeNs>& created) {
  std::vector<std::string_view> ids;
  for (const MapId& map : alignment.maps) ids.emplace_back(map.value());
  ENFILADE_ASSIGN_OR_RETURN(const auto result, transaction.Execute(kSelectMapTimes, Params(site, ids)));
  ENFILADE_ASSIGN_OR_RETURN(const auto present, postgres::ReadRows(result, [](Row& row) {
                              MapId map{std::string(row.Text())};
                              return std::pair(std::move(map), row.Time());
                            }));
  const std::vector<MapId> maps = std::exchange(alignment.maps, {});
  for (std::size_t i = 0; i < std::min(maps.size(), created.size()); ++i) {
    const bool is_there = std::find(present.begin(), present.end(), std::pair(maps[i], created[i])) != present.end();
    if (is_there) alignment.maps.push_back(maps[i]);
  }
  std::erase_if(alignment.joined_maps, [&](const MapId& map) {
    return std::find(alignment.maps.begin(), alignment.maps.end(), map) == alignment.maps.end();
  });
  return alignment;
}

// Others may have been put to use since the caller has looked.
absl::Status CheckBeside(Transaction& transaction, const SiteId& site, const PriorMapId& id,
                         const std::vector<std::int64_t>& beside) {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kFindUnlisted, Params(site, id, beside)));
  if (found.rows() == 0) return absl::OkStatus();
  ENFILADE_ASSIGN_OR_RETURN(const PriorMapId other,
                            postgres::ReadOne(
                                found, [](Row& row) { return PriorMapId(std::string(row.Text())); }, NameOf(site, id)));
  return Aborted("{} was put to use or changed at the same time: try again", NameOf(site, other));
}

// Of one that is in use.
absl::Status CheckUnused(Transaction& transaction, const SiteId& site, const PriorMapId& id, std::int64_t etag) {
  ENFILADE_ASSIGN_OR_RETURN(const auto found, transaction.Execute(kFindTied, Params(site, id, etag)));
  if (found.rows() == 0) return absl::OkStatus();  // the etag is stale
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<std::string> maps,
                            postgres::ReadOne(
                                found, [](Row& row) { return row.OptionalTexts(); }, NameOf(site, id)));
  constexpr std::size_t kMostNamed = 5;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < std::min(maps.size(), kMostNamed); ++i) names.push_back(NameOf(site, MapId(maps[i])));
  const std::string others =
      maps.size() > kMostNamed ? fmt::format(" and {} more", maps.size() - kMostNamed) : std::string();
  return FailedPrecondition("{} is in use: it ties {}{}. Suspend it first, or set force", NameOf(site, id),
                            fmt::join(names, ", "), others);
}

absl::Status RaiseVersion(Transaction& transaction, const SiteId& site, const PriorMapId& id) {
  return postgres::RaiseGraphVersion(transaction, site, GraphCause::kPriorMapChanged, "priorMaps/" + id.value())
      .status();
}

// Files with the digests of their bytes, which they outlive not.
class FilesToStore {
 public:
  explicit FilesToStore(const std::vector<NewPriorMapFile>& files) : files_(files) {
    for (const NewPriorMapFile& file : files) digests_.push_back(Sha256(file.bytes));
  }

  std::vector<BlobView> blobs() const {
    std::vector<BlobView> blobs;
    for (std::size_t i = 0; i < files_.size(); ++i) blobs.push_back({digests_[i], files_[i].bytes});
    return blobs;
  }
  void Queue(Transaction& transaction, const SiteId& site, const PriorMapId& id) const {
    std::vector<std::int16_t> products;
    std::vector<std::string_view> names;
    std::vector<std::int64_t> sizes;
    std::vector<Bytes> digests;
    for (std::size_t i = 0; i < files_.size(); ++i) {
      products.push_back(static_cast<std::int16_t>(files_[i].product));
      names.emplace_back(files_[i].name);
      sizes.push_back(static_cast<std::int64_t>(files_[i].bytes.size()));
      digests.push_back(Bytes{digests_[i]});
    }
    transaction.Queue(kInsertPriorMapFiles, Params(site, id, products, names, sizes, digests));
  }

 private:
  const std::vector<NewPriorMapFile>& files_;
  std::vector<std::string> digests_;
};

}  // namespace

absl::StatusOr<PriorMap> PriorMapStore::Create(const CallContext& context, const PriorMap& map,
                                               const std::vector<NewPriorMapFile>& files) const {
  const FilesToStore to_store(files);
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(to_store.blobs()));
  const std::vector<std::string_view> warnings(map.warnings.begin(), map.warnings.end());
  const PriorMapElements& elements = map.elements;
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  const auto inserted = transaction.Execute(
      kInsertPriorMap, Params(map.site, map.id, map.display_name, std::int32_t{map.level},
                              static_cast<std::int16_t>(PriorMapState::kNew), map.reason, map.file_name, warnings,
                              std::int32_t{elements.walls}, std::int32_t{elements.corners},
                              std::int32_t{elements.doors}, std::int32_t{elements.rooms}, std::int32_t{elements.shafts},
                              elements.metres_per_unit, postgres::NewEtag()));
  if (!inserted.ok()) return Explain(inserted.status(), map.site, map.id, map.display_name);
  postgres::QueueBlobs(transaction, map.site, to_store.blobs());
  to_store.Queue(transaction, map.site, map.id);
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), NameOf(map.site, map.id)));
  return postgres::ReadOne(*inserted, postgres::ReadPriorMap, NameOf(map.site, map.id));
}

absl::StatusOr<PriorMap> PriorMapStore::Get(const CallContext& context, const SiteId& site,
                                            const PriorMapId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kSelectPriorMap, Params(site, id)));
  return postgres::ReadOne(result, postgres::ReadPriorMap, NameOf(site, id));
}

absl::StatusOr<std::vector<PriorMap>> PriorMapStore::List(const CallContext& context, const SiteId& site,
                                                          const PageRequest& page) const {
  ENFILADE_ASSIGN_OR_RETURN(
      const auto result,
      ExecuteAlone(pool_, context, kListPriorMaps, Params(site, page.after, static_cast<std::int64_t>(page.limit))));
  return postgres::ReadRows(result, postgres::ReadPriorMap);
}

absl::StatusOr<std::vector<PriorMap>> PriorMapStore::ListOutgrown(const CallContext& context, std::chrono::seconds age,
                                                                  std::int64_t limit) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kListOutgrown,
                                                            Params(static_cast<std::int64_t>(age.count()), limit)));
  return postgres::ReadRows(result, postgres::ReadPriorMap);
}

absl::StatusOr<PriorMap> PriorMapStore::Rename(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                               std::int64_t etag, const std::string& display_name) const {
  const auto updated =
      ExecuteAlone(pool_, context, kRenamePriorMap, Params(site, id, etag, postgres::NewEtag(), display_name));
  if (!updated.ok()) return Explain(updated.status(), site, id, display_name);
  if (updated->rows() > 0) return postgres::ReadOne(*updated, postgres::ReadPriorMap, NameOf(site, id));
  ENFILADE_RETURN_IF_ERROR(Get(context, site, id).status());
  return postgres::StaleEtag(NameOf(site, id));
}

absl::StatusOr<PriorMap> PriorMapStore::SetOutcome(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                                   std::int64_t etag, const PriorMapOutcome& outcome) const {
  const std::string name = NameOf(site, id);
  const FilesToStore to_store(outcome.files);
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(to_store.blobs()));
  const auto state = static_cast<std::int16_t>(outcome.state);
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const bool was_in_use, LockUse(transaction, site, id));
  if (outcome.state == PriorMapState::kActive && outcome.beside) {
    ENFILADE_RETURN_IF_ERROR(CheckBeside(transaction, site, id, *outcome.beside));
  }
  absl::StatusOr<postgres::Result> updated = absl::UnknownError("");
  if (outcome.alignment) {
    PriorMapAlignment alignment = *outcome.alignment;
    if (outcome.map_create_times) {
      ENFILADE_ASSIGN_OR_RETURN(alignment,
                                OfPresentMaps(transaction, site, std::move(alignment), *outcome.map_create_times));
    }
    const Eigen::Matrix2d& linear = alignment.T_world_sheet.linear;
    const Eigen::Vector2d& offset = alignment.T_world_sheet.offset;
    const std::vector<double> affine{linear(0, 0), linear(0, 1), offset.x(), linear(1, 0), linear(1, 1), offset.y()};
    std::vector<std::string_view> maps, joined_maps, pair_maps;
    std::vector<double> points;
    for (const MapId& map : alignment.maps) maps.emplace_back(map.value());
    for (const MapId& map : alignment.joined_maps) joined_maps.emplace_back(map.value());
    for (const PriorMapPair& pair : alignment.pairs) {
      pair_maps.emplace_back(pair.map.value());
      points.insert(points.end(), {pair.point_sheet.x(), pair.point_sheet.y(), pair.point_map.x(), pair.point_map.y()});
    }
    updated = transaction.Execute(
        kSetPriorMapAlignment,
        Params(site, id, etag, postgres::NewEtag(), state, outcome.reason, affine,
               static_cast<std::int16_t>(static_cast<int>(alignment.model) + 1), alignment.explained,
               alignment.contradicted, alignment.rival_ratio, maps, alignment.graph_version, pair_maps, points,
               std::int32_t{alignment.tied_walls}, joined_maps));
  } else {
    updated =
        transaction.Execute(kSetPriorMapState, Params(site, id, etag, postgres::NewEtag(), state, outcome.reason));
  }
  if (!updated.ok()) return WithContext(updated.status(), name);
  if (updated->rows() == 0) {
    ENFILADE_RETURN_IF_ERROR(Get(context, site, id).status());
    return postgres::StaleEtag(name);
  }
  if (outcome.alignment) {
    transaction.Queue(kDeleteFilesFrom, Params(site, id, static_cast<std::int16_t>(PriorMapProduct::kCorrected)));
    postgres::QueueBlobs(transaction, site, to_store.blobs());
    to_store.Queue(transaction, site, id);
  }
  if (was_in_use || outcome.state == PriorMapState::kActive) {
    ENFILADE_RETURN_IF_ERROR(RaiseVersion(transaction, site, id));
  }
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), name));
  return postgres::ReadOne(*updated, postgres::ReadPriorMap, name);
}

absl::StatusOr<PriorMap> PriorMapStore::ReplacePlan(const CallContext& context, const SiteId& site,
                                                    const PriorMapId& id, std::int64_t etag,
                                                    const PriorMapElements& elements, const NewPriorMapFile& plan,
                                                    const std::string& reason) const {
  const std::string name = NameOf(site, id);
  const std::vector<NewPriorMapFile> files{plan};
  const FilesToStore to_store(files);
  ENFILADE_RETURN_IF_ERROR(ValidateBlobs(to_store.blobs()));
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const bool was_in_use, LockUse(transaction, site, id));
  const auto updated = transaction.Execute(
      kSetPriorMapElements,
      Params(site, id, etag, postgres::NewEtag(), static_cast<std::int16_t>(PriorMapState::kNew), reason,
             std::int32_t{elements.walls}, std::int32_t{elements.corners}, std::int32_t{elements.doors},
             std::int32_t{elements.rooms}, std::int32_t{elements.shafts}, elements.metres_per_unit));
  if (!updated.ok()) return WithContext(updated.status(), name);
  if (updated->rows() == 0) {
    ENFILADE_RETURN_IF_ERROR(Get(context, site, id).status());
    return postgres::StaleEtag(name);
  }
  transaction.Queue(kDeleteFilesFrom, Params(site, id, static_cast<std::int16_t>(PriorMapProduct::kPlan)));
  postgres::QueueBlobs(transaction, site, to_store.blobs());
  to_store.Queue(transaction, site, id);
  if (was_in_use) ENFILADE_RETURN_IF_ERROR(RaiseVersion(transaction, site, id));
  ENFILADE_RETURN_IF_ERROR(WithContext(transaction.Commit(), name));
  return postgres::ReadOne(*updated, postgres::ReadPriorMap, name);
}

absl::Status PriorMapStore::Delete(const CallContext& context, const SiteId& site, const PriorMapId& id,
                                   std::int64_t etag, bool force) const {
  ENFILADE_ASSIGN_OR_RETURN(Transaction transaction, Transaction::Begin(pool_, context));
  ENFILADE_ASSIGN_OR_RETURN(const bool was_in_use, LockUse(transaction, site, id));
  if (was_in_use && !force) ENFILADE_RETURN_IF_ERROR(CheckUnused(transaction, site, id, etag));
  const auto deleted = transaction.Execute(kDeletePriorMap, Params(site, id, etag));
  if (!deleted.ok()) return WithContext(deleted.status(), NameOf(site, id));
  if (deleted->affected() > 0) {
    if (was_in_use) ENFILADE_RETURN_IF_ERROR(RaiseVersion(transaction, site, id));
    return WithContext(transaction.Commit(), NameOf(site, id));
  }
  ENFILADE_RETURN_IF_ERROR(Get(context, site, id).status());
  return postgres::StaleEtag(NameOf(site, id));
}

absl::StatusOr<std::vector<PriorMapFile>> PriorMapStore::ListFiles(const CallContext& context, const SiteId& site,
                                                                   const PriorMapId& id) const {
  ENFILADE_ASSIGN_OR_RETURN(const auto result, ExecuteAlone(pool_, context, kListPriorMapFiles, Params(site, id)));
  return postgres::ReadRows(result, ReadFile);
}

}  // namespace enfilade::storage

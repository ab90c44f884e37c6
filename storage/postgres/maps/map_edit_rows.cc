// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/maps/map_edit_rows.h"

#include <string_view>
#include <utility>

#include "core/base/resource_name.h"
#include "storage/postgres/driver/etag.h"
#include "storage/postgres/driver/rows.h"
#include "storage/postgres/maps/overlay_rows.h"

namespace enfilade::storage::postgres {
namespace {

constexpr Statement kSelectDraft{"reading the draft", "SELECT " ENFILADE_DRAFT_COLUMNS
                                                      " FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2"
                                                      " AND draft_id = $3"};
constexpr Statement kSelectRedirect{
    "looking where the map is",
    "SELECT redirect_map_id FROM enfilade.maps WHERE site_id = $1 AND map_id = $2 AND redirect_map_id IS NOT NULL"};
constexpr Statement kLockRedirect{
    "looking where the map is",
    "WITH m AS MATERIALIZED (SELECT redirect_map_id FROM enfilade.maps WHERE site_id = $1 AND map_id = $2"
    "   FOR KEY SHARE) SELECT redirect_map_id FROM m WHERE redirect_map_id IS NOT NULL"};
constexpr Statement kInsertDraft{
    "creating the draft",
    "INSERT INTO enfilade.map_drafts (site_id, map_id, draft_id, display_name, author, base_edit_version, resolution,"
    " origin_x, origin_y, origin_yaw, etag) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11)"
    " RETURNING " ENFILADE_DRAFT_COLUMNS};
constexpr Statement kLockDraft{"locking the draft", "SELECT " ENFILADE_DRAFT_COLUMNS
                                                    " FROM enfilade.map_drafts WHERE site_id = $1 AND map_id = $2"
                                                    " AND draft_id = $3 FOR UPDATE"};
// Those that the draft has already leave gaps in the sequence. The draft grows if there is a new one.
constexpr Statement kInsertEdits{
    "storing edits",
    "WITH new AS (INSERT INTO enfilade.map_edits (site_id, map_id, draft_id, sequence, edit_id, author, head, "
    "instruction,"
    " invisible, shape) SELECT $1, $2, $3, d.next_sequence + row_number() OVER (ORDER BY u.place) - 1, u.edit_id,"
    " u.author, $4, u.instruction, u.invisible = 1, u.shape FROM enfilade.map_drafts d,"
    " unnest($5::text[], $6::text[], $7::smallint[], $8::smallint[], $9::bytea[])"
    "   WITH ORDINALITY u (edit_id, author, instruction, invisible, shape, place)"
    " WHERE (d.site_id, d.map_id, d.draft_id) = ($1, $2, $3)"
    " ON CONFLICT (site_id, map_id, draft_id, edit_id) DO NOTHING RETURNING sequence),"
    " counted AS (SELECT count(*) AS edits FROM new)"
    " UPDATE enfilade.map_drafts d SET head = $4, next_sequence = d.next_sequence + cardinality($5),"
    " active_edits = d.active_edits + counted.edits FROM counted"
    " WHERE (d.site_id, d.map_id, d.draft_id) = ($1, $2, $3) AND counted.edits > 0 RETURNING d.next_sequence"};
constexpr Statement kPublishDraft{
    "publishing the draft",
    "UPDATE enfilade.map_drafts SET publish_time = now(), edit_version = $4, revision = $5, message = $6, etag = $7"
    " WHERE site_id = $1 AND map_id = $2 AND draft_id = $3 RETURNING " ENFILADE_DRAFT_COLUMNS};
constexpr Statement kTakeTime{
    "publishing the edits of a merged map",
    "UPDATE enfilade.map_drafts d SET publish_time = o.publish_time FROM enfilade.map_drafts o"
    " WHERE d.site_id = $1 AND d.map_id = $2 AND d.draft_id = $3"
    " AND o.site_id = $1 AND o.map_id = $4 AND o.edit_version = $5"};
#define ENFILADE_EDIT_COLUMNS \
  "e.edit_id, e.author, e.sequence, e.active, e.instruction, e.invisible, e.shape, e.head, e.create_time"
constexpr Statement kListEdits{"listing edits", "SELECT " ENFILADE_EDIT_COLUMNS
                                                " FROM enfilade.map_edits e WHERE site_id = $1 AND map_id = $2"
                                                " AND draft_id = $3 AND (head, sequence) > ($4, $5)"
                                                " ORDER BY head, sequence LIMIT $6"};
constexpr Statement kSelectPublications{
    "reading published edits",
    "SELECT " ENFILADE_EDIT_COLUMNS
    ", d.edit_version, d.message, d.resolution, d.origin_x, d.origin_y, d.origin_yaw FROM enfilade.map_drafts d"
    " JOIN enfilade.map_edits e ON (e.site_id, e.map_id, e.draft_id) = (d.site_id, d.map_id, d.draft_id) AND e.active"
    " WHERE d.site_id = $1 AND d.map_id = $2 AND d.edit_version > $3 AND d.edit_version <= $4"
    " ORDER BY d.edit_version, e.sequence"};
constexpr Statement kSelectWitnesses{
    "reading the layers of later sessions",
    "WITH l AS MATERIALIZED (SELECT position, session_id, revision, raster_header, edit_version"
    "   FROM enfilade.map_layers WHERE site_id = $1 AND map_id = $2 AND session_id IS NOT NULL AND edit_version > 0)"
    " SELECT l.position, l.session_id, l.edit_version, coalesce(l.raster_header, r.raster_header), NULL::bigint,"
    "   NULL::bigint, NULL::bytea FROM l LEFT JOIN enfilade.map_revisions r"
    "   ON r.site_id = $1 AND r.map_id = $2 AND r.revision = l.revision"
    " UNION ALL SELECT l.position, NULL, 0, NULL, t.tile_row, t.tile_column, t.sha256 FROM l"
    "   JOIN enfilade.map_layer_tiles t ON t.site_id = $1 AND t.map_id = $2 AND t.position = l.position"
    " UNION ALL SELECT l.position, NULL, 0, NULL, t.tile_row, t.tile_column, t.sha256 FROM l"
    "   JOIN enfilade.map_revision_tiles t ON t.site_id = $1 AND t.map_id = $2 AND t.revision = l.revision"
    " ORDER BY 1, 5 NULLS FIRST, 6"};

absl::StatusOr<StoredMapEdit> ReadEdit(Row& row) {
  StoredMapEdit edit;
  edit.kept.id = row.Text();
  edit.kept.author = row.Text();
  edit.kept.sequence = row.Int64();
  edit.kept.active = row.Bool();
  edit.kept.edit.instruction = static_cast<edit::Instruction>(row.Int16());
  edit.kept.edit.invisible = row.Bool();
  const std::string_view shape = row.Bytes();
  edit.head = row.Int64();
  edit.create_time = row.Time();
  ENFILADE_RETURN_IF_ERROR(row.status());
  ENFILADE_ASSIGN_OR_RETURN(edit.kept.edit.shape, edit::DecodeShape(shape));
  return edit;
}

// A tile's place and digest, if the row has one.
std::optional<TileRef> ReadTileOf(Row& row) {
  const auto tile_row = row.OptionalInt64();
  const auto tile_column = row.OptionalInt64();
  const auto sha256 = row.OptionalBytes();
  if (!sha256) return std::nullopt;
  return TileRef{{static_cast<int>(tile_row.value_or(0)), static_cast<int>(tile_column.value_or(0))},
                 std::string(*sha256)};
}

}  // namespace

MapDraft ReadDraft(Row& row) {
  MapDraft draft;
  draft.key.site = SiteId(std::string(row.Text()));
  draft.key.map = MapId(std::string(row.Text()));
  draft.key.draft = MapDraftId(std::string(row.Text()));
  draft.display_name = row.Text();
  draft.author = row.Text();
  draft.base_edit_version = row.Int64();
  draft.lattice = ReadLattice(row);
  draft.head = row.Int64();
  draft.active_edits = row.Int64();
  draft.etag = row.Int64();
  draft.create_time = row.Time();
  const std::optional<TimeNs> published = row.OptionalTime();
  MapDraft::Published publication;
  publication.time = published.value_or(0);
  publication.edit_version = row.Int64();
  publication.revision = row.Int64();
  publication.message = row.Text();
  if (published) draft.published = std::move(publication);
  draft.first_version = row.Int64();
  return draft;
}

std::string NameOfDraft(const MapDraftKey& key) { return NameOf(key.site, key.map, key.draft); }

absl::Status MissingDraft(const Result& redirect, const MapDraftKey& key) {
  if (redirect.rows() == 0) return NotFound("{} does not exist", NameOfDraft(key));
  Row row(redirect, 0);
  const MapId into{std::string(row.Text())};
  ENFILADE_RETURN_IF_ERROR(row.status());
  return NotFound("{} does not exist: {} was merged into {}, and its drafts with it", NameOfDraft(key),
                  NameOf(key.site, key.map), NameOf(key.site, into));
}

absl::StatusOr<MapDraft> InsertDraft(Transaction& transaction, const MapDraft& draft) {
  const auto& [site, map, id] = draft.key;
  // Waits while the map is being merged.
  ENFILADE_ASSIGN_OR_RETURN(const Result redirect, transaction.Execute(kLockRedirect, Params(site, map)));
  if (redirect.rows() > 0) return MissingDraft(redirect, draft.key);
  const Pose2& origin = draft.lattice.T_map_lattice;
  ENFILADE_ASSIGN_OR_RETURN(
      const Result result,
      transaction.Execute(kInsertDraft, Params(site, map, id, draft.display_name, draft.author, draft.base_edit_version,
                                               draft.lattice.resolution, origin.x, origin.y, origin.yaw, NewEtag())));
  return ReadOne(result, ReadDraft, NameOfDraft(draft.key));
}

absl::StatusOr<MapDraft> LockDraft(Transaction& transaction, const MapDraftKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result, transaction.Execute(kLockDraft, Params(key.site, key.map, key.draft)));
  if (result.rows() > 0) return ReadOne(result, ReadDraft, NameOfDraft(key));
  ENFILADE_ASSIGN_OR_RETURN(const Result redirect, transaction.Execute(kSelectRedirect, Params(key.site, key.map)));
  return MissingDraft(redirect, key);
}

absl::StatusOr<MapDraft> ReadDraftOf(Pool& pool, const CallContext& context, const MapDraftKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectDraft, Params(key.site, key.map, key.draft)));
  if (result.rows() > 0) return ReadOne(result, ReadDraft, NameOfDraft(key));
  ENFILADE_ASSIGN_OR_RETURN(const Result redirect,
                            ExecuteAlone(pool, context, kSelectRedirect, Params(key.site, key.map)));
  return MissingDraft(redirect, key);
}

absl::StatusOr<std::int64_t> InsertEdits(Transaction& transaction, const MapDraft& draft,
                                         absl::Span<const NewMapEdit> edits) {
  const auto& [site, map, id] = draft.key;
  std::vector<std::string_view> ids, authors;
  std::vector<std::int16_t> instructions, invisible;
  std::vector<std::string> shapes;
  for (const NewMapEdit& edit : edits) {
    ids.emplace_back(edit.id);
    authors.emplace_back(edit.author);
    instructions.push_back(static_cast<std::int16_t>(edit.edit.instruction));
    invisible.push_back(edit.edit.invisible ? 1 : 0);
    shapes.push_back(edit::Encode(edit.edit.shape));
  }
  const std::vector<Bytes> views = [&] {
    std::vector<Bytes> bytes;
    for (const std::string& shape : shapes) bytes.push_back(Bytes{shape});
    return bytes;
  }();
  const std::int64_t head = draft.head + 1;
  ENFILADE_ASSIGN_OR_RETURN(
      const Result grown,
      transaction.Execute(kInsertEdits, Params(site, map, id, head, ids, authors, instructions, invisible, views)));
  if (grown.rows() == 0) return draft.head;
  ENFILADE_ASSIGN_OR_RETURN(const std::int64_t next,
                            ReadOne(
                                grown, [](Row& row) { return row.Int64(); }, NameOfDraft(draft.key)));
  if (next > MapEditStore::kMaxEdits + 1) {
    return ResourceExhausted("{} would have more than {} edits: publish it, and go on in a new draft",
                             NameOfDraft(draft.key), MapEditStore::kMaxEdits);
  }
  return head;
}

void QueuePublished(Transaction& transaction, const MapDraftKey& key, std::int64_t edit_version, std::int64_t revision,
                    const std::string& message) {
  transaction.Queue(kPublishDraft, Params(key.site, key.map, key.draft, edit_version, revision, message, NewEtag()));
}

absl::Status AdoptPublication(Transaction& transaction, const AdoptedPublication& adopted, std::int64_t revision) {
  const MapDraftKey& key = adopted.draft.key;
  ENFILADE_ASSIGN_OR_RETURN(const MapDraft draft, InsertDraft(transaction, adopted.draft));
  ENFILADE_RETURN_IF_ERROR(InsertEdits(transaction, draft, adopted.edits).status());
  QueuePublished(transaction, key, adopted.edit_version, revision, adopted.message);
  transaction.Queue(kTakeTime, Params(key.site, key.map, key.draft, adopted.from, adopted.from_version));
  return absl::OkStatus();
}

absl::StatusOr<std::vector<StoredMapEdit>> ReadEdits(Pool& pool, const CallContext& context, const MapDraft& draft,
                                                     std::int64_t after_head, std::int64_t after_sequence, int limit) {
  const auto& [site, map, id] = draft.key;
  ENFILADE_ASSIGN_OR_RETURN(
      const Result result,
      ExecuteAlone(pool, context, kListEdits, Params(site, map, id, after_head, after_sequence, std::int64_t{limit})));
  std::vector<StoredMapEdit> edits;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    ENFILADE_ASSIGN_OR_RETURN(StoredMapEdit edit, ReadEdit(row));
    edit.kept.lattice = draft.lattice;
    edits.push_back(std::move(edit));
  }
  return edits;
}

absl::StatusOr<std::vector<edit::Publication>> ReadPublicationRows(Pool& pool, const CallContext& context,
                                                                   const MapKey& key, std::int64_t after,
                                                                   std::int64_t up_to) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectPublications, Params(key.site, key.map, after, up_to)));
  std::vector<edit::Publication> publications;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    ENFILADE_ASSIGN_OR_RETURN(StoredMapEdit edit, ReadEdit(row));
    const std::int64_t version = row.Int64();
    const std::string_view message = row.Text();
    edit.kept.lattice = ReadLattice(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (publications.empty() || publications.back().edit_version != version) {
      publications.push_back({version, std::string(message), {}});
    }
    publications.back().edits.push_back(std::move(edit.kept));
  }
  return publications;
}

absl::StatusOr<std::vector<LayerWitness>> ReadWitnessRows(Pool& pool, const CallContext& context, const MapKey& key) {
  ENFILADE_ASSIGN_OR_RETURN(const Result result,
                            ExecuteAlone(pool, context, kSelectWitnesses, Params(key.site, key.map)));
  std::vector<LayerWitness> witnesses;
  for (int i = 0; i < result.rows(); ++i) {
    Row row(result, i);
    row.Int64();  // the layer's position, by which the rows are ordered
    const auto session = row.OptionalText();
    const std::int64_t edit_version = row.Int64();
    const auto header = row.OptionalBytes();
    auto tile = ReadTileOf(row);
    ENFILADE_RETURN_IF_ERROR(row.status());
    if (session) {
      LayerWitness& witness = witnesses.emplace_back();
      witness.session = SessionId(std::string(*session));
      witness.edit_version = edit_version;
      witness.raster.header = header.value_or("");
    } else if (tile && !witnesses.empty()) {
      witnesses.back().raster.tiles.push_back(*std::move(tile));
    }
  }
  return witnesses;
}

}  // namespace enfilade::storage::postgres

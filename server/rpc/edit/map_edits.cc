// SPDX-License-Identifier: Apache-2.0
#include <charconv>
#include <cstdlib>
#include <limits>
#include <set>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/edit/convert.h"
#include "server/rpc/edit/handlers.h"
#include "server/rpc/paging.h"

namespace enfilade::server {
namespace {

constexpr int kMaxAppended = 100;
constexpr int kMaxSwitched = 1000;
constexpr int kMaxTiles = 16;
constexpr int kMaxTileIndex = 1 << 13;  // of coordinates of edits

template <typename Response>
Response AnswerOf(const DraftChange& change) {
  Response response;
  response.set_head(change.head);
  for (const storage::StoredMapEdit& edit : change.edits) *response.add_edits() = ToProto(edit);
  for (const ChangedTile& tile : change.tiles) *response.add_tiles() = ToProto(tile);
  return response;
}

// Pages go on after an edit: "head-sequence".
struct EditPlace {
  std::int64_t head = 0;
  std::int64_t sequence = 0;
};

absl::StatusOr<EditPlace> PlaceOf(const std::string& token, std::int64_t after_head) {
  if (token.empty()) return EditPlace{after_head, std::numeric_limits<std::int64_t>::max()};
  EditPlace place;
  const char* const end = token.data() + token.size();
  const auto head = std::from_chars(token.data(), end, place.head);
  if (head.ec == std::errc() && head.ptr != end && *head.ptr == '-') {
    const auto sequence = std::from_chars(head.ptr + 1, end, place.sequence);
    if (sequence.ec == std::errc() && sequence.ptr == end) return place;
  }
  return InvalidArgument("page_token is not from this server");
}

}  // namespace

absl::StatusOr<v1::AppendMapEditsResponse> AppendMapEdits(const Services& services, const Call& call,
                                                          const v1::AppendMapEditsRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  if (request.edits_size() > kMaxAppended) {
    return InvalidArgument("edits has {} edits: at most {}", request.edits_size(), kMaxAppended);
  }
  ENFILADE_ASSIGN_OR_RETURN(const std::string author, AuthorOr("", "", call));
  std::vector<DrawnEdit> edits;
  std::set<std::string> ids;
  for (int i = 0; i < request.edits_size(); ++i) {
    const std::string field = fmt::format("edits[{}]", i);
    ENFILADE_ASSIGN_OR_RETURN(DrawnEdit drawn, server::FromProto(field, request.edits(i), author));
    if (!ids.insert(drawn.id).second) return InvalidArgument("{}.edit_id {} is given twice", field, drawn.id);
    edits.push_back(std::move(drawn));
  }
  ENFILADE_ASSIGN_OR_RETURN(const DraftChange change,
                            services.map_edits.Append(call.context(), KeyOf(name), edits, request.known_head()));
  return AnswerOf<v1::AppendMapEditsResponse>(change);
}

absl::StatusOr<v1::SetMapEditsActiveResponse> SetMapEditsActive(const Services& services, const Call& call,
                                                                const v1::SetMapEditsActiveRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  if (request.edit_ids_size() > kMaxSwitched) {
    return InvalidArgument("edit_ids has {} ids: at most {}", request.edit_ids_size(), kMaxSwitched);
  }
  std::optional<std::string> author;
  if (!request.others()) {
    ENFILADE_ASSIGN_OR_RETURN(author, AuthorOr("author", request.author(), call));
  }
  const std::vector<std::string> ids(request.edit_ids().begin(), request.edit_ids().end());
  ENFILADE_ASSIGN_OR_RETURN(
      const DraftChange change,
      services.map_edits.SetActive(call.context(), KeyOf(name), ids, request.active(), author, request.known_head()));
  return AnswerOf<v1::SetMapEditsActiveResponse>(change);
}

absl::StatusOr<v1::ListMapEditsResponse> ListMapEdits(const Services& services, const Call& call,
                                                      const v1::ListMapEditsRequest& request) {
  v1::ListMapEditsResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(const int size, PageSize(request.page_size()));
  ENFILADE_ASSIGN_OR_RETURN(const std::string token, FromPageToken(request.page_token()));
  ENFILADE_ASSIGN_OR_RETURN(const EditPlace after, PlaceOf(token, request.after_head()));
  ENFILADE_ASSIGN_OR_RETURN(const storage::MapDraft draft, services.map_edit_store.Get(call.context(), KeyOf(name)));
  ENFILADE_ASSIGN_OR_RETURN(
      auto edits, services.map_edit_store.ListEdits(call.context(), draft, after.head, after.sequence, size + 1));
  if (CutToPage(edits, size)) {
    response.set_next_page_token(ToPageToken(fmt::format("{}-{}", edits.back().head, edits.back().kept.sequence)));
  }
  for (const storage::StoredMapEdit& edit : edits) *response.add_edits() = ToProto(edit);
  return response;
}

absl::StatusOr<v1::ReadMapDraftTilesResponse> ReadMapDraftTiles(const Services& services, const Call& call,
                                                                const v1::ReadMapDraftTilesRequest& request) {
  v1::ReadMapDraftTilesResponse response;
  ENFILADE_ASSIGN_OR_RETURN(const auto name, convert::ParseMapDraftName("name", request.name()));
  if (request.tiles_size() > kMaxTiles) {
    return InvalidArgument("tiles has {} tiles: at most {}", request.tiles_size(), kMaxTiles);
  }
  std::vector<grid::TileIndex> wanted;
  for (const v1::TilePosition& tile : request.tiles()) {
    if (std::abs(std::int64_t{tile.row()}) > kMaxTileIndex || std::abs(std::int64_t{tile.column()}) > kMaxTileIndex) {
      return InvalidArgument("tiles: ({}, {}) is beyond what can be edited", tile.row(), tile.column());
    }
    wanted.push_back({tile.row(), tile.column()});
  }
  ENFILADE_ASSIGN_OR_RETURN(DraftTiles tiles, services.map_edits.ReadTiles(call.context(), KeyOf(name), wanted));
  response.set_head(tiles.head);
  *response.mutable_box() = ToProto(tiles.box);
  for (DraftTile& tile : tiles.tiles) {
    v1::MapDraftTile& out = *response.add_tiles();
    out.set_row(tile.index.row);
    out.set_column(tile.index.column);
    out.set_cells(std::move(tile.cells));
  }
  for (const grid::TileIndex& index : tiles.known) {
    v1::TilePosition& out = *response.add_known_tiles();
    out.set_row(index.row);
    out.set_column(index.column);
  }
  return response;
}

}  // namespace enfilade::server

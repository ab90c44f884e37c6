// SPDX-License-Identifier: Apache-2.0
#include "client/sources/imports/map_manager_database.h"

#include <cmath>
#include <filesystem>
#include <set>

#include "client/sdk/spool/sqlite.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"

namespace enfilade::sources {
namespace {

using client::SqliteDatabase;
using client::SqliteStatement;

constexpr char kMaps[] = "SELECT MAP_ID, NAME, INDOOR FROM MAPS ORDER BY MAP_ID";
constexpr char kLinkPoints[] =
    "SELECT ID, TAG, DIFFICULTY, ENVIRONMENT, IMAGE_REAR, MAP_ID_0, POS_X_0, POS_Y_0, THETA_0, MAP_ID_1, POS_X_1,"
    " POS_Y_1, THETA_1, DIRECTION, IMAGE_FRONT FROM LINKPOINTS ORDER BY ID";
constexpr char kCandidates[] =
    "SELECT ID, '', DIFFICULTY, ENVIRONMENT, IMAGE, MAP_ID, POS_X, POS_Y, THETA, POINTCLOUD_PATH"
    " FROM LINKPOINTCANDIDATES ORDER BY ID";

// Why a row is not imported; nullopt: it is.
using Refusal = std::optional<std::string>;

std::optional<std::int64_t> IntegerAt(const SqliteStatement& row, int column) {
  const std::optional<double> number = row.Number(column);
  if (!number || *number != std::floor(*number) || std::abs(*number) > 1e15) return std::nullopt;
  return row.Int(column);
}

Refusal ReadAnchor(const SqliteStatement& row, int column, const std::set<std::int64_t>& maps, MapManagerPlace& place) {
  const auto map = IntegerAt(row, column);
  if (!map) return "its map's id is not a number";
  if (!maps.contains(*map)) return fmt::format("its map {} is not in MAPS", *map);
  const auto x = row.Number(column + 1), y = row.Number(column + 2), theta = row.Number(column + 3);
  if (!x || !y || !theta) return fmt::format("its pose in map {} has values that are not numbers", *map);
  const Pose2 pose{*x, *y, WrapAngle(*theta)};
  if (!IsFinite(pose)) return fmt::format("its pose in map {} is not finite", *map);
  for (const MapManagerPlace::Anchor& anchor : place.anchors) {
    if (anchor.map == *map) return fmt::format("it joins the map {} with itself", *map);
  }
  place.anchors.push_back({*map, pose});
  return std::nullopt;
}

class Reader {
 public:
  Reader(SqliteDatabase& database, const std::string& path)
      : database_(database), directory_(std::filesystem::path(path).parent_path()) {}

  absl::StatusOr<MapManagerContent> Read() {
    ENFILADE_RETURN_IF_ERROR(ForEachRow(kMaps, "MAPS", [this](const SqliteStatement& row) { return ReadMap(row); }));
    ENFILADE_RETURN_IF_ERROR(
        ForEachRow(kLinkPoints, "LINKPOINTS", [this](const SqliteStatement& row) { return ReadLinkPoint(row); }));
    ENFILADE_RETURN_IF_ERROR(ForEachRow(kCandidates, "LINKPOINTCANDIDATES",
                                        [this](const SqliteStatement& row) { return ReadCandidate(row); }));
    return std::move(content_);
  }

 private:
  template <typename ReadRow>
  absl::Status ForEachRow(const char* sql, const std::string& table, const ReadRow& read) {
    absl::StatusOr<SqliteStatement> statement = database_.Prepare(sql);
    if (!statement.ok() && statement.status().code() == absl::StatusCode::kInternal) {
      return InvalidArgument("{} is missing or has other columns than map_manager's: {}", table,
                             std::string(statement.status().message()));
    }
    ENFILADE_RETURN_IF_ERROR(statement.status());
    while (true) {
      ENFILADE_ASSIGN_OR_RETURN(const bool found, statement->Step());
      if (!found) return absl::OkStatus();
      row_name_ = fmt::format("{} {}", table, std::string(statement->Text(0)));
      if (const Refusal refusal = read(*statement)) content_.remarks.push_back({row_name_, true, *refusal});
    }
  }

  Refusal ReadMap(const SqliteStatement& row) {
    const auto id = IntegerAt(row, 0);
    if (!id) return "its id is not a number";
    if (!map_ids_.insert(*id).second) return "its id is used twice";
    content_.maps.push_back({*id, std::string(row.Text(1)), row.Int(2) != 0});
    return std::nullopt;
  }

  // The columns that both tables share: the first nine.
  Refusal ReadPlace(const SqliteStatement& row, MapManagerPlace& place) {
    const auto id = IntegerAt(row, 0);
    if (!id) return "its id is not a number";
    place.id = *id;
    place.tag = row.Text(1);
    place.difficulty = static_cast<int>(std::clamp<std::int64_t>(IntegerAt(row, 2).value_or(0), 0, 1'000'000));
    if (const auto environment = IntegerAt(row, 3)) place.indoor = *environment != 0;
    place.rear_image = row.Blob(4);
    return ReadAnchor(row, 5, map_ids_, place);
  }

  Refusal ReadLinkPoint(const SqliteStatement& row) {
    MapManagerPlace place;
    if (Refusal refusal = ReadPlace(row, place)) return refusal;
    if (!row.IsNull(9)) {
      if (Refusal refusal = ReadAnchor(row, 9, map_ids_, place)) return refusal;
    } else {
      Remark("it joins no second map: imported as a candidate");
    }
    place.front_image = row.Blob(14);
    if (const auto direction = IntegerAt(row, 13)) {
      for (const MapManagerPlace::Anchor& anchor : place.anchors) {
        if (anchor.map == *direction) place.direction = direction;
      }
      if (!place.direction) Remark(fmt::format("its direction {} is not one of its maps: left out", *direction));
    }
    content_.places.push_back(std::move(place));
    return std::nullopt;
  }

  Refusal ReadCandidate(const SqliteStatement& row) {
    MapManagerPlace place;
    place.candidate = true;
    if (Refusal refusal = ReadPlace(row, place)) return refusal;
    ReadCloud(std::string(row.Text(9)), place);
    content_.places.push_back(std::move(place));
    return std::nullopt;
  }

  // At the path in the row, or where map_manager stores it below the database's folder.
  void ReadCloud(const std::string& named, MapManagerPlace& place) {
    for (const std::filesystem::path& path :
         {directory_ / named, directory_ / "data" / "pointclouds" / fmt::format("{}_pointcloud.pcd", place.id)}) {
      std::error_code ignored;
      if (!std::filesystem::is_regular_file(path, ignored)) continue;  // a pipe or a device might never end
      place.cloud = io::ReadFile(path).value_or("");
      if (!place.cloud.empty()) return;
    }
    Remark(fmt::format("its point cloud \"{}\" is missing or empty: imported without it", named));
  }

  void Remark(std::string why) { content_.remarks.push_back({row_name_, false, std::move(why)}); }

  SqliteDatabase& database_;
  const std::filesystem::path directory_;
  MapManagerContent content_;
  std::set<std::int64_t> map_ids_;
  std::string row_name_;
};

}  // namespace

absl::StatusOr<MapManagerContent> ReadMapManagerDatabase(const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(SqliteDatabase database, SqliteDatabase::OpenToRead(path));
  return Reader(database, path).Read();
}

}  // namespace enfilade::sources

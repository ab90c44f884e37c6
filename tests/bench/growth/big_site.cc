// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/growth/big_site.h"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include "fmt/format.h"
#include "tests/support/command.h"

namespace enfilade::bench {
namespace {

// What triggers would write for each map and anchor is written at once; foreign keys and constraints hold as ever.
constexpr char kPopulate[] = R"(
BEGIN;
ALTER TABLE enfilade.maps DISABLE TRIGGER USER;
ALTER TABLE enfilade.link_points DISABLE TRIGGER USER;
ALTER TABLE enfilade.link_point_anchors DISABLE TRIGGER USER;
CREATE TEMP TABLE new_sites AS SELECT 'size-' || :maps || '-' || s AS id FROM generate_series(0, :sites - 1) s;
INSERT INTO enfilade.sites (site_id, display_name) SELECT id, id FROM new_sites;
INSERT INTO enfilade.maps (site_id, map_id, display_name, environment)
  SELECT s.id, 'room-' || i, 'room ' || i, 1 FROM new_sites s, generate_series(0, :maps - 1) i;
CREATE TEMP TABLE rooms AS SELECT i, i % :columns AS col, i / :columns AS row FROM generate_series(0, :maps - 1) i;
INSERT INTO enfilade.site_graphs (site_id, graph_version, root_map_id, cause, resource)
  SELECT id, 1, 'room-0', 1, 'maps/room-0' FROM new_sites;
INSERT INTO enfilade.graph_maps (site_id, map_id, changed_version, x, y, yaw, covariance)
  SELECT s.id, 'room-' || r.i, 1, r.col * :side, r.row * :side, 0,
    CASE r.i WHEN 0 THEN array_fill(0::float8, '{9}') ELSE '{0.01,0,0,0,0.01,0,0,0,0.001}' END
  FROM rooms r, new_sites s;
CREATE TEMP TABLE doors AS
  SELECT 'right-' || i AS id, i AS room, i + 1 AS next_room, 1 AS dx, 0 AS dy, col, row FROM rooms
    WHERE col < :columns - 1 AND i + 1 < :maps
  UNION ALL
  SELECT 'above-' || i, i, i + :columns, 0, 1, col, row FROM rooms WHERE i + :columns < :maps;
INSERT INTO enfilade.link_points (site_id, link_point_id, kind, anchor_count, levels, position, yaw, world_covariance,
    changed_version)
  SELECT s.id, d.id, 1, 2, '{[0,0]}', ST_MakePoint((col + dx / 2.0) * :side, (row + dy / 2.0) * :side), 0,
    '{0.01,0,0,0,0.01,0,0,0,0.001}', 1 FROM doors d, new_sites s;
INSERT INTO enfilade.link_point_anchors (site_id, link_point_id, map_id, ordinal, x, y, yaw, covariance)
  SELECT s.id, d.id, 'room-' || CASE n WHEN 1 THEN d.room ELSE d.next_room END, n,
    (3 - 2 * n) * dx * :side / 2.0, (3 - 2 * n) * dy * :side / 2.0, 0, '{0.003,0,0,0,0.003,0,0,0,0.003}'
  FROM doors d, new_sites s, (VALUES (1), (2)) o (n);
ALTER TABLE enfilade.maps ENABLE TRIGGER USER;
ALTER TABLE enfilade.link_points ENABLE TRIGGER USER;
ALTER TABLE enfilade.link_point_anchors ENABLE TRIGGER USER;
COMMIT;
VACUUM ANALYZE;
)";

int ColumnsOf(int maps) { return static_cast<int>(std::ceil(std::sqrt(static_cast<double>(maps)))); }

}  // namespace

RoomPlace PlaceOfRoom(int i, int maps) {
  const int columns = ColumnsOf(maps);
  return {kRoomSide * (i % columns), kRoomSide * (i / columns)};
}

void AddSites(BenchSystem& system, int sites, int maps) {
  const std::string file = (system.directory() / "populate.sql").string();
  std::ofstream(file) << kPopulate;
  system.server().Kill();
  const auto result =
      testing::RunCommand({"psql", system.database_url(), "-Xqv", "ON_ERROR_STOP=1", "-v", fmt::format("maps={}", maps),
                           "-v", fmt::format("sites={}", sites), "-v", fmt::format("columns={}", ColumnsOf(maps)), "-v",
                           fmt::format("side={}", kRoomSide), "-f", file});
  if (result.exit_code != 0) throw std::runtime_error(result.output);
  system.server().StartAndWait();
}

}  // namespace enfilade::bench

// SPDX-License-Identifier: Apache-2.0
// building.yaml of Open-RMF's traffic editor.
#include <algorithm>

#include "core/prior/formats/building_file.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {

std::vector<std::string> Seeds() {
  return {R"(name: house
levels:
  Upper:
    elevation: 4
    fiducials: [[100, 100, a], [300, 100, b]]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[100, 100, 0, ""], [300, 100, 0, ""], [300, 200, 0, ""], [100, 200, 0, ""]]
    walls: [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}]]
  Ground:
    elevation: 0
    doors: [[1, 2, {name: [1, "Door 'A'"], type: [1, hinged]}]]
    fiducials: [[0, 0, a], [100, 0, b]]
    floors: [{parameters: {}, vertices: [0, 1, 2, 3]}]
    measurements: [[0, 1, {distance: [3, 10]}]]
    vertices: [[0, 0, 0, ""], [100, 0, 0, ""], [100, 50, 0, ""], [0, 50, 0, ""]]
lifts:
  Lift:
    reference_floor_name: Ground
    x: 50
    y: 20
    yaw: 0.5
    width: 2
    depth: 1.5
    level_doors: {Ground: [d], Upper: [d]}
    doors: {d: {x: 0, y: -0.75, width: 1, motion_axis_orientation: 0}}
)"};
}

bool Decode(std::string_view bytes) {
  const auto building = prior::ParseBuilding(std::string(bytes));
  if (!building.ok()) return false;
  for (const prior::BuildingLevel& level : building->levels) {
    for (const prior::BuildingDoor& door : level.doors) Expect(IsFinite(door.T_level_door), "a door has a place");
    Expect(std::all_of(level.outline.begin(), level.outline.end(),
                       [](const Eigen::Vector2d& corner) { return corner.allFinite(); }),
           "an outline is finite");
    Expect(std::all_of(level.walls.begin(), level.walls.end(),
                       [](const prior::BuildingWall& wall) { return wall.a.allFinite() && wall.b.allFinite(); }),
           "walls are finite");
  }
  for (const prior::BuildingLift& lift : building->lifts) {
    for (const prior::BuildingLift::Stop& stop : lift.stops) {
      Expect(stop.level < building->levels.size(), "a lift stops at levels of the building");
      Expect(IsFinite(stop.T_level_cabin), "a stop has a place");
    }
  }
  return building->remarks.empty();
}

}  // namespace enfilade::fuzz

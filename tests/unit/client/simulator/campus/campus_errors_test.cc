// SPDX-License-Identifier: Apache-2.0
// What a campus file must not hold, each with the message that its author gets.
#include <gtest/gtest.h>

#include <string>

#include "client/simulator/campus/campus_yaml.h"
#include "tests/support/status_assertions.h"

namespace enfilade::simulator {
namespace {

struct CampusError {
  const char* name;
  const char* yaml;
  const char* message;
};

class CampusErrors : public ::testing::TestWithParam<CampusError> {};

TEST_P(CampusErrors, AreRefused) {
  EXPECT_STATUS(ParseCampus(GetParam().yaml), absl::StatusCode::kInvalidArgument,
                ::testing::HasSubstr(GetParam().message));
}

// One line each, so that "line 1" is where the error is.
INSTANTIATE_TEST_SUITE_P(
    Syntax, CampusErrors,
    ::testing::Values(
        CampusError{"Unclosed", "areas: [", "line "}, CampusError{"Empty", "", "the campus is not a mapping"},
        CampusError{"List", "- areas", "line 1: the campus is not a mapping"},
        CampusError{"UnknownKey", "{campus: x, area: []}", "line 1: the campus has no key \"area\""},
        CampusError{"UnknownKeyOfALaterLine", "campus: x\n\narea: []", "line 3: the campus has no key \"area\""},
        CampusError{"NameThatIsAList", "campus: [x]", "the campus.campus is not text"},
        CampusError{"AreasThatAreNoList", "areas: {id: a}", "the campus.areas is not a list"},
        CampusError{"AreaThatIsNoMapping", "areas: [a]", "area is not a mapping"},
        CampusError{"NegativeThickness", "wall_thickness: -0.1", "the campus.wall_thickness is -0.1: expected 0 to 2"},
        CampusError{"LowWalls", "wall_height: 0.1", "the campus.wall_height is 0.1: expected 0.5 to 50"},
        CampusError{"NegativeSeed", "texture_seed: -1", "the campus.texture_seed is not a whole number"},
        CampusError{"LevelsThatAreAList", "levels: [ground]", "levels is not a mapping"},
        CampusError{"LevelOutOfReach", "levels: {ground: 2000}", "levels.ground is 2000: expected -1000 to 1000"},
        CampusError{"TexturesThatAreAList", "textures: [t]", "textures is not a mapping"},
        CampusError{"TextureTooBright", "textures: {t: {brightness: 1.5}}",
                    "texture t.brightness is 1.5: expected 0 to 1"},
        CampusError{"TextureWithAnUnknownKey", "textures: {t: {colour: 1}}", "texture t has no key \"colour\""}),
    [](const auto& param) { return param.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Areas, CampusErrors,
    ::testing::Values(
        CampusError{"NoId", "areas: [{rect: [0, 0, 4, 4]}]", "area.id is missing"},
        CampusError{"NoShape", "areas: [{id: a}]", "area.rect is missing"},
        CampusError{"FlatRectangle", "areas: [{id: a, rect: [0, 0, 4, 0]}]", "width and height must be positive"},
        CampusError{"RectangleOfThree", "areas: [{id: a, rect: [0, 0, 4]}]", "area.rect: expected 4 numbers"},
        CampusError{"RectangleOutOfReach", "areas: [{id: a, rect: [0, 0, 4, 2e6]}]", "area.rect: expected 4 numbers"},
        CampusError{"PolygonThatIsNoList", "areas: [{id: a, polygon: 3}]", "area.polygon: expected a list of points"},
        CampusError{"PolygonWithABadPoint", "areas: [{id: a, polygon: [[0, 0], [1], [1, 1]]}]",
                    "area.polygon: expected 2 numbers"},
        CampusError{"PolygonOfTwo", "areas: [{id: a, polygon: [[0, 0], [1, 1]]}]",
                    "area a: an outline needs at least three corners"},
        CampusError{"UnknownKind", "areas: [{id: a, rect: [0, 0, 4, 4], kind: cellar}]",
                    "area.kind is \"cellar\": expected room, corridor, outdoor"},
        CampusError{"UnknownLevel", "areas: [{id: a, rect: [0, 0, 4, 4], level: roof}]",
                    "area a: there is no level \"roof\""},
        CampusError{"UnknownTexture", "areas: [{id: a, rect: [0, 0, 4, 4], texture: t}]",
                    "area a: there is no texture \"t\""},
        CampusError{"WallsThatAreANumber", "areas: [{id: a, rect: [0, 0, 4, 4], walls: 3}]",
                    "area.walls is not true or false"},
        CampusError{"TwoOfOneId", "areas: [{id: a, rect: [0, 0, 4, 4]}, {id: a, rect: [9, 0, 4, 4]}]",
                    "there are two areas \"a\""},
        CampusError{"UnknownAreaKey", "areas: [{id: a, rect: [0, 0, 4, 4], heigth: 3}]", "area has no key \"heigth\""}),
    [](const auto& param) { return param.param.name; });

#define AREA_DOOR(members) "areas: [{id: a, rect: [0, 0, 4, 4], doors: [{id: d, " members "}]}]"

INSTANTIATE_TEST_SUITE_P(
    Doors, CampusErrors,
    ::testing::Values(
        CampusError{"UnknownSide", AREA_DOOR("side: up"),
                    "a door of area a.side is \"up\": expected south, east, north, west"},
        CampusError{"BeyondTheSide", AREA_DOOR("at: 3.9"), "the door extends beyond its side"},
        CampusError{"BeforeTheSide", AREA_DOOR("at: 0.1"), "the door extends beyond its side"},
        CampusError{"OffTheSide", AREA_DOOR("at: 9"), "a door of area a.at is 9: expected 0 to 4"},
        CampusError{"WiderThanTheSide", AREA_DOOR("width: 5"), "the door extends beyond its side"},
        CampusError{"TooNarrow", AREA_DOOR("width: 0.05"), "a door of area a.width is 0.05: expected 0.1 to 100"},
        CampusError{"UnknownState", AREA_DOOR("state: ajar"),
                    "a door of area a.state is \"ajar\": expected open, closed, glass"},
        CampusError{"LeafTurnedTooFar", AREA_DOOR("leaf_deg: 200"),
                    "a door of area a.leaf_deg is 200: expected -180 to 180"},
        CampusError{"SideOfAPolygon",
                    "areas: [{id: a, polygon: [[0, 0], [4, 0], [2, 3]], doors: [{id: d, side: south}]}]",
                    "only rectangles have sides"},
        CampusError{"WithoutEnds", "doors: [{id: d}]", "door.from is missing"},
        CampusError{"WithOneEnd", "doors: [{id: d, from: [0, 0]}]", "door.to is missing"},
        CampusError{"WithoutExtent", "doors: [{id: d, from: [0, 0], to: [0.05, 0]}]",
                    "door d: its jambs are less than 0.1 m apart"},
        CampusError{"OnAnUnknownLevel", "doors: [{id: d, from: [0, 0], to: [1, 0], level: roof}]",
                    "door d: there is no level \"roof\""},
        CampusError{"TwoOfOneDoorId", "doors: [{id: d, from: [0, 0], to: [1, 0]}, {id: d, from: [5, 0], to: [6, 0]}]",
                    "there are two doors \"d\""},
        CampusError{"EmptyId", "doors: [{id: '', from: [0, 0], to: [1, 0]}]", "a door has no id"}),
    [](const auto& param) { return param.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Things, CampusErrors,
    ::testing::Values(
        CampusError{"WallOfOnePoint", "walls: [{points: [[0, 0]]}]", "a wall needs at least two points"},
        CampusError{"WallWithoutPoints", "walls: [{height: 2}]", "wall.points: expected a list of points"},
        CampusError{"WallTooThick", "walls: [{points: [[0, 0], [1, 0]], thickness: 9}]",
                    "wall.thickness is 9: expected 0 to 5"},
        CampusError{"BoxWithoutShape", "boxes: [{height: 1}]", "box.rect is missing"},
        CampusError{"BoxWithAnUnknownTexture", "boxes: [{rect: [0, 0, 1, 1], texture: t}]",
                    "a box: there is no texture \"t\""},
        CampusError{"PillarWithoutPlace", "pillars: [{radius: 1}]", "pillar.at is missing"},
        CampusError{"PillarWithoutExtent", "pillars: [{at: [0, 0], radius: 0}]",
                    "pillar.radius is 0: expected 0.01 to 50"},
        CampusError{"PersonWithoutAPath", "people: [{path: []}]", "a person's path has no points"},
        CampusError{"PersonTooFast", "people: [{path: [[0, 0]], speed: 11}]", "person.speed is 11: expected 0 to 10"},
        CampusError{"LiftWithoutShape", "lifts: [{id: l, levels: [ground]}]", "lift.rect is missing"},
        CampusError{"LiftWithAListForALevel", "lifts: [{id: l, rect: [0, 0, 2, 2], levels: [[ground]]}]",
                    "lift.levels: expected names"},
        CampusError{"LiftToNowhere", "lifts: [{id: l, rect: [0, 0, 2, 2], levels: [roof]}]",
                    "there is no level \"roof\""},
        CampusError{"DrawingWithoutRows", "drawings: [{cell: 0.5}]", "drawing.rows is missing"},
        CampusError{"DrawingWithoutContent", "drawings: [{rows: ''}]", "a drawing has no rows"},
        CampusError{"DrawingOfLargeCells", "drawings: [{rows: '#', cell: 200}]",
                    "drawing.cell is 200: expected 0.01 to 100"},
        CampusError{"DrawingWithAPointTwice", "drawings: [{rows: 'b b'}]", "two points 'b'"}),
    [](const auto& param) { return param.param.name; });

#define ROUTE(steps) "doors: [{id: d, from: [0, 0], to: [1, 0]}]\nrobots: [{id: r, route: [" steps "]}]"

INSTANTIATE_TEST_SUITE_P(
    Robots, CampusErrors,
    ::testing::Values(
        CampusError{"NoRobotId", "robots: [{route: [[0, 0], [1, 0]]}]", "robot.id is missing"},
        CampusError{"IdThatIsNoResourceId", "robots: [{id: R 2, route: [[0, 0], [1, 0]]}]",
                    "an id has only a to z, 0 to 9 and hyphens"},
        CampusError{"NoRoute", "robots: [{id: r}]", "a route begins with a point"},
        CampusError{"RouteOfOnePoint", ROUTE("[0, 0]"), "needs at least one more step"},
        CampusError{"RouteFromADoor", ROUTE("{door: d}, [0, 0]"), "a route begins with a point"},
        CampusError{"PointOfThree", ROUTE("[0, 0], [1, 2, 3]"), "line 2: robot.route: expected 2 numbers"},
        CampusError{"StepThatIsAWord", ROUTE("[0, 0], north"), "a step of the route is not a mapping"},
        CampusError{"UnknownStep", ROUTE("[0, 0], {drive: 3}"), "a step of the route.lift is missing"},
        CampusError{"UnknownDoor", ROUTE("[0, 0], {door: e}"), "robot r: there is no door \"e\""},
        CampusError{"UnknownPoint", ROUTE("[0, 0], {point: p}"), "no drawing has the point \"p\""},
        CampusError{"WaitOfMoreThanADay", ROUTE("[0, 0], {wait: 86401}"), "is 86401: expected 0 to 86400"},
        CampusError{"TwoStepsInOne", ROUTE("[0, 0], {door: d, wait: 1}"),
                    "line 2: a step of the route has no key \"wait\""},
        CampusError{"LiftWithoutAnEnd", ROUTE("[0, 0], {lift: l}"), "a step of the route.to is missing"},
        CampusError{"UnknownLift", ROUTE("[0, 0], {lift: l, to: ground}"), "there is no lift \"l\""},
        CampusError{"LiftThatDoesNotStopThere",
                    "levels: {ground: 0, first: 3}\nlifts: [{id: l, rect: [0, 0, 2, 2], levels: [ground]}]\n"
                    "robots: [{id: r, route: [[0, 0], {lift: l, to: first}]}]",
                    "lift l does not stop at \"first\""},
        CampusError{"NoLaps", "robots: [{id: r, laps: 0, route: [[0, 0], [1, 0]]}]", "laps is 0: expected 1 to 1000"},
        CampusError{"TooSlow", "robots: [{id: r, speed: 0, route: [[0, 0], [1, 0]]}]",
                    "robot.speed is 0: expected 0.01 to 5"}),
    [](const auto& param) { return param.param.name; });

}  // namespace
}  // namespace enfilade::simulator

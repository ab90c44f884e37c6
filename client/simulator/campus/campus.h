// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace enfilade::simulator {

// A campus as its author wrote it (docs/simulator.md). Frame: the campus frame, metres, x east, y north, z up from each
// level's floor. Plain values; World computes from them what sensors see.

struct Texture {
  double contrast = 1.0;    // 0: plain
  double brightness = 0.6;  // 0 to 1
  // m: the pattern repeats at this distance in x and y and does not depend on where a wall stands, so that walls look
  // alike. 0: it is different everywhere.
  double period = 0.0;
  std::uint64_t seed = 0;
};

enum class AreaKind { kRoom, kCorridor, kOutdoor };

// One map as the robots should make it. A point belongs to the first area that contains it.
struct Area {
  std::string id;
  AreaKind kind = AreaKind::kRoom;
  std::string level;
  std::vector<Eigen::Vector2d> outline;  // the corners, counter-clockwise
  bool walled = true;                    // there are walls on the outline
  double wall_height = 3.0;              // m; indoors also the height of the ceiling
  std::string texture;

  bool indoor() const { return kind != AreaKind::kOutdoor; }
};

struct Wall {
  std::string level;
  std::vector<Eigen::Vector2d> points;
  double bottom = 0.0;
  double top = 3.0;
  double thickness = 0.15;  // 0: a sheet
  bool glass = false;
  std::string texture;  // empty: that of the area in front of it
};

enum class DoorState { kOpen, kClosed, kGlass };  // kGlass: closed by a pane

// A gap in every wall along its line.
struct Door {
  std::string id;
  std::string level;
  Eigen::Vector2d a = Eigen::Vector2d::Zero();  // the jambs
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  double height = 2.1;  // m; the wall continues above it
  DoorState state = DoorState::kOpen;
  std::optional<double> leaf;  // rad: angle of the open leaf from the gap, hinged at a
  bool opening = false;        // an opening that is not a door: passing it is not a passage

  double width() const { return (b - a).norm(); }
  Eigen::Vector2d middle() const { return (a + b) / 2.0; }
};

// Furniture, pillars, clutter: a prism.
struct Box {
  std::string level;
  std::vector<Eigen::Vector2d> outline;
  double bottom = 0.0;
  double top = 1.0;
  std::string texture;
};

// A cylinder that walks back and forth along its path.
struct Person {
  std::string level;
  std::vector<Eigen::Vector2d> path;
  double speed = 0.8;   // m/s
  double phase = 0.0;   // s ahead
  double radius = 0.2;  // m
  double height = 1.75;
};

// A cabin with one door, at the same place on several levels. It is an area on each of them.
struct Lift {
  std::string id;
  std::vector<std::string> levels;
};

struct RouteStep {
  enum class Kind { kPoint, kDoor, kWait, kTurnTo, kLift };
  Kind kind = Kind::kPoint;
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  std::string name;    // of the door, the lift
  std::string level;   // kLift: the destination
  double value = 0.0;  // s to wait; rad to turn to, in the campus frame
};

struct Robot {
  std::string id;
  std::string level;
  std::vector<RouteStep> route;  // the first step is a point, the start
  std::vector<RouteStep> back;   // from the route's end to its start; empty: straight
  int laps = 1;                  // how often the route is driven, with the way back between two rounds
  bool returns = false;          // also drives back to the start after the last lap
  std::optional<double> speed;   // m/s, instead of the option
};

struct Campus {
  std::string name;
  double wall_thickness = 0.15;
  std::uint64_t texture_seed = 1;
  std::map<std::string, double> levels;  // id -> height of the floor, m
  std::map<std::string, Texture> textures;
  std::vector<Area> areas;
  std::vector<Wall> walls;
  std::vector<Door> doors;
  std::vector<Box> boxes;
  std::vector<Person> people;
  std::vector<Lift> lifts;
  std::vector<Robot> robots;

  const Area* FindArea(const std::string& id) const;
  const Door* FindDoor(const std::string& id) const;
  const Lift* FindLift(const std::string& id) const;
  const Robot* FindRobot(const std::string& id) const;
  // The first area on that level that holds the point, or nullptr.
  const Area* AreaAt(const std::string& level, const Eigen::Vector2d& point) const;
};

// INVALID_ARGUMENT naming the part: an id that is used twice, a name that refers to nothing, a shape without extent, a
// route that does not begin with a point.
absl::Status Validate(const Campus& campus);

bool Contains(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& point);

// Corners of a rectangle, counter-clockwise, rotated about its centre by `yaw` rad.
std::vector<Eigen::Vector2d> RectangleOutline(double x, double y, double width, double height, double yaw = 0.0);

}  // namespace enfilade::simulator

// SPDX-License-Identifier: Apache-2.0
#include "core/survey/drive_rooms.h"

#include <algorithm>
#include <cmath>

namespace enfilade::survey {
namespace {

// A visit of a drive, with the session that it is of and the room that it is in.
struct LabelledVisit {
  std::size_t session = 0;
  std::size_t index = 0;
  const Visit* visit = nullptr;
  int room = 0;

  Eigen::Vector2d position() const { return visit->T_level_robot.translation(); }
};

// The room at the point, or the nearest one within `snap`; 0: none.
int RoomNear(const rooms::RoomPartition& partition, const Eigen::Vector2d& point, double snap) {
  if (const int room = partition.RoomAt(point)) return room;
  const double step = partition.geometry.resolution;
  for (double radius = step; radius <= snap; radius += step) {
    const int count = std::max(8, static_cast<int>(std::ceil(2.0 * M_PI * radius / step)));
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * M_PI * i / count;
      const Eigen::Vector2d p = point + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      if (const int room = partition.RoomAt(p)) return room;
    }
  }
  return 0;
}

std::vector<LabelledVisit> LabelVisits(const Drive& drive, const rooms::RoomPartition& partition, double snap) {
  std::vector<LabelledVisit> visits;
  for (std::size_t s = 0; s < drive.size(); ++s) {
    for (std::size_t i = 0; i < drive[s].visits.size(); ++i) {
      const Visit& visit = drive[s].visits[i];
      visits.push_back({s, i, &visit, RoomNear(partition, visit.T_level_robot.translation(), snap)});
    }
  }
  // A pose in no room is where the robot was before; at the start, where it came to.
  for (std::size_t i = 1; i < visits.size(); ++i) {
    if (visits[i].room == 0) visits[i].room = visits[i - 1].room;
  }
  for (std::size_t i = visits.size(); i-- > 1;) {
    if (visits[i - 1].room == 0) visits[i - 1].room = visits[i].room;
  }
  return visits;
}

// The end of the run of equal rooms that begins at `first`.
std::size_t EndOfRun(const std::vector<LabelledVisit>& visits, std::size_t first) {
  std::size_t end = first;
  while (end < visits.size() && visits[end].room == visits[first].room) ++end;
  return end;
}

// How far the robot came from where the run begins or, at a drive's start, ends.
double ReachOf(const std::vector<LabelledVisit>& visits, std::size_t first, std::size_t end) {
  const Eigen::Vector2d door =
      first > 0 ? visits[first - 1].position() : (end < visits.size() ? visits[end].position() : visits[0].position());
  double reach = 0.0;
  for (std::size_t i = first; i < end; ++i) reach = std::max(reach, (visits[i].position() - door).norm());
  return reach;
}

// The shortest looks first, so that one look does not hide another.
void DropLooks(std::vector<LabelledVisit>& visits, double reach) {
  while (true) {
    std::size_t shortest = visits.size();
    double least = reach;
    for (std::size_t first = 0; first < visits.size(); first = EndOfRun(visits, first)) {
      const std::size_t end = EndOfRun(visits, first);
      if (first == 0 && end == visits.size()) return;
      const double length = ReachOf(visits, first, end);
      if (length < least) {
        least = length;
        shortest = first;
      }
    }
    if (shortest == visits.size()) return;
    const std::size_t end = EndOfRun(visits, shortest);
    const int room = shortest > 0 ? visits[shortest - 1].room : visits[end].room;
    for (std::size_t i = shortest; i < end; ++i) visits[i].room = room;
  }
}

void AddStretches(const std::vector<LabelledVisit>& visits, std::size_t drive, RoomsOfDrives& found) {
  for (std::size_t i = 0; i < visits.size(); ++i) {
    const LabelledVisit& visit = visits[i];
    const double step = i == 0 ? 0.0 : (visit.position() - visits[i - 1].position()).norm();
    Stretch* last = found.stretches.empty() ? nullptr : &found.stretches.back();
    if (last != nullptr && last->drive == drive && last->session == visit.session && last->room == visit.room) {
      last->last = visit.index;
      last->length += step;
    } else {
      found.stretches.push_back({drive, visit.session, visit.index, visit.index, visit.room, step});
    }
    if (i > 0 && visits[i - 1].room != visit.room) {
      found.crossings.push_back(
          {visits[i - 1].room, visit.room, visits[i - 1].visit->T_level_robot, visit.visit->T_level_robot});
    }
  }
}

}  // namespace

RoomsOfDrives FindRooms(const LevelSurvey& survey, const rooms::RoomPartition& partition,
                        const SurveyOptions& options) {
  RoomsOfDrives found;
  for (std::size_t i = 0; i < survey.drives.size(); ++i) {
    std::vector<LabelledVisit> visits = LabelVisits(survey.drives[i], partition, options.snap);
    if (visits.empty() || visits.front().room == 0) continue;  // nowhere in a room
    DropLooks(visits, options.reach);
    AddStretches(visits, i, found);
  }
  return found;
}

}  // namespace enfilade::survey

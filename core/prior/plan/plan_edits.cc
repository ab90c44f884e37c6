// SPDX-License-Identifier: Apache-2.0
#include "core/prior/plan/plan_edits.h"

#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/plan/plan_check.h"
#include "core/prior/plan/planar.h"
#include "core/prior/plan/room_names.h"
#include "core/prior/plan/segment_grid.h"

namespace enfilade::prior {
namespace {

using Eigen::Vector2d;
using Ends = std::pair<int, int>;  // two corners, in either order

Ends EndsOf(int a, int b) { return std::minmax({a, b}); }

Vector2d NearestOn(const Vector2d& a, const Vector2d& b, const Vector2d& p) {
  const Vector2d along = b - a;
  const double length = along.squaredNorm();
  return length > 0 ? Vector2d(a + std::clamp((p - a).dot(along) / length, 0.0, 1.0) * along) : a;
}

// Points that are one if they are within `reach` of the first of them.
class PointIndex {
 public:
  explicit PointIndex(double reach) : reach_(reach), grid_(std::max(reach, std::numeric_limits<double>::min())) {}

  std::optional<int> Find(const Vector2d& p) const {
    std::optional<int> nearest;
    double least = reach_;
    grid_.ForEachNear(p, p, [&](int id) {
      const double distance = (points_[id] - p).norm();
      if (distance > least || (nearest && distance == least)) return;
      least = distance;
      nearest = id;
    });
    return nearest;
  }
  int Add(const Vector2d& p) {
    const int id = static_cast<int>(points_.size());
    points_.push_back(p);
    grid_.Add(id, p, p);
    return id;
  }
  int FindOrAdd(const Vector2d& p) {
    const std::optional<int> found = Find(p);
    return found ? *found : Add(p);
  }
  const std::vector<Vector2d>& points() const { return points_; }

 private:
  double reach_;
  SegmentGrid grid_;
  std::vector<Vector2d> points_;
};

class PlanEditor {
 public:
  PlanEditor(const PlanGraph& before, const PlanGraph& drawn)
      : before_(before),
        drawn_(drawn),
        same_(kSameShare * DiagonalOf(before)),
        join_(JoinDistance(before)),
        corners_(same_),
        anchors_(join_) {}

  absl::StatusOr<EditedPlan> Run() {
    ENFILADE_RETURN_IF_ERROR(CheckPlan(drawn_));
    KeepWalls();
    KeepDoors();
    PlanGraph& plan = edited_.plan;
    plan = before_;
    if (edited_.changes.AnyWallOrDoor()) {
      AddWalls();
      AddDoors();
      Assemble();
    }
    WarnOfCorners();
    TakeTheRest();
    ENFILADE_RETURN_IF_ERROR(CheckPlan(plan));
    return std::move(edited_);
  }

 private:
  static constexpr double kSameShare = 1e-6;

  const Vector2d& At(int corner) const { return corners_.points()[corner]; }

  void KeepWalls() {
    std::map<Ends, const PlanWall*> known;
    for (const PlanWall& wall : before_.walls) {
      known.emplace(EndsOf(corners_.FindOrAdd(before_.corners[wall.from].point),
                           corners_.FindOrAdd(before_.corners[wall.to].point)),
                    &wall);
    }
    std::set<Ends> kept;
    for (const PlanWall& wall : drawn_.walls) {
      const std::optional<int> from = corners_.Find(drawn_.corners[wall.from].point);
      const std::optional<int> to = corners_.Find(drawn_.corners[wall.to].point);
      const auto found = from && to ? known.find(EndsOf(*from, *to)) : known.end();
      if (found == known.end()) {
        new_walls_.push_back(&wall);
        continue;
      }
      if (!kept.insert(found->first).second) continue;  // drawn twice
      if (found->second->thickness != wall.thickness || found->second->confidence != wall.confidence)
        ++edited_.changes.walls_changed;
      walls_.push_back({*from, *to, wall.thickness, wall.confidence});
    }
    edited_.changes.walls_added = static_cast<int>(new_walls_.size());
    edited_.changes.walls_removed = static_cast<int>(known.size() - kept.size());
  }

  void KeepDoors() {
    std::map<Ends, const PlanDoor*> known;
    for (const PlanDoor& door : before_.doors)
      known.emplace(EndsOf(corners_.FindOrAdd(door.from), corners_.FindOrAdd(door.to)), &door);
    std::set<Ends> kept;
    for (const PlanDoor& door : drawn_.doors) {
      const std::optional<int> from = corners_.Find(door.from), to = corners_.Find(door.to);
      const auto found = from && to ? known.find(EndsOf(*from, *to)) : known.end();
      if (found == known.end()) {
        new_doors_.push_back(door);
      } else if (kept.insert(found->first).second) {
        doors_.push_back(*found->second);
      }
    }
    edited_.changes.doors_added = static_cast<int>(new_doors_.size());
    edited_.changes.doors_removed = static_cast<int>(known.size() - kept.size());
  }

  // Ends of new walls move onto corners first, then those that are at none onto walls.
  void AddWalls() {
    for (const PlanWall& wall : walls_) {
      anchors_.FindOrAdd(At(wall.from));
      anchors_.FindOrAdd(At(wall.to));
    }
    std::vector<std::pair<Vector2d, Vector2d>> lines;
    std::vector<std::pair<bool, bool>> at_corner;
    const auto to_corner = [&](Vector2d& p) {
      const std::optional<int> anchor = anchors_.Find(p);
      if (anchor) p = anchors_.points()[*anchor];
      return anchor.has_value();
    };
    for (const PlanWall* wall : new_walls_) {
      Vector2d from = drawn_.corners[wall->from].point, to = drawn_.corners[wall->to].point;
      const bool from_at = to_corner(from), to_at = to_corner(to);
      at_corner.emplace_back(from_at, to_at);
      lines.emplace_back(from, to);
      anchors_.FindOrAdd(from), anchors_.FindOrAdd(to);
    }
    IndexWalls(lines);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      auto& [from, to] = lines[i];
      const int own = static_cast<int>(walls_.size() + i);
      if (!at_corner[i].first) from = OnWall(from, own).value_or(from);
      if (!at_corner[i].second) to = OnWall(to, own).value_or(to);
      segments_[own] = lines[i];
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const auto& [from, to] = lines[i];
      const int a = corners_.FindOrAdd(from), b = corners_.FindOrAdd(to);
      if (a != b) {
        walls_.push_back({a, b, new_walls_[i]->thickness, new_walls_[i]->confidence});
        continue;
      }
      --edited_.changes.walls_added;
      edited_.warnings.push_back(fmt::format("the wall at ({:.1f}, {:.1f}) is shorter than {:.2g} and was left out",
                                             from.x(), from.y(), join_));
    }
  }

  void IndexWalls(const std::vector<std::pair<Vector2d, Vector2d>>& lines) {
    for (const PlanWall& wall : walls_) segments_.emplace_back(At(wall.from), At(wall.to));
    segments_.insert(segments_.end(), lines.begin(), lines.end());
    double length = 0;
    for (const auto& [a, b] : segments_) length += (b - a).norm();
    const double mean = segments_.empty() ? 1 : length / static_cast<double>(segments_.size());
    near_walls_.emplace(std::max(join_, mean / 2));
    for (std::size_t i = 0; i < segments_.size(); ++i)
      near_walls_->Add(static_cast<int>(i), segments_[i].first, segments_[i].second);
  }

  // The nearest point of a wall but `own`, within reach.
  std::optional<Vector2d> OnWall(const Vector2d& p, int own) const {
    std::optional<Vector2d> nearest;
    double least = join_;
    near_walls_->ForEachNear(p, p, [&](int id) {
      if (id == own) return;
      const Vector2d on = NearestOn(segments_[id].first, segments_[id].second, p);
      if ((on - p).norm() > least) return;
      least = (on - p).norm();
      nearest = on;
    });
    return nearest;
  }

  void AddDoors() {
    for (PlanDoor& door : new_doors_) {
      bool joined = true;
      for (Vector2d* end : {&door.from, &door.to}) {
        std::optional<Vector2d> place;
        if (const std::optional<int> anchor = anchors_.Find(*end)) place = anchors_.points()[*anchor];
        if (!place) place = OnWall(*end, -1);
        if (place) *end = *place;
        joined = joined && place.has_value();
      }
      if (!joined) {
        edited_.warnings.push_back(fmt::format("the door from ({:.1f}, {:.1f}) to ({:.1f}, {:.1f}) ends at no wall",
                                               door.from.x(), door.from.y(), door.to.x(), door.to.y()));
      }
    }
  }

  // New doors are walls until those are cut; then all that lies on them goes.
  void Assemble() {
    for (const PlanDoor& door : new_doors_) {
      const int from = corners_.FindOrAdd(door.from), to = corners_.FindOrAdd(door.to);
      if (from != to) walls_.push_back({.from = from, .to = to});
    }
    PlanGraph graph;
    for (const Vector2d& point : corners_.points()) graph.corners.push_back({point});
    graph.walls = std::move(walls_);
    graph = Planarise(graph, same_);
    const auto is_on_new_door = [&](const PlanWall& wall) {
      return std::any_of(new_doors_.begin(), new_doors_.end(), [&](const PlanDoor& door) {
        for (const int corner : {wall.from, wall.to}) {
          const Vector2d& p = graph.corners[corner].point;
          if ((NearestOn(door.from, door.to, p) - p).norm() > 2 * same_) return false;
        }
        return true;
      });
    };
    std::erase_if(graph.walls, is_on_new_door);
    DropLooseCorners(graph);
    edited_.plan.corners = std::move(graph.corners);
    edited_.plan.walls = std::move(graph.walls);
    edited_.plan.doors = std::move(doors_);
    edited_.plan.doors.insert(edited_.plan.doors.end(), new_doors_.begin(), new_doors_.end());
  }

  static void DropLooseCorners(PlanGraph& graph) {
    std::vector<int> number(graph.corners.size(), -1);
    for (const PlanWall& wall : graph.walls) number[wall.from] = number[wall.to] = 0;
    std::vector<PlanCorner> kept;
    for (std::size_t i = 0; i < number.size(); ++i) {
      if (number[i] < 0) continue;
      number[i] = static_cast<int>(kept.size());
      kept.push_back(graph.corners[i]);
    }
    for (PlanWall& wall : graph.walls) wall.from = number[wall.from], wall.to = number[wall.to];
    graph.corners = std::move(kept);
  }

  // Who moves a corner alone moves no wall.
  void WarnOfCorners() {
    std::vector<bool> used(drawn_.corners.size(), false);
    for (const PlanWall& wall : drawn_.walls) used[wall.from] = used[wall.to] = true;
    int moved = 0;
    for (std::size_t i = 0; i < used.size(); ++i) moved += !used[i] && !corners_.Find(drawn_.corners[i].point);
    if (moved > 0) {
      edited_.warnings.push_back(
          fmt::format("{} corners are where no wall ends: walls are where their lines are", moved));
    }
  }

  void TakeTheRest() {
    PlanGraph& plan = edited_.plan;
    const std::vector<PlanRoom>& named = drawn_.rooms.empty() ? before_.rooms : drawn_.rooms;
    plan.rooms = edited_.changes.AnyWallOrDoor() ? WithNamesOf(named, FindRooms(plan, NarrowestRoom(plan))) : named;
    plan.shafts = drawn_.shafts;
    if (drawn_.metres_per_unit) plan.metres_per_unit = drawn_.metres_per_unit;
    edited_.changes.scale_changed = plan.metres_per_unit != before_.metres_per_unit;
    const auto is_same = [&](const auto& a, const auto& b) {
      if (a.name != b.name || a.outline.size() != b.outline.size()) return false;
      for (std::size_t i = 0; i < a.outline.size(); ++i) {
        if ((a.outline[i] - b.outline[i]).norm() > same_) return false;
      }
      return true;
    };
    edited_.changes.outlines_changed =
        !std::equal(plan.shafts.begin(), plan.shafts.end(), before_.shafts.begin(), before_.shafts.end(), is_same) ||
        (!edited_.changes.AnyWallOrDoor() &&
         !std::equal(plan.rooms.begin(), plan.rooms.end(), before_.rooms.begin(), before_.rooms.end(), is_same));
  }

  const PlanGraph& before_;
  const PlanGraph& drawn_;
  const double same_;
  const double join_;
  PointIndex corners_;  // of walls and doors
  PointIndex anchors_;  // corners that new ends move onto
  std::vector<PlanWall> walls_;
  std::vector<PlanDoor> doors_;
  std::vector<const PlanWall*> new_walls_;
  std::vector<PlanDoor> new_doors_;
  std::vector<std::pair<Vector2d, Vector2d>> segments_;  // of walls, those that stay first
  std::optional<SegmentGrid> near_walls_;
  EditedPlan edited_;
};

std::string CountOf(int count, const char* what) { return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s"); }

}  // namespace

std::string Describe(const PlanChanges& changes) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "; ") + part; };
  const auto add_counts = [&](const char* what, int added, int removed, int changed) {
    std::string part;
    for (const auto& [count, verb] : {std::pair{added, "added"}, {removed, "removed"}, {changed, "changed"}}) {
      if (count == 0) continue;
      part += part.empty() ? CountOf(count, what) + " " + verb : fmt::format(", {} {}", count, verb);
    }
    if (!part.empty()) add(part);
  };
  add_counts("wall", changes.walls_added, changes.walls_removed, changes.walls_changed);
  add_counts("door", changes.doors_added, changes.doors_removed, 0);
  if (changes.scale_changed) add("another scale");
  if (changes.outlines_changed) add("other rooms or shafts");
  return text.empty() ? "nothing" : text;
}

absl::StatusOr<EditedPlan> ApplyEdits(const PlanGraph& before, const PlanGraph& drawn) {
  return PlanEditor(before, drawn).Run();
}

}  // namespace enfilade::prior

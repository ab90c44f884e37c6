#include "core/doors/passage_evidence.h"

#include "fmt/format.h"

namespace enfilade {

PassageVerdict JudgePassage(const PassageEvidence& evidence, const DoorOptions& options) {
  const JambWalls& walls = evidence.walls;
  const GapOptions& o = options.gap;
  if (!evidence.behind.met()) return {false, "it is not behind the robot"};
  if (evidence.met() < options.criteria) return {false, fmt::format("{} of three criteria", evidence.met())};
  const bool across = walls.left_cornered && walls.right_cornered && walls.beside() >= o.wall_across;
  // A scanner that looks ahead only sees the wall from one side, while it turns towards the door: too little of it.
  const bool wall_seen = evidence.environment.state != CriterionVerdict::State::kDropped;
  if (wall_seen && !across && (walls.beside() < o.wall_beside || walls.length() < o.wall)) {
    return {false, fmt::format("no gap in a wall: {:.2f} m of it run on from the left post, {:.2f} m from the right",
                               walls.left, walls.right)};
  }
  if (evidence.parallel >= o.parallel) {
    return {false, fmt::format("walls run beside the way for {:.2f} m at both posts", evidence.parallel)};
  }
  const bool same = evidence.hidden >= 0.0 && evidence.hidden < options.environment.same;
  if (same && !across && walls.length() < o.long_wall) {
    return {false, fmt::format("{:.0f} % of the ground is out of sight behind it", 100.0 * evidence.hidden)};
  }
  const bool may_have_changed = evidence.environment.state != CriterionVerdict::State::kOpen;
  if (evidence.way_round && !(walls.beside() >= o.long_wall && may_have_changed)) {
    return {false, "free ground leads round it"};
  }
  return {true, fmt::format("{} of three criteria{}; its wall runs on for {:.2f} and {:.2f} m", evidence.met(),
                            evidence.way_round ? ", though there is a way round" : "", walls.left, walls.right)};
}

}  // namespace enfilade

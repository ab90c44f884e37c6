// SPDX-License-Identifier: Apache-2.0
#include "core/doors/passage_evidence.h"

#include <algorithm>

#include "fmt/format.h"

namespace enfilade::doors {
namespace {

constexpr double kLeastDepth = 0.05;  // m, of a wall: the local map's resolution
constexpr double kFarMore = 2.0;      // times the required slenderness: certainly a wall

}  // namespace

PassageVerdict JudgePassage(const PassageEvidence& evidence, const DoorOptions& options) {
  const JambWalls& walls = evidence.walls;
  const GapOptions& o = options.gap;
  if (!evidence.behind.met()) return {false, "it is not behind the robot"};
  if (evidence.met() < options.criteria) return {false, fmt::format("{} of three criteria", evidence.met())};
  const bool across = walls.left_cornered && walls.right_cornered && walls.beside() >= o.wall_across;
  if (!across && (walls.beside() < o.wall_beside || walls.length() < o.wall)) {
    return {false, fmt::format("no gap in a wall: {:.2f} m of wall at the left post, {:.2f} m at the right", walls.left,
                               walls.right)};
  }
  if (evidence.parallel >= o.parallel) {
    return {false, fmt::format("walls run beside the way for {:.2f} m at both posts", evidence.parallel)};
  }
  // Furniture is about as deep along the way as it is long across it. So is a cupboard in a corridor, which hides
  // little ground.
  const double slenderness = walls.weighted_length() / std::max(evidence.parallel, kLeastDepth);
  if (slenderness < o.slender && !(across && evidence.environment.met())) {
    return {false, fmt::format("no wall: {:.2f} m long, {:.1f} times its depth along the way", walls.weighted_length(),
                               slenderness)};
  }
  const bool same = evidence.hidden >= 0.0 && evidence.hidden < options.environment.same;
  if (same && !across && walls.length() < o.long_wall) {
    return {false, fmt::format("{:.0f} % of the ground is out of sight behind it", 100.0 * evidence.hidden)};
  }
  const bool may_have_changed = evidence.environment.state != CriterionVerdict::State::kOpen;
  const bool outweighs = (walls.beside() >= o.long_wall && may_have_changed) || slenderness >= kFarMore * o.slender;
  if (evidence.way_round && !outweighs) {
    return {false, "free ground leads round it"};
  }
  return {true, fmt::format("{} of three criteria{}; its wall runs on for {:.2f} and {:.2f} m", evidence.met(),
                            evidence.way_round ? ", though there is a way round" : "", walls.left, walls.right)};
}

}  // namespace enfilade::doors

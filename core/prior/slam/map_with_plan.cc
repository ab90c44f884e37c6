// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/map_with_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <utility>

#include "core/base/status_macros.h"
#include "core/graph/chi_squared.h"
#include "core/prior/slam/map_pieces.h"
#include "core/prior/slam/piece_graph.h"
#include "core/prior/slam/plan_tracking.h"
#include "core/prior/ties/find_ties.h"
#include "fmt/format.h"

namespace enfilade::prior {

double Knob(const char* name, double value) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::atof(text) : value;
}

namespace {

const int kTieRounds = static_cast<int>(Knob("T_ROUNDS", 4));
const int kTrackRounds = static_cast<int>(Knob("K_ROUNDS", 2));
// A piece bends a little: these deviations are added to what is stated of a link, for each and for each metre of it.
const double kBend = Knob("B_T0", 0.01);            // m
const double kBendPerMetre = Knob("B_T1", 0.005);   // m
const double kTurn = Knob("B_Y0", 0.005);           // rad
const double kTurnPerMetre = Knob("B_Y1", 0.0025);  // rad
// In the first round so much more again, half as much in each further one.
const double kFirstLooseness = Knob("EXTRA", 1.0);
const double kLooseChi2 = Knob("LOOSE", 11.34);  // 99 %, 3 degrees of freedom
const double kMostLoosened = 1.0 / 3;            // of all links
// The same place, seen by other pieces.
const double kSelfRange = Knob("SELF_RANGE", 10);  // m, between their first keyframes
constexpr std::size_t kNeighbours = 3;
constexpr double kSameWall = 0.12;  // m
constexpr double kLeastSelf = 300;  // points that other pieces know, to say anything
// From what on SLAM counts as lost.
constexpr double kLostExplained = 0.35;
constexpr double kLostContradicted = 0.1;

// A map, the pieces as they lie in it, and the plan in it.
struct FittedPieces {
  MappedLog mapped;
  CutMap cut;
  std::vector<Pose2> T_map_pieces;
  Alignment alignment;
  std::unique_ptr<const MapEvidence> evidence;
  std::unique_ptr<const CorrectedPlan> corrected;
  double self = 1;        // share of walls that other pieces have seen, too, of those on ground that they know
  double self_known = 0;  // points
  std::string objection;  // to the plan
  std::string name;

  const Agreement& agreement() const { return alignment.agreement; }
  // What of the map and of the plan the other does not agree with.
  double disagreement() const { return 1 - agreement().explained + agreement().contradicted(); }
};

void MeasureSelf(FittedPieces& fitted) {
  double matched = 0, contradicted = 0;
  const std::vector<MapPiece>& pieces = fitted.cut.pieces;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    for (std::size_t j = 0; j < pieces.size(); ++j) {
      if (i + kNeighbours > j && j + kNeighbours > i) continue;
      const Pose2 T_i_j = Between(fitted.T_map_pieces[i], fitted.T_map_pieces[j]);
      if (T_i_j.translation().norm() > kSelfRange) continue;
      for (const WallPoint& wall : pieces[j].evidence.walls) {
        const Eigen::Vector2d point = T_i_j * wall.point;
        if (pieces[i].evidence.WallDistanceAt(point) <= kSameWall) {
          ++matched;
        } else if (pieces[i].evidence.GroundAt(point) == Ground::kFree) {
          ++contradicted;
        }
      }
    }
  }
  fitted.self_known = matched + contradicted;
  fitted.self = fitted.self_known > 0 ? matched / fitted.self_known : 1;
}

slam::SlamOptions GuidedOptions(slam::SlamOptions options) {
  options.motion.translation_floor = Knob("G_T0", 0.1);
  options.motion.translation_per_metre = Knob("G_T1", 0.05);
  options.motion.yaw_floor = Knob("G_Y0", 0.02);
  options.motion.yaw_per_metre = Knob("G_Y1", 0.01);
  options.motion.yaw_per_radian = 0.05;
  return options;
}

void AddBending(double looseness, PieceLink& link) {
  const double length = link.T_from_to.translation().norm();
  const double across = looseness * (kBend + kBendPerMetre * length);
  const double turn = looseness * (kTurn + kTurnPerMetre * length);
  link.covariance.diagonal() += Eigen::Vector3d(across * across, across * across, turn * turn);
}

class PlanMapper {
 public:
  PlanMapper(const PlanGraph& plan, const std::vector<sensor::PairedScan>& scans, const FitOptions& fitting,
             const slam::SlamOptions& options)
      : plan_(plan), scans_(scans), fitting_(fitting), options_(options) {}

  absl::StatusOr<MapWithPlan> Run() {
    MapWithPlan result;
    result.mapped = MapLog(scans_, options_);
    ENFILADE_ASSIGN_OR_RETURN(PlanFit fit, FitPlan(plan_, {result.mapped.grid}, fitting_));
    if (!fit.alignment.accepted) {
      result.reason = fmt::format("the plan does not lie in the map: {}", fit.alignment.reason);
      return result;
    }
    if (std::getenv("A")) {
      double a[6];
      std::sscanf(std::getenv("A"), "%lf,%lf,%lf,%lf,%lf,%lf", a, a + 1, a + 2, a + 3, a + 4, a + 5);
      fit.alignment.T_map_sheet.linear << a[0], a[1], a[3], a[4];
      fit.alignment.T_map_sheet.offset << a[2], a[5];
    }
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces without, Fitted(result.mapped, fit.alignment.T_map_sheet));
    if (const char* mode = std::getenv("MODE")) {
      FittedPieces best = std::move(without);
      for (const char* op = mode; *op; ++op) {
        if (*op == 't') {
          ENFILADE_ASSIGN_OR_RETURN(best, Tied(best));
        } else if (*op == 'c') {
          ENFILADE_ASSIGN_OR_RETURN(
              best, Guided(TrackInPlan(best.corrected->faces(), scans_, {}, options_), best.alignment.T_map_sheet));
        } else if (*op == 'p') {
          ENFILADE_ASSIGN_OR_RETURN(
              best, Guided(TrackInPlan(Transformed(FacesOf(plan_), best.alignment.T_map_sheet), scans_, {}, options_),
                           best.alignment.T_map_sheet));
        } else if (*op == 'k') {
          PlanTransform start = best.alignment.T_map_sheet;
          ENFILADE_ASSIGN_OR_RETURN(const PlanTrack track, TrackFromStart(best, start));
          ENFILADE_ASSIGN_OR_RETURN(best, Guided(track, start));
        } else if (*op == 'g') {
          ENFILADE_ASSIGN_OR_RETURN(best, Guided({PosesOf(best.mapped.map), 1.0}, best.alignment.T_map_sheet));
        }
      }
      result.mapped = std::move(best.mapped);
      result.corrected = true;
      return result;
    }
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces best, Tied(without));
    if (IsLost(without)) {
      ENFILADE_ASSIGN_OR_RETURN(FittedPieces tracked, Tracked(without));
      if (tracked.disagreement() < best.disagreement()) best = std::move(tracked);
    }
    result.reason = best.objection.empty() ? ObjectionTo(best, without) : best.objection;
    result.corrected = result.reason.empty();
    if (!result.corrected) return result;
    result.mapped = std::move(best.mapped);
    result.reason = fmt::format(
        "the plan explains {:.0f} % of the map's walls, {:.0f} % before; of walls that the robot has seen again {:.1f} "
        "% lie "
        "where they did, {:.1f} % before",
        100 * best.agreement().explained, 100 * without.agreement().explained, 100 * best.self, 100 * without.self);
    return result;
  }

 private:
  static bool IsLost(const FittedPieces& fitted) {
    return fitted.agreement().explained < kLostExplained || fitted.agreement().contradicted() > kLostContradicted;
  }

  // Why the map is better left as it is; empty: it is not.
  static std::string ObjectionTo(const FittedPieces& next, const FittedPieces& without) {
    const AlignOptions least;
    const Agreement& agreement = next.agreement();
    if (agreement.explained < least.least_explained || agreement.explained_length < least.least_length ||
        agreement.contradicted() > least.most_contradicted) {
      return fmt::format("the plan explains {:.0f} % of the map's walls, and {:.0f} % of it are contradicted",
                         100 * agreement.explained, 100 * agreement.contradicted());
    }
    const bool agrees_more = next.self_known >= kLeastSelf && 1 - next.self < 0.9 * (1 - without.self) &&
                             next.disagreement() < without.disagreement() + 0.01;
    const bool is_explained_more =
        next.disagreement() < 0.8 * without.disagreement() && (1 - next.self) < (1 - without.self) + 0.01;
    if (agrees_more || is_explained_more) return "";
    return fmt::format(
        "the map would not be better: the plan would explain {:.0f} % of its walls, {:.0f} % without; of walls that "
        "the robot has "
        "seen again {:.1f} % would lie where they did, {:.1f} % without",
        100 * agreement.explained, 100 * without.agreement().explained, 100 * next.self, 100 * without.self);
  }

  std::vector<Pose2> PosesOf(const slam::SlamMap& map) const {
    std::map<std::int64_t, Pose2> found;
    for (const slam::TrajectoryPoint& point : map.trajectory) {
      found[point.sequence] = map.nodes.at(point.node).T_map_node * point.T_node_robot;
    }
    std::vector<Pose2> poses;
    for (const sensor::PairedScan& scan : scans_) {
      const auto pose = found.find(scan.sequence);
      poses.push_back(pose != found.end() ? pose->second : poses.empty() ? Pose2{} : poses.back());
    }
    return poses;
  }

  // Moves the plan onto the map.
  void Refit(const PlanTransform& start, FittedPieces& fitted) const {
    fitted.corrected = nullptr;
    fitted.evidence = std::make_unique<const MapEvidence>(EvidenceOf(fitted.mapped.grid));
    fitted.alignment = AlignFrom(plan_, *fitted.evidence, start, {});
    fitted.corrected = std::make_unique<const CorrectedPlan>(plan_, *fitted.evidence, fitted.alignment.T_map_sheet);
    MeasureSelf(fitted);
    Report(fitted);
  }

  void Report(const FittedPieces& c) const {
    if (!std::getenv("VERBOSE")) return;
    std::fprintf(stderr, "placed %.3f/%.3f %s corrected %.3f/%.3f self %.4f (%.0f)\n", c.alignment.agreement.explained,
                 c.alignment.agreement.contradicted(), std::string(NameOf(c.alignment.model)).c_str(),
                 c.corrected->agreement().explained, c.corrected->agreement().contradicted(), c.self, c.self_known);
    if (!std::getenv("DUMP")) return;
    static int number = 0;
    std::FILE* f = std::fopen(fmt::format("{}/{:02d}.txt", std::getenv("DUMP"), number++).c_str(), "w");
    for (const slam::StampedPose& p : slam::TrajectoryOf(c.mapped.map))
      std::fprintf(f, "%.9f %f %f %f\n", ToSeconds(p.time), p.T_map_robot.x, p.T_map_robot.y, p.T_map_robot.yaw);
    std::fclose(f);
  }

  absl::StatusOr<FittedPieces> Fitted(MappedLog mapped, const PlanTransform& start) const {
    FittedPieces fitted;
    fitted.mapped = std::move(mapped);
    ENFILADE_ASSIGN_OR_RETURN(fitted.cut, CutIntoPieces(fitted.mapped.map, scans_, options_));
    for (const MapPiece& piece : fitted.cut.pieces) fitted.T_map_pieces.push_back(piece.T_map_piece);
    Refit(start, fitted);
    return fitted;
  }

  // The pieces moved by what they have seen of the plan: of all rounds the one in which the map agrees most with the
  // plan and with itself.
  absl::StatusOr<FittedPieces> Tied(const FittedPieces& from) const {
    FittedPieces best;
    FittedPieces last;
    const FittedPieces* before = &from;
    std::vector<PieceLink> stated = from.cut.links;
    for (PieceLink& link : stated) {
      if (!link.is_closure) AddBending(1.0, link);
    }
    double least = 1e9;
    for (int round = 0; round < kTieRounds; ++round) {
      FittedPieces next;
      next.mapped.map = from.mapped.map;
      next.cut = from.cut;
      std::vector<MapOfPlan> maps;
      for (std::size_t i = 0; i < next.cut.pieces.size(); ++i) {
        maps.push_back({next.cut.pieces[i].id, &next.cut.pieces[i].evidence, before->T_map_pieces[i]});
      }
      const graph::PlanTies ties = FindTies(plan_, before->alignment.T_map_sheet, *before->corrected, maps);
      std::size_t loosened = 0;
      for (std::size_t i = 0; i < stated.size(); ++i) {
        PieceLink& link = next.cut.links[i];
        link = stated[i];
        if (link.is_closure) continue;
        const double chi2 = round == 0 ? 0 : Chi2Of(link, before->T_map_pieces);
        if (chi2 > kLooseChi2) {
          link.covariance *= chi2 / 3;
          ++loosened;
        } else {
          AddBending(kFirstLooseness * std::pow(0.5, round), link);
        }
      }
      ENFILADE_ASSIGN_OR_RETURN(const SolvedPieces solved, SolvePieces(next.cut, ties));
      if (std::getenv("VERBOSE"))
        std::fprintf(stderr, "round %d: pieces %zu links %zu ties %zu used %d off %d [%s] loosened %zu corner %.3f\n",
                     round, next.cut.pieces.size(), stated.size(), ties.sightings.size(), solved.use.used,
                     solved.use.switched_off, solved.use.contradiction.c_str(), loosened, ties.corner_sigma);
      next.objection = solved.use.contradiction;
      if (next.objection.empty() &&
          static_cast<double>(loosened) > kMostLoosened * static_cast<double>(stated.size())) {
        next.objection = fmt::format("{} of {} stretches of the drive would have to be bent", loosened, stated.size());
      }
      next.cut.links = from.cut.links;
      next.T_map_pieces = solved.T_map_piece;
      next.mapped.grid = RenderPieces(next.cut.pieces, next.T_map_pieces, options_);
      next.mapped.map = WithPieces(std::move(next.mapped.map), next.cut.pieces, next.T_map_pieces);
      Refit(before->alignment.T_map_sheet, next);
      if (next.objection.empty()) next.objection = ObjectionOfClosures(stated, from.T_map_pieces, next.T_map_pieces);
      const double loss = next.disagreement() + (1 - next.self) + (next.objection.empty() ? 0 : 10);
      last = std::move(next);
      before = &last;
      if (loss < least) {
        least = loss;
        ENFILADE_ASSIGN_OR_RETURN(best, Copy(last));
      }
    }
    return best;
  }

  absl::StatusOr<FittedPieces> Copy(const FittedPieces& from) const {
    FittedPieces copy;
    copy.mapped = from.mapped;
    copy.cut = from.cut;
    copy.T_map_pieces = from.T_map_pieces;
    copy.objection = from.objection;
    copy.alignment = from.alignment;
    copy.evidence = std::make_unique<const MapEvidence>(*from.evidence);
    copy.corrected = std::make_unique<const CorrectedPlan>(plan_, *copy.evidence, copy.alignment.T_map_sheet);
    copy.self = from.self;
    copy.self_known = from.self_known;
    return copy;
  }

  // Loop closures are matches that were checked: a plan that they contradict is wrong.
  static std::string ObjectionOfClosures(const std::vector<PieceLink>& links, const std::vector<Pose2>& before,
                                         const std::vector<Pose2>& after) {
    double chi2_before = 0, chi2_after = 0;
    int closures = 0;
    for (const PieceLink& link : links) {
      if (!link.is_closure) continue;
      ++closures;
      chi2_before += Chi2Of(link, before);
      chi2_after += Chi2Of(link, after);
    }
    if (closures == 0) return "";
    const double limit = std::max(graph::ChiSquaredQuantile(0.999, 3 * closures), 1.1 * chi2_before);
    if (chi2_after <= limit) return "";
    return fmt::format("{} loop closures disagree with it: chi-squared {:.0f}, at most {:.0f}", closures, chi2_after,
                       limit);
  }

  absl::StatusOr<FittedPieces> Guided(const PlanTrack& track, const PlanTransform& start) const {
    std::vector<sensor::PairedScan> scans = scans_;
    for (std::size_t i = 0; i < scans.size(); ++i) scans[i].T_odom_robot = track.T_map_robot[i];
    return Fitted(MapLog(scans, GuidedOptions(options_)), start);
  }

  absl::StatusOr<FittedPieces> Tracked(const FittedPieces& without) const {
    PlanTransform start = without.alignment.T_map_sheet;
    ENFILADE_ASSIGN_OR_RETURN(const PlanTrack track, TrackFromStart(without, start));
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces best, Guided(track, start));
    for (int round = 1; round < kTrackRounds; ++round) {
      ENFILADE_ASSIGN_OR_RETURN(FittedPieces next, Guided(TrackInPlan(best.corrected->faces(), scans_, {}, options_),
                                                          best.alignment.T_map_sheet));
      if (next.disagreement() < best.disagreement()) best = std::move(next);
    }
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces tied, Tied(best));
    if (tied.objection.empty() && ObjectionTo(tied, best).empty()) return tied;
    return best;
  }

  // Where the plan lies, SLAM's map can only say while SLAM is not yet lost: of the places by the whole map, by its
  // first parts and by the pairs alone, the one is taken from which the robot can be followed best. `start`: the first,
  // and the best.
  absl::StatusOr<PlanTrack> TrackFromStart(const FittedPieces& without, PlanTransform& start) const {
    std::vector<PlanTransform> starts = {start};
    if (!fitting_.pairs.empty()) {
      Eigen::AlignedBox2d box;
      for (const PlanCorner& corner : plan_.corners) box.extend(corner.point);
      ENFILADE_ASSIGN_OR_RETURN(const PairFit pairs, FitPairs(fitting_.pairs, box.diagonal().norm()));
      starts.push_back(pairs.T_map_sheet);
    }
    for (const std::size_t count : {4, 8, 16}) {
      if (count >= without.cut.pieces.size() || fitting_.pairs.empty()) break;
      const auto end = static_cast<std::ptrdiff_t>(count);
      const std::vector<MapPiece> pieces(without.cut.pieces.begin(), without.cut.pieces.begin() + end);
      const MapEvidence evidence = EvidenceOf(RenderPieces(pieces, without.T_map_pieces, options_));
      if (evidence.walls.empty()) continue;
      AlignOptions aligning;
      aligning.widest_model = TransformModel::kSimilarity;
      ENFILADE_ASSIGN_OR_RETURN(const Alignment alignment, AlignByPairs(plan_, evidence, fitting_.pairs, aligning));
      starts.push_back(alignment.T_map_sheet);
    }
    PlanTrack best;
    for (const PlanTransform& place : starts) {
      PlanTrack track = TrackInPlan(Transformed(FacesOf(plan_), place), scans_, {}, options_);
      if (std::getenv("VERBOSE"))
        std::fprintf(stderr, "start scale %.5f share %.3f\n", place.scale(), track.matched_share);
      if (track.matched_share <= best.matched_share) continue;
      best = std::move(track);
      start = place;
    }
    return best;
  }

  const PlanGraph& plan_;
  const std::vector<sensor::PairedScan>& scans_;
  const FitOptions& fitting_;
  const slam::SlamOptions& options_;
};

}  // namespace

absl::StatusOr<MapWithPlan> MapLogWithPlan(const PlanGraph& plan, const std::vector<sensor::PairedScan>& scans,
                                           const FitOptions& fitting, const slam::SlamOptions& options) {
  return PlanMapper(plan, scans, fitting, options).Run();
}

}  // namespace enfilade::prior

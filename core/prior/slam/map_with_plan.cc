// SPDX-License-Identifier: Apache-2.0
#include "core/prior/slam/map_with_plan.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "core/base/status_macros.h"
#include "core/graph/chi_squared.h"
#include "core/prior/slam/map_pieces.h"
#include "core/prior/slam/piece_graph.h"
#include "core/prior/slam/plan_tracking.h"
#include "core/prior/ties/find_ties.h"
#include "fmt/format.h"

namespace enfilade::prior {
namespace {

constexpr int kTieRounds = 4;
constexpr int kTrackRounds = 2;
// A piece bends a little: these deviations are added to what is stated of a link, for each and for each metre of it.
constexpr double kBend = 0.01;            // m
constexpr double kBendPerMetre = 0.005;   // m
constexpr double kTurn = 0.005;           // rad
constexpr double kTurnPerMetre = 0.0025;  // rad
// In the first round so much more again, half as much in each further one.
constexpr double kFirstLooseness = 1.0;
constexpr double kLooseChi2 = 11.34;       // 99 %, 3 degrees of freedom
constexpr double kMostLoosened = 1.0 / 3;  // of all links
// The same place, seen by other pieces.
constexpr double kSelfRange = 10;  // m, between their first keyframes
constexpr std::size_t kNeighbours = 3;
constexpr double kSameWall = 0.12;  // m
constexpr double kLeastSelf = 300;  // points that other pieces know, to say anything
// A plan's size in the map may differ from that by the pairs so much, and three deviations of the clicks.
constexpr double kMostScaleError = 0.05;

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

  const Agreement& agreement() const { return alignment.agreement; }
  // What of the map and of the plan the other does not agree with.
  double disagreement() const { return 1 - agreement().explained + agreement().contradicted(); }
  // And what the map does not agree with itself.
  double loss() const { return disagreement() + 1 - self; }
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

// Of a log whose odometry is the path through the plan. From scan to scan that is known to a centimetre, and better
// than by matching: in a bare corridor matches are too short, because what a short-sighted robot sees moves with it.
slam::SlamOptions GuidedOptions(slam::SlamOptions options) {
  options.motion.translation_floor = 0.01;
  options.motion.translation_per_metre = 0.01;
  options.motion.yaw_floor = 0.02;
  options.motion.yaw_per_metre = 0.01;
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
    ENFILADE_RETURN_IF_ERROR(LearnScale());
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces without, Fitted(result.mapped, fit.alignment.T_map_sheet));
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces best, Tied(without));
    ENFILADE_ASSIGN_OR_RETURN(FittedPieces tracked, Tracked(without));
    const bool is_better = HasWrongScale(best) ? !HasWrongScale(tracked) : tracked.loss() < best.loss();
    if (is_better) best = std::move(tracked);
    result.reason = best.objection.empty() ? ObjectionTo(best, without) : best.objection;
    result.corrected = result.reason.empty();
    if (!result.corrected) return result;
    result.mapped = std::move(best.mapped);
    result.reason = fmt::format(
        "the plan explains {:.0f} % of the map's walls, {:.0f} % before; of walls that were seen again {:.1f} % lie "
        "where "
        "they did, {:.1f} % before",
        100 * best.agreement().explained, 100 * without.agreement().explained, 100 * best.self, 100 * without.self);
    return result;
  }

 private:
  // Where nothing shows how far a robot has driven, SLAM may shorten a corridor, and the plan would shrink with it.
  absl::Status LearnScale() {
    if (fitting_.pairs.empty()) return absl::OkStatus();
    ENFILADE_ASSIGN_OR_RETURN(T_map_sheet_by_pairs_, PlaceByPairs());
    for (const ControlPair& a : fitting_.pairs) {
      for (const ControlPair& b : fitting_.pairs) {
        const double apart = (a.point_map - b.point_map).norm();
        if (apart > apart_) far_pairs_ = {a, b}, apart_ = apart;
      }
    }
    most_scale_error_ = kMostScaleError + 3 * std::sqrt(2.0) * kClickSigma / apart_;
    return absl::OkStatus();
  }

  absl::StatusOr<PlanTransform> PlaceByPairs() const {
    Eigen::AlignedBox2d box;
    for (const PlanCorner& corner : plan_.corners) box.extend(corner.point);
    ENFILADE_ASSIGN_OR_RETURN(const PairFit pairs, FitPairs(fitting_.pairs, box.diagonal().norm()));
    return pairs.T_map_sheet;
  }

  // How long the corrected plan is between the two pairs that lie farthest apart, by what people have shown; 1 without
  // pairs.
  double ScaleError(const FittedPieces& fitted) const {
    if (!T_map_sheet_by_pairs_) return 1.0;
    const auto lies = [&](const ControlPair& pair) { return fitted.corrected->Locate(pair.point_sheet).point; };
    return (lies(far_pairs_[0]) - lies(far_pairs_[1])).norm() / apart_;
  }
  bool HasWrongScale(const FittedPieces& fitted) const {
    return std::abs(std::log(ScaleError(fitted))) > most_scale_error_;
  }

  // Why the map is better left as it is; empty: it is not.
  std::string ObjectionTo(const FittedPieces& next, const FittedPieces& without) const {
    if (HasWrongScale(next)) {
      return fmt::format("the plan would be {:.2f} times as large as by the pairs", ScaleError(next));
    }
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
        "were "
        "seen again {:.1f} % would lie where they did, {:.1f} % without",
        100 * agreement.explained, 100 * without.agreement().explained, 100 * next.self, 100 * without.self);
  }

  // Moves the plan onto the map.
  void Refit(const PlanTransform& start, FittedPieces& fitted) const {
    fitted.corrected = nullptr;
    fitted.evidence = std::make_unique<const MapEvidence>(EvidenceOf(fitted.mapped.grid));
    fitted.alignment = AlignFrom(plan_, *fitted.evidence, start, {});
    fitted.corrected = std::make_unique<const CorrectedPlan>(plan_, *fitted.evidence, fitted.alignment.T_map_sheet);
    MeasureSelf(fitted);
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
    std::shared_ptr<FittedPieces> best;
    std::shared_ptr<FittedPieces> last;  // keeps what `before` points to
    const FittedPieces* before = &from;
    std::vector<PieceLink> stated = from.cut.links;
    for (PieceLink& link : stated) {
      if (!link.is_closure) AddBending(1.0, link);
    }
    double least = 0;
    for (int round = 0; round < kTieRounds; ++round) {
      auto tied = std::make_shared<FittedPieces>();
      FittedPieces& next = *tied;
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
      const double loss = next.loss() + (next.objection.empty() ? 0 : 10);
      if (!best || loss < least) {
        least = loss;
        best = tied;
      }
      last = std::move(tied);
      before = last.get();
    }
    return std::move(*best);
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
    if (T_map_sheet_by_pairs_) starts.push_back(*T_map_sheet_by_pairs_);
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
  std::optional<PlanTransform> T_map_sheet_by_pairs_;
  std::array<ControlPair, 2> far_pairs_;
  double apart_ = 0;             // m, between them in the map
  double most_scale_error_ = 0;  // of its logarithm
};

}  // namespace

absl::StatusOr<MapWithPlan> MapLogWithPlan(const PlanGraph& plan, const std::vector<sensor::PairedScan>& scans,
                                           const FitOptions& fitting, const slam::SlamOptions& options) {
  return PlanMapper(plan, scans, fitting, options).Run();
}

}  // namespace enfilade::prior

// SPDX-License-Identifier: Apache-2.0
#include "core/prior/fit/fit_plan.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/fit/join_maps.h"

namespace enfilade::prior {
namespace {

constexpr int kJoinRounds = 2;  // of moving maps onto the plan, and the plan onto the maps
// Of the walls that two maps know, in free ground of one. At right places it was up to 5 % in simulated buildings, up
// to 6 % in an apartment that three robots have mapped; at wrong places, 6 % and more.
constexpr double kUsuallyContradicted = 0.03;
constexpr double kMostContradictedByMaps = 0.1;

constexpr std::pair<FitMode, std::string_view> kNames[] = {{FitMode::kFull, "full"},
                                                           {FitMode::kAcg, "acg"},
                                                           {FitMode::kSimilarity, "similarity"},
                                                           {FitMode::kAffine, "affine"}};

AlignOptions AlignOptionsOf(FitMode mode, int threads) {
  AlignOptions options;
  options.log_evidence = &LogEvidenceOf;
  options.threads = threads;
  // ACG places a plan by a similarity.
  if (mode == FitMode::kSimilarity || mode == FitMode::kAcg) options.widest_model = TransformModel::kSimilarity;
  if (mode == FitMode::kAffine) options.most_left = 1;  // whatever fits no worse
  return options;
}

Correction CorrectionOf(FitMode mode) {
  if (mode == FitMode::kFull) return Correction::kField;
  return mode == FitMode::kAcg ? Correction::kWallSprings : Correction::kNone;
}

// People, too, can show a place on the wrong plan. Why the corrected plan cannot be that of the map; empty: it can.
// What the map has beside the plan's area says nothing.
std::string ObjectionToCorrected(const CorrectedPlan& corrected, const MapEvidence& evidence) {
  constexpr double kBeside = 1.0;            // m
  constexpr double kLeastExplained = 0.35;   // of the map's walls there
  constexpr double kMostContradicted = 0.2;  // of the plan's walls that the map knows
  Eigen::AlignedBox2d area;
  for (const WallFace& face : corrected.faces()) area.extend(face.from).extend(face.to);
  MapEvidence there = evidence;
  std::erase_if(there.walls, [&](const WallPoint& wall) { return area.exteriorDistance(wall.point) > kBeside; });
  const Agreement agreement = Compare(FaceIndex(corrected.faces(), kBeside), there);
  if (agreement.explained < kLeastExplained) {
    return fmt::format("at that place the plan explains {:.0f} % of the map's walls, {:.0f} % are needed",
                       100 * agreement.explained, 100 * kLeastExplained);
  }
  if (agreement.contradicted() > kMostContradicted) {
    return fmt::format(
        "at that place {:.0f} % of the plan's walls that the map knows lie in free ground, at most {:.0f} % may",
        100 * agreement.contradicted(), 100 * kMostContradicted);
  }
  return "";
}

class PlanFitter {
 public:
  PlanFitter(const PlanGraph& plan, const std::vector<grid::OccupancyGrid>& maps, const FitOptions& options)
      : plan_(plan), maps_(maps), options_(options), aligning_(AlignOptionsOf(options.mode, options.threads)) {}

  absl::StatusOr<PlanFit> Run() {
    if (maps_.empty()) return InvalidArgument("fitting a plan: no map");
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      evidence_.push_back(EvidenceOf(maps_[i]));
      if (evidence_.back().walls.empty()) return InvalidArgument("map {} has no walls", i + 1);
    }
    ENFILADE_RETURN_IF_ERROR(AlignEach());
    fit_.alignment = fit_.maps.front().alignment;
    if (fit_.alignment.accepted) ENFILADE_RETURN_IF_ERROR(JoinAccepted());
    // Other modes are for comparison, and correct less.
    if (fit_.corrected && !options_.pairs.empty() && options_.mode == FitMode::kFull) CheckShown();
    if (fit_.corrected) fit_.added = FindAddedWalls(*fit_.corrected, *fit_.evidence);
    return std::move(fit_);
  }

 private:
  absl::Status AlignEach() {
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      Alignment alignment;
      if (i == 0 && options_.start) {
        alignment = AlignFrom(plan_, evidence_[i], *options_.start, aligning_);
      } else if (i == 0 && !options_.pairs.empty()) {
        ENFILADE_ASSIGN_OR_RETURN(alignment, AlignByPairs(plan_, evidence_[i], options_.pairs, aligning_));
      } else {
        alignment = AlignByItself(plan_, evidence_[i], aligning_);
      }
      fit_.maps.push_back({std::move(alignment)});
    }
    const auto surest = std::max_element(fit_.maps.begin(), fit_.maps.end(), [](const auto& a, const auto& b) {
      if (a.alignment.accepted != b.alignment.accepted) return b.alignment.accepted;
      return a.alignment.agreement.explained_length < b.alignment.agreement.explained_length;
    });
    if (!surest->alignment.accepted) return absl::OkStatus();
    AlignOptions known = aligning_;
    known.known_shape = surest->alignment.T_map_sheet;
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      if (i == 0 && (fit_.maps[i].alignment.accepted || options_.start)) continue;
      fit_.maps[i].alignment = AlignByItself(plan_, evidence_[i], known);
    }
    return absl::OkStatus();
  }

  // The accepted maps but the first, those first of which the plan explains most.
  std::vector<std::size_t> SurestFirst() const {
    std::vector<std::size_t> maps;
    for (std::size_t i = 1; i < maps_.size(); ++i) {
      if (fit_.maps[i].alignment.accepted) maps.push_back(i);
    }
    std::stable_sort(maps.begin(), maps.end(), [&](std::size_t a, std::size_t b) {
      return fit_.maps[a].alignment.agreement.explained_length > fit_.maps[b].alignment.agreement.explained_length;
    });
    return maps;
  }

  // The frame is the first map's.
  absl::Status JoinAccepted() {
    fit_.maps.front().T_first_map = Pose2{};
    for (const std::size_t i : SurestFirst()) {
      Alignment& alignment = fit_.maps[i].alignment;
      const Pose2 place = JoinByPlan(evidence_[i], alignment.T_map_sheet, fit_.alignment.T_map_sheet);
      ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid others, Overlaid(PlacedWithout(i)));
      const double contradicted = ContradictedShare(evidence_[i], EvidenceOf(others), place);
      const bool is_doubtful = contradicted > kUsuallyContradicted && alignment.log_odds < aligning_.least_evidence;
      if (!is_doubtful && contradicted <= kMostContradictedByMaps) {
        fit_.maps[i].T_first_map = place;
        continue;
      }
      alignment.accepted = false;
      alignment.reason = fmt::format(
          "at that place {:.0f} % of the walls that it and other maps know lie in free ground, at most {:.0f} % may",
          100 * contradicted, 100 * (is_doubtful ? kUsuallyContradicted : kMostContradictedByMaps));
    }
    ENFILADE_RETURN_IF_ERROR(Correct());
    for (int round = 0; maps_.size() > 1 && round < kJoinRounds; ++round) {
      for (std::size_t i = 1; i < maps_.size(); ++i) {
        std::optional<Pose2>& place = fit_.maps[i].T_first_map;
        if (!place) continue;
        ENFILADE_ASSIGN_OR_RETURN(const grid::OccupancyGrid others, Overlaid(PlacedWithout(i)));
        place = RefineAmong(evidence_[i], EvidenceOf(others), *fit_.corrected, *place);
      }
      ENFILADE_RETURN_IF_ERROR(Correct());
    }
    return absl::OkStatus();
  }

  void CheckShown() {
    const std::string objection = ObjectionToCorrected(*fit_.corrected, *fit_.evidence);
    if (objection.empty()) return;
    fit_.alignment.accepted = false;
    fit_.alignment.reason = objection;
    fit_.maps.front().alignment = fit_.alignment;
    for (FittedMap& map : fit_.maps) map.T_first_map.reset();
    fit_.corrected = nullptr;
    fit_.evidence = nullptr;
    fit_.map = {};
  }

  std::vector<PlacedMap> PlacedWithout(std::optional<std::size_t> left_out) const {
    std::vector<PlacedMap> placed;
    for (std::size_t i = 0; i < maps_.size(); ++i) {
      const std::optional<Pose2>& place = fit_.maps[i].T_first_map;
      if (place && i != left_out) placed.push_back({&maps_[i], &evidence_[i], *place});
    }
    return placed;
  }

  // With all maps where they are now.
  absl::Status Correct() {
    const std::vector<PlacedMap> placed = PlacedWithout(std::nullopt);
    if (placed.size() == 1) {
      fit_.map = maps_.front();
    } else {
      ENFILADE_ASSIGN_OR_RETURN(fit_.map, Overlaid(placed));
    }
    fit_.corrected = nullptr;
    fit_.evidence = std::make_unique<MapEvidence>(EvidenceOf(fit_.map));
    if (placed.size() > 1) {
      Alignment all = AlignFrom(plan_, *fit_.evidence, fit_.alignment.T_map_sheet, aligning_);
      all.accepted = true;  // as the first map has it
      all.reason = fit_.alignment.reason;
      all.rival_ratio = fit_.alignment.rival_ratio;
      fit_.alignment = std::move(all);
    }
    fit_.corrected =
        std::make_unique<CorrectedPlan>(plan_, *fit_.evidence, fit_.alignment.T_map_sheet, CorrectionOf(options_.mode));
    return absl::OkStatus();
  }

  const PlanGraph& plan_;
  const std::vector<grid::OccupancyGrid>& maps_;
  const FitOptions& options_;
  const AlignOptions aligning_;
  std::vector<MapEvidence> evidence_;
  PlanFit fit_;
};

}  // namespace

std::string_view NameOf(FitMode mode) {
  return std::find_if(std::begin(kNames), std::end(kNames), [&](const auto& one) { return one.first == mode; })->second;
}

std::optional<FitMode> FitModeFrom(std::string_view name) {
  for (const auto& [mode, of_mode] : kNames) {
    if (of_mode == name) return mode;
  }
  return std::nullopt;
}

absl::StatusOr<PlanFit> FitPlan(const PlanGraph& plan, const std::vector<grid::OccupancyGrid>& maps,
                                const FitOptions& options) {
  return PlanFitter(plan, maps, options).Run();
}

}  // namespace enfilade::prior

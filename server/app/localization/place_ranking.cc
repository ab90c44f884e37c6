// SPDX-License-Identifier: Apache-2.0
#include "server/app/localization/place_ranking.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/closure/closure_options.h"
#include "perception/image/decode.h"
#include "perception/image/feature_codec.h"
#include "perception/image/match_images.h"
#include "server/app/closure/place_comparer.h"
#include "server/app/localization/call_progress.h"

namespace enfilade::server {
namespace {

constexpr int kImagesCompared = 2;  // of each camera of each anchor, the nearest to the door's moment
constexpr std::size_t kPlacesAtOnce = 100;

std::vector<LinkPointId> PlacesOf(const graph::GraphSnapshot& graph, const PlaceFilter& filter) {
  std::vector<LinkPointId> places;
  for (const graph::LinkPoint* link_point : graph.ListLinkPoints()) {
    const bool may_be =
        std::any_of(link_point->anchors.begin(), link_point->anchors.end(), [&](const graph::Anchor& anchor) {
          const graph::MapInGraph* map = graph.FindMap(anchor.map);
          return (!filter.map || filter.joined_maps || anchor.map == *filter.map) &&
                 (!filter.level || (map != nullptr && map->level == *filter.level));
        });
    if (may_be) places.push_back(link_point->id);
  }
  return places;
}

// The first kImagesCompared of each place, map and camera.
std::vector<storage::Evidence> ImagesOf(std::vector<storage::Evidence> evidence) {
  std::map<std::tuple<LinkPointId, MapId, storage::EvidenceKind>, int> counts;
  std::erase_if(evidence, [&](const storage::Evidence& item) {
    return item.kind == storage::EvidenceKind::kCloud ||
           ++counts[{item.link_point, item.map, item.kind}] > kImagesCompared;
  });
  return evidence;
}

RankedPlace PlaceOf(const storage::Evidence& item, const perception::ImageMatch& match, sensor::Camera camera) {
  RankedPlace place{item.link_point, item.map, item.T_map_robot, match.inliers, match.accepted};
  const bool was_front = item.kind == storage::EvidenceKind::kFrontImage;
  if (place.T_map_view && was_front != (camera == sensor::Camera::kFront)) {
    *place.T_map_view = *place.T_map_view * Pose2{0.0, 0.0, M_PI};
  }
  return place;
}

bool IsBetter(const RankedPlace& a, const RankedPlace& b) {
  if (a.accepted != b.accepted) return a.accepted;
  return a.matches > b.matches;
}

}  // namespace

absl::StatusOr<std::optional<perception::FeatureSet>> PlaceRanking::FeaturesOf(const storage::CallContext& context,
                                                                               const SiteId& site,
                                                                               const sensor::BlobRef& image) const {
  ENFILADE_ASSIGN_OR_RETURN(const std::string kept, stores_.features.Find(context, site, image.sha256));
  if (!kept.empty()) {
    auto decoded = perception::DecodeFeatures(kept);
    if (decoded.ok()) return std::optional<perception::FeatureSet>(*std::move(decoded));
  }
  const auto bytes = stores_.blobs.Get(context, site, image.sha256);
  if (absl::IsNotFound(bytes.status())) return std::optional<perception::FeatureSet>();
  ENFILADE_RETURN_IF_ERROR(bytes.status());
  const auto frame = perception::DecodeGrey(*bytes);
  auto features = frame.ok() ? perception::ExtractFeatures(*frame) : frame.status();
  if (!features.ok()) return std::optional<perception::FeatureSet>();  // damaged: it resembles nothing
  ENFILADE_RETURN_IF_ERROR(stores_.features.Put(context, site, image.sha256, perception::EncodeFeatures(*features)));
  return std::optional<perception::FeatureSet>(*std::move(features));
}

absl::StatusOr<std::vector<RankedPlace>> PlaceRanking::Rank(const storage::CallContext& context, const SiteId& site,
                                                            const graph::GraphSnapshot& graph,
                                                            const PlaceFilter& filter, const QueryImage& image) const {
  const auto frame = perception::DecodeGrey(image.content);
  if (!frame.ok()) return InvalidArgument("image: {}", std::string(frame.status().message()));
  ENFILADE_ASSIGN_OR_RETURN(const perception::FeatureSet features, perception::ExtractFeatures(*frame));
  const int count = static_cast<int>(features.sift.size() + features.akaze.size());
  if (const int least = closure::DoorClosureOptions().min_features; count < least) {
    return InvalidArgument("image: it shows nothing to recognise: {} features, fewer than {}", count, least);
  }
  const std::vector<LinkPointId> places = PlacesOf(graph, filter);
  const perception::ImageMatchOptions options = ImageMatchOptionsOf(closure::DoorClosureOptions());
  std::map<std::pair<LinkPointId, MapId>, RankedPlace> best;
  for (std::size_t begin = 0; begin < places.size(); begin += kPlacesAtOnce) {
    const std::vector<LinkPointId> portion(
        places.begin() + static_cast<std::ptrdiff_t>(begin),
        places.begin() + static_cast<std::ptrdiff_t>(std::min(places.size(), begin + kPlacesAtOnce)));
    ENFILADE_ASSIGN_OR_RETURN(auto evidence, stores_.link_points.ListEvidence(context, site, portion));
    for (const storage::Evidence& item : ImagesOf(std::move(evidence))) {
      ENFILADE_RETURN_IF_ERROR(CheckProgress(context));
      ENFILADE_ASSIGN_OR_RETURN(const auto kept, FeaturesOf(context, site, item.content));
      if (!kept) continue;
      ENFILADE_ASSIGN_OR_RETURN(const perception::ImageMatch match, perception::MatchImages(*kept, features, options));
      if (match.inliers == 0) continue;
      const RankedPlace place = PlaceOf(item, match, image.camera);
      const auto [known, is_new] = best.try_emplace({item.link_point, item.map}, place);
      if (!is_new && IsBetter(place, known->second)) known->second = place;
    }
  }
  std::vector<RankedPlace> ranked;
  for (auto& [key, place] : best) ranked.push_back(std::move(place));
  std::stable_sort(ranked.begin(), ranked.end(), IsBetter);
  return ranked;
}

}  // namespace enfilade::server

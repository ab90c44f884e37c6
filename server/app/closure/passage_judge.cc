#include "server/app/closure/passage_judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/base/uuid.h"
#include "core/graph/global_pose.h"
#include "core/graph/pose_chain.h"
#include "core/graph/search_radius.h"
#include "server/app/closure/report_judge.h"

namespace enfilade::server {
namespace {

TimeNs Seconds(double seconds) { return static_cast<TimeNs>(seconds * static_cast<double>(kNsPerSecond)); }

std::optional<Pose2> PoseOf(const std::optional<PoseWithCovariance>& pose) {
  return pose ? std::optional<Pose2>(pose->pose) : std::nullopt;
}

// What the robot saw between the door and its report: of what lies behind.
absl::StatusOr<ViewsBehind> LookBehind(const CallContext& context, const PassageScene& passage, StoredViews& views,
                                       std::vector<std::int64_t>& seen) {
  const DoorReport& report = passage.report;
  ViewsBehind behind;
  const TimeNs late = report.time + Seconds(0.5);
  for (const Camera camera : {Camera::kFront, Camera::kRear}) {
    for (const auto& image :
         passage.scene.ImagesNear(camera, report.time, report.door_time, late, passage.options.images_now)) {
      ENFILADE_ASSIGN_OR_RETURN(const auto* features, views.Features(context, image.image.content, /*keep=*/false));
      seen.push_back(image.sequence);
      if (features == nullptr) continue;
      (camera == Camera::kFront ? behind.ahead : behind.back).push_back(features);
    }
    if (!behind.ahead.empty()) break;  // the rear camera is only for robots without
  }
  const auto cloud = passage.scene.CloudNear(report.time, report.door_time, late);
  if (!cloud) return behind;
  const auto T_map_cloud = passage.scene.PoseAt(cloud->cloud.time);
  if (!T_map_cloud) return behind;
  seen.push_back(cloud->sequence);
  ENFILADE_ASSIGN_OR_RETURN(behind.cloud, views.Points(context, cloud->cloud.content, cloud->cloud.encoding));
  behind.T_cloud_robot = Between(T_map_cloud->pose, passage.T_map_robot.pose);
  behind.beyond = (T_map_cloud->pose.translation() - passage.T_map_door.pose.translation()).norm();
  return behind;
}

// The evidence of one anchor.
std::vector<Evidence> Of(const std::vector<Evidence>& all, const LinkPointId& link_point, const MapId& map) {
  std::vector<Evidence> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const Evidence& item) { return item.link_point == link_point && item.map == map; });
  return found;
}

bool IsOnLevel(const PassageScene& passage, const MapId& map) {
  const MapInGraph* found = passage.graph.graph().FindMap(map);
  return found != nullptr && found->level == passage.report.entered_level.value_or(passage.map.level);
}

// The map behind a link point of this map: the one on the level that was entered, the latest made where there are more.
const Anchor* FindBehind(const PassageScene& passage, const LinkPoint& link_point) {
  const Anchor* behind = nullptr;
  for (const Anchor& anchor : link_point.anchors) {
    if (anchor.map == passage.map.id) continue;
    if (behind == nullptr || IsOnLevel(passage, anchor.map)) behind = &anchor;
  }
  return behind;
}

void Recognise(const LinkPoint& link_point, const MapId& map, const PoseWithCovariance& T_map_robot, std::string why,
               DoorVerdict& verdict) {
  verdict.decision = DoorDecision::kLinkPointRecognised;
  verdict.link_point = link_point.id;
  verdict.entered_map = map;
  verdict.T_map_robot = T_map_robot;
  verdict.reason = std::move(why);
}

// A link point of this very map. True where it is one.
absl::StatusOr<bool> TryPassed(const CallContext& context, const PassageScene& passage,
                               const std::vector<KnownPlace>& passed, const ViewsBehind& behind, StoredViews& views,
                               DoorChange& change, std::set<LinkPointId>& contradicted) {
  for (const KnownPlace& known : passed) {
    if (known.link_point->is_candidate()) continue;
    const Anchor* anchor = FindBehind(passage, *known.link_point);
    if (anchor == nullptr) continue;
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    const auto T_map_robot = PoseBehind(*known.link_point, passage.map.id, anchor->map, passage.T_map_robot);
    ENFILADE_ASSIGN_OR_RETURN(
        auto evidence, passage.stores.link_points.ListEvidence(context, passage.map.site, {known.link_point->id}));
    const Place place{.link_point = known.link_point,
                      .anchor = anchor,
                      .evidence = Of(evidence, known.link_point->id, anchor->map),
                      .distance = known.distance,
                      .predicted = T_map_robot};
    ENFILADE_ASSIGN_OR_RETURN(PlaceEvidence compared, CompareImages(context, place, behind, passage.options, views));
    // The images agree and the pose is right: clouds would add nothing.
    if (!compared.images || !compared.images->agree) {
      ENFILADE_RETURN_IF_ERROR(CompareClouds(context, place, behind, passage.options, views, compared));
    }
    const JudgedPlace judged = JudgePlace(compared, passage.options);
    DoorComparison comparison = ToComparison(compared, judged);
    const bool refused = Contradicted(compared, passage.options);
    comparison.accepted = !refused;
    comparison.chi2 = known.chi2;
    comparison.reason =
        known.reason + (refused ? "; but what the robot sees contradicts it: " : "; ") + judged.witnesses;
    change.verdict.comparisons.push_back(comparison);
    if (refused) {
      contradicted.insert(known.link_point->id);
      continue;
    }
    Recognise(*known.link_point, anchor->map, *T_map_robot, change.verdict.comparisons.back().reason, change.verdict);
    return true;
  }
  return false;
}

// Places of other maps that the robot may have come to: within the search radius, or where no link points lead there.
// Those that are in reach first, the nearest first.
absl::StatusOr<std::vector<Place>> FindPlaces(const CallContext& context, const PassageScene& passage,
                                              const std::set<LinkPointId>& not_these) {
  const GraphSnapshot& graph = passage.graph.graph();
  std::map<MapId, std::optional<PoseWithCovariance>> transforms;  // T_other_this
  std::vector<Place> places;
  for (const LinkPoint* link_point : graph.ListLinkPoints()) {
    if (link_point->use == LinkPointUse::kSuspended || not_these.contains(link_point->id)) continue;
    if (link_point->is_candidate() && passage.excluded.contains(link_point->id)) continue;
    for (const Anchor& anchor : link_point->anchors) {
      if (anchor.map == passage.map.id || !IsOnLevel(passage, anchor.map)) continue;
      auto [found, is_new] = transforms.try_emplace(anchor.map);
      if (is_new) {
        ENFILADE_ASSIGN_OR_RETURN(const auto transform, FindTransform(graph, anchor.map, passage.map.id));
        if (transform) found->second = transform->T_a_b;
      }
      Place place{.link_point = link_point, .anchor = &anchor, .evidence = {}, .distance = {}, .predicted = {}};
      if (found->second) {
        const PoseWithCovariance door = Compose(*found->second, passage.T_map_door);
        place.predicted = Compose(*found->second, passage.T_map_robot);
        place.distance = (door.pose.translation() - anchor.T_map_place.translation()).norm();
        const double radius = SearchRadius(door.covariance + anchor.covariance,
                                           {passage.options.search_base, passage.options.search_factor});
        if (*place.distance > radius) continue;
      }
      places.push_back(std::move(place));
    }
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    return a.distance.value_or(kNowhere) < b.distance.value_or(kNowhere);
  });
  const auto limit = static_cast<std::size_t>(passage.options.max_compared);
  if (places.size() > limit) places.resize(limit);
  std::vector<LinkPointId> ids;
  for (const Place& place : places) ids.push_back(place.link_point->id);
  ENFILADE_ASSIGN_OR_RETURN(const auto evidence,
                            passage.stores.link_points.ListEvidence(context, passage.map.site, ids));
  for (Place& place : places) place.evidence = Of(evidence, place.link_point->id, place.anchor->map);
  return places;
}

absl::StatusOr<std::vector<PlaceEvidence>> ComparePlaces(const CallContext& context, const PassageScene& passage,
                                                         const std::vector<Place>& places, const ViewsBehind& behind,
                                                         StoredViews& views) {
  std::vector<PlaceEvidence> compared;
  for (const Place& place : places) {
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    ENFILADE_ASSIGN_OR_RETURN(compared.emplace_back(), CompareImages(context, place, behind, passage.options, views));
  }
  // Registration is dear: for those with the best images, then those that images tell nothing of, or that the graph has
  // at this very door; the nearest of equals.
  std::vector<std::size_t> order(places.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const auto rank = [&](std::size_t i) {
    const PlaceEvidence& evidence = compared[i];
    return evidence.images && evidence.images->agree ? evidence.images->matches : 0;
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) > rank(b); });
  const auto is_worth_it = [&](const PlaceEvidence& evidence) {
    if (!evidence.images || evidence.images->agree) return true;
    if (!evidence.predicted || !evidence.distance) return false;
    return *evidence.distance <=
           passage.options.known_ahead + ErrorEllipse95(evidence.predicted->covariance).semi_major_m;
  };
  int registered = 0;
  for (const std::size_t i : order) {
    if (registered >= passage.options.max_registered) break;
    if (!is_worth_it(compared[i])) continue;
    ENFILADE_RETURN_IF_ERROR(passage.go_on());
    ENFILADE_RETURN_IF_ERROR(CompareClouds(context, places[i], behind, passage.options, views, compared[i]));
    if (compared[i].clouds) ++registered;
  }
  return compared;
}

// What the session saw before the door, for the anchor in its own map.
void KeepEvidenceHere(const PassageScene& passage, const LinkPointId& link_point, DoorChange& change) {
  const DoorReport& report = passage.report;
  const SessionScene& scene = passage.scene;
  // Where the robot was when it had the door before it, as a candidate is seen.
  TimeNs before = report.door_time;
  for (TimeNs time = report.door_time; time > report.door_time - Seconds(10.0); time -= Seconds(0.25)) {
    const auto pose = scene.PoseAt(time);
    if (!pose) break;
    before = time;
    if ((pose->pose.translation() - passage.T_map_door.pose.translation()).norm() >= passage.options.latch_distance) {
      break;
    }
  }
  const TimeNs window = Seconds(passage.options.image_window);
  auto evidence = EvidenceAt(
      scene, link_point, passage.map.id, before, before - window, report.door_time,
      [&scene](TimeNs time) { return PoseOf(scene.PoseAt(time)); }, passage.options, change.verdict.evidence);
  std::move(evidence.begin(), evidence.end(), std::back_inserter(change.evidence));
}

// ... and after it, for the anchor in the map behind.
void KeepEvidenceBehind(const PassageScene& passage, const LinkPointId& link_point, const Anchor& there,
                        DoorChange& change) {
  const SessionScene& scene = passage.scene;
  const Pose2 T_there_here = there.T_map_place * Inverse(passage.T_map_door.pose);
  auto evidence = EvidenceAt(
      scene, link_point, there.map, passage.report.time, passage.report.door_time, passage.report.time + Seconds(0.5),
      [&](TimeNs time) -> std::optional<Pose2> {
        const auto pose = scene.PoseAt(time);
        return pose ? std::optional<Pose2>(T_there_here * pose->pose) : std::nullopt;
      },
      passage.options, change.verdict.evidence);
  std::move(evidence.begin(), evidence.end(), std::back_inserter(change.evidence));
}

// A link point between two maps that are there already. The new map of it is unset.
void JoinKnown(const PassageScene& passage, const JoinedAnchors& joined, const JudgedPlace& judged,
               DoorChange& change) {
  StoredLinkPoint made;
  made.site = passage.map.site;
  made.point.id = LinkPointId(NewUuid());
  made.point.kind = passage.report.place;
  made.point.direction = joined.there.map;
  made.point.anchors = {joined.here, joined.there};
  KeepEvidenceHere(passage, made.point.id, change);
  KeepEvidenceBehind(passage, made.point.id, joined.there, change);
  change.verdict.decision = DoorDecision::kLinkPointMade;
  change.verdict.link_point = made.point.id;
  change.verdict.entered_map = joined.there.map;
  change.verdict.T_map_robot = judged.T_map_robot;
  change.verdict.reason = "another door of a map that is known: " + judged.reason;
  change.new_link_point = std::move(made);
}

// The robot has come to a place that it, or another robot, knew from the other side; or to a map that it knows, by a
// door that is new.
absl::Status Arrive(const CallContext& context, const PassageScene& passage, const Place& place,
                    const JudgedPlace& judged, const std::vector<LinkPointId>& own, DoorChange& change) {
  const MapId& here = passage.map.id;
  const MapId& there = place.anchor->map;
  const LinkPoint& point = *place.link_point;
  change.consumed = own;
  const JoinedAnchors joined =
      JoinAtDoor(here, passage.T_map_robot.pose, passage.T_map_door, there, judged.T_map_robot);
  const bool is_door =
      IsDoorOf(point, *place.anchor, {joined.there.T_map_place, joined.there.covariance}, passage.options);
  if (is_door && !point.is_candidate() && point.FindAnchor(here) != nullptr) {
    Recognise(point, there, judged.T_map_robot, judged.reason, change.verdict);
    return absl::OkStatus();
  }
  const std::vector<const LinkPoint*> all = passage.graph.graph().ListLinkPoints();
  if (const LinkPoint* other = FindRedundant(all, joined); other != nullptr) {
    if (is_door && point.is_candidate()) change.consumed.push_back(point.id);
    Recognise(*other, there, judged.T_map_robot, judged.reason + "; a link point joins the maps at that place already",
              change.verdict);
    return absl::OkStatus();
  }
  if (!is_door) {
    JoinKnown(passage, joined, judged, change);
    return absl::OkStatus();
  }
  ENFILADE_ASSIGN_OR_RETURN(StoredLinkPoint stored,
                            passage.stores.link_points.Get(context, passage.map.site, point.id));
  if (point.is_candidate()) {
    // The candidate was seen from before the door; the link point is the door.
    stored.point.anchors = {joined.there, joined.here};
    stored.point.direction = there;
    stored.point.kind = passage.report.place;
    change.verdict.decision = DoorDecision::kCandidatePromoted;
    change.verdict.link_point = point.id;
    change.verdict.entered_map = there;
    change.verdict.T_map_robot = judged.T_map_robot;
    change.verdict.reason = judged.reason;
  } else {
    const PoseWithCovariance T_robot_place{Between(judged.T_map_robot.pose, place.anchor->T_map_place),
                                           judged.T_map_robot.covariance};
    const PoseWithCovariance T_here_place = Compose(passage.T_map_robot, T_robot_place);
    stored.point.anchors.push_back({here, T_here_place.pose, T_here_place.covariance});
    Recognise(point, there, judged.T_map_robot, judged.reason + "; this map is joined to it, too", change.verdict);
  }
  change.link_point = std::move(stored);
  KeepEvidenceHere(passage, point.id, change);
  return absl::OkStatus();
}

// Of the places that have the robot where the chosen one has it, the one whose door it came by; else the chosen one.
std::size_t FindDoor(const PassageScene& passage, const std::vector<Place>& places, const PassageChoice& choice) {
  const JudgedPlace& chosen = choice.judged[*choice.chosen];
  const MapId& there = places[*choice.chosen].anchor->map;
  for (const std::size_t i : choice.order) {
    const JudgedPlace& judged = choice.judged[i];
    if (!judged.accepted || places[i].anchor->map != there) continue;
    const Pose2 d = Between(judged.T_map_robot.pose, chosen.T_map_robot.pose);
    if (d.translation().norm() > passage.options.same_pose) continue;
    const Anchor door =
        JoinAtDoor(passage.map.id, passage.T_map_robot.pose, passage.T_map_door, there, judged.T_map_robot).there;
    if (IsDoorOf(*places[i].link_point, *places[i].anchor, {door.T_map_place, door.covariance}, passage.options)) {
      return i;
    }
  }
  return *choice.chosen;
}

// Nothing known: a link point, and a map that begins at it.
void Begin(const PassageScene& passage, const std::vector<LinkPointId>& own, std::string why, DoorChange& change) {
  change.new_map = MapBehind(passage.map, &passage.report, passage.options);
  change.consumed = own;
  StoredLinkPoint made;
  made.site = passage.map.site;
  made.environment = change.new_map->environment;
  LinkPoint& point = made.point;
  point.id = LinkPointId(NewUuid());
  point.kind = passage.report.place;
  point.direction = change.new_map->id;
  point.anchors = {{passage.map.id, passage.T_map_door.pose, passage.T_map_door.covariance},
                   OriginAnchor(change.new_map->id, passage.options)};
  const Pose2 T_door_robot = Between(passage.T_map_door.pose, passage.T_map_robot.pose);
  const double length = T_door_robot.translation().norm();
  PoseWithCovariance T_new_robot{T_door_robot, point.anchors.back().covariance};
  T_new_robot.covariance.diagonal() += Eigen::Vector3d(std::pow(passage.options.odometry_sigma * length, 2),
                                                       std::pow(passage.options.odometry_sigma * length, 2),
                                                       std::pow(passage.options.odometry_yaw_sigma * length, 2));
  KeepEvidenceHere(passage, point.id, change);
  KeepEvidenceBehind(passage, point.id, point.anchors.back(), change);
  DoorVerdict& verdict = change.verdict;
  verdict.decision = DoorDecision::kLinkPointMade;
  verdict.link_point = point.id;
  verdict.entered_map = change.new_map->id;
  verdict.T_map_robot = T_new_robot;
  verdict.reason = std::move(why);
  change.new_link_point = std::move(made);
}

}  // namespace

std::vector<Evidence> EvidenceAt(const SessionScene& scene, const LinkPointId& link_point, const MapId& map,
                                 TimeNs time, TimeNs from, TimeNs to,
                                 const std::function<std::optional<Pose2>(TimeNs)>& T_map_robot,
                                 const ClosureOptions& options, std::vector<std::int64_t>& seen) {
  std::vector<Evidence> evidence;
  const auto add = [&](std::int64_t sequence, EvidenceKind kind, std::int16_t encoding, const BlobRef& content,
                       TimeNs recorded) {
    evidence.push_back({link_point, map, kind, encoding, content, recorded, T_map_robot(recorded)});
    seen.push_back(sequence);
  };
  for (const Camera camera : {Camera::kFront, Camera::kRear}) {
    const EvidenceKind kind = camera == Camera::kFront ? EvidenceKind::kFrontImage : EvidenceKind::kRearImage;
    for (const auto& image : scene.ImagesNear(camera, time, from, to, options.images_kept)) {
      add(image.sequence, kind, static_cast<std::int16_t>(image.image.encoding), image.image.content, image.image.time);
    }
  }
  if (const auto cloud = scene.CloudNear(time, from, to)) {
    add(cloud->sequence, EvidenceKind::kCloud, static_cast<std::int16_t>(cloud->cloud.encoding), cloud->cloud.content,
        cloud->cloud.time);
  }
  return evidence;
}

absl::Status JudgePassage(const CallContext& context, const PassageScene& passage, StoredViews& views,
                          DoorChange& change) {
  const std::vector<KnownPlace> passed =
      FindPassed(passage.graph.graph().ListLinkPoints(), passage.map.id, passage.T_map_door, passage.options);
  ENFILADE_ASSIGN_OR_RETURN(const ViewsBehind behind, LookBehind(context, passage, views, change.verdict.evidence));
  std::set<LinkPointId> contradicted;
  ENFILADE_ASSIGN_OR_RETURN(const bool known, TryPassed(context, passage, passed, behind, views, change, contradicted));
  if (known) return absl::OkStatus();

  ENFILADE_ASSIGN_OR_RETURN(const std::vector<Place> places, FindPlaces(context, passage, contradicted));
  ENFILADE_ASSIGN_OR_RETURN(const std::vector<PlaceEvidence> compared,
                            ComparePlaces(context, passage, places, behind, views));
  const PassageChoice choice = ChoosePlace(compared, passage.options);
  for (const std::size_t i : choice.order) {
    change.verdict.comparisons.push_back(ToComparison(compared[i], choice.judged[i]));
  }
  // The same door, seen from this side before.
  std::vector<LinkPointId> own;
  for (const KnownPlace& place : passed) {
    if (place.link_point->is_candidate()) own.push_back(place.link_point->id);
  }
  if (!choice.chosen) {
    Begin(passage, own, choice.reason, change);
    return absl::OkStatus();
  }
  const std::size_t arrived = FindDoor(passage, places, choice);
  return Arrive(context, passage, places[arrived], choice.judged[arrived], own, change);
}

}  // namespace enfilade::server

// SPDX-License-Identifier: Apache-2.0
#include "core/closure/judge_place.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/closure/pose_gate.h"
#include "core/graph/search_radius.h"
#include "fmt/format.h"

namespace enfilade::closure {
namespace {

bool IsSure(const PoseWithCovariance& pose, const DoorClosureOptions& options) {
  return graph::ErrorEllipse95(pose.covariance).semi_major_m <= options.sure_radius &&
         std::sqrt(std::max(pose.covariance(2, 2), 0.0)) <= options.sure_yaw;
}

std::string Describe(const PlaceEvidence& evidence, const std::optional<double>& chi2) {
  std::string text = "no images";
  if (evidence.images) {
    text = fmt::format("images: {} matches, {}", evidence.images->matches,
                       evidence.images->agree         ? "agree"
                       : evidence.images->other_place ? "same view, other place"
                                                      : "do not agree");
  }
  text += evidence.clouds ? fmt::format("; clouds: {:.0f} % alike, {}", 100.0 * evidence.clouds->inlier_share,
                                        evidence.clouds->agree ? "agree" : "do not agree")
                          : "; no clouds";
  text += chi2 ? fmt::format("; chi-squared {:.1f} against the graph", *chi2)
               : (evidence.predicted ? "" : "; no link points lead there");
  if (!evidence.missing.empty()) text += " (" + evidence.missing + ")";
  return text;
}

JudgedPlace Accept(JudgedPlace judged, const PoseWithCovariance& pose, std::string why) {
  judged.accepted = true;
  judged.T_map_robot = pose;
  judged.reason = std::move(why) + ": " + judged.reason;
  return judged;
}

JudgedPlace Refuse(JudgedPlace judged, std::string why) {
  judged.reason = std::move(why) + ": " + judged.reason;
  return judged;
}

// Judges a place whose clouds were registered, with or without images.
JudgedPlace JudgeRegistered(const PlaceEvidence& evidence, JudgedPlace judged, const DoorClosureOptions& options) {
  const CloudComparison& clouds = *evidence.clouds;
  const bool images_agree = evidence.images && evidence.images->agree;
  const bool strict = clouds.inlier_share >= options.strict_inlier_share;
  if (!evidence.predicted) {
    if (!images_agree) return Refuse(std::move(judged), "clouds alone do not suffice where no link points lead");
    if (evidence.images->matches <= options.unpredicted_matches * options.image_threshold ||
        clouds.inlier_share < options.unpredicted_inlier_share) {
      return Refuse(std::move(judged), "images and clouds are not alike enough where no link points lead");
    }
    return Accept(std::move(judged), clouds.T_map_robot, "images and clouds agree, nothing predicts the pose");
  }
  if (*judged.chi2 > Gate(options)) return Refuse(std::move(judged), "the graph has the robot elsewhere");
  if (images_agree) return Accept(std::move(judged), clouds.T_map_robot, "images, clouds and graph agree");
  if (!strict) return Refuse(std::move(judged), "without images the clouds are not alike enough");
  if (*judged.chi2 > StrictGate(options))
    return Refuse(std::move(judged), "without images the graph is not near enough");
  if (!IsSure(*evidence.predicted, options)) {
    return Refuse(std::move(judged), "without images the graph is not sure enough of where the robot is");
  }
  return Accept(std::move(judged), clouds.T_map_robot, "clouds and graph agree closely");
}

// Do the two places exclude each other?
bool AreRivals(const PlaceEvidence& a, const JudgedPlace& judged_a, const PlaceEvidence& b, const JudgedPlace& judged_b,
               const DoorClosureOptions& options) {
  if (a.map != b.map) return true;
  const Pose2 d = Between(judged_a.T_map_robot.pose, judged_b.T_map_robot.pose);
  return d.translation().norm() > options.same_pose;
}

bool IsClearlyBetter(const PlaceEvidence& a, const JudgedPlace& judged_a, const PlaceEvidence& b,
                     const JudgedPlace& judged_b, const DoorClosureOptions& options) {
  if (judged_a.chi2 && judged_b.chi2 && *judged_a.chi2 + options.clear_chi2 <= *judged_b.chi2) return true;
  // The graph predicts the robot at one of them and nothing about the other.
  if (judged_a.chi2 && !judged_b.chi2) return true;
  return a.images && a.images->agree && b.images &&
         a.images->matches >= options.clear_score * std::max(b.images->matches, 1);
}

}  // namespace

JudgedPlace JudgePlace(const PlaceEvidence& evidence, const DoorClosureOptions& options) {
  JudgedPlace judged;
  const bool registered = evidence.clouds && evidence.clouds->agree;
  if (registered && evidence.predicted) {
    judged.chi2 =
        PoseChiSquared(*evidence.predicted, evidence.clouds->T_map_robot, options.pose_sigma, options.pose_yaw_sigma);
  }
  judged.margin = (evidence.images && evidence.images->agree ? evidence.images->matches : 0) +
                  (registered ? 100.0 * evidence.clouds->inlier_share : 0.0) - std::min(judged.chi2.value_or(0.0), 1e3);
  judged.compared = judged.reason = Describe(evidence, judged.chi2);
  if (registered) return JudgeRegistered(evidence, std::move(judged), options);
  if (evidence.clouds) return Refuse(std::move(judged), "the clouds are not of one place");
  if (!evidence.images) return Refuse(std::move(judged), "nothing to compare");
  if (!evidence.images->agree) return Refuse(std::move(judged), "the images are not of one place");
  if (!evidence.predicted) return Refuse(std::move(judged), "images alone give no pose");
  if (!IsSure(*evidence.predicted, options)) {
    return Refuse(std::move(judged), "images alone give no pose, and the graph is not sure of it");
  }
  return Accept(std::move(judged), *evidence.predicted, "images agree, and the graph is sure of the pose");
}

bool IsContradicted(const PlaceEvidence& evidence, const DoorClosureOptions& options) {
  return evidence.images && !evidence.images->agree && evidence.clouds && !evidence.clouds->agree &&
         evidence.clouds->inlier_share < options.contradicting_share;
}

PassageChoice ChoosePlace(const std::vector<PlaceEvidence>& evidence, const DoorClosureOptions& options) {
  PassageChoice choice;
  for (const PlaceEvidence& place : evidence) choice.judged.push_back(JudgePlace(place, options));
  choice.order.resize(evidence.size());
  std::iota(choice.order.begin(), choice.order.end(), 0);
  std::stable_sort(choice.order.begin(), choice.order.end(), [&](std::size_t a, std::size_t b) {
    const JudgedPlace& first = choice.judged[a];
    const JudgedPlace& second = choice.judged[b];
    if (first.accepted != second.accepted) return first.accepted;
    if (first.margin != second.margin) return first.margin > second.margin;
    return evidence[a].link_point < evidence[b].link_point;
  });
  if (evidence.empty()) {
    choice.reason = "no known place within the search radius";
    return choice;
  }
  const std::size_t best = choice.order.front();
  if (!choice.judged[best].accepted) {
    choice.reason = fmt::format("none of {} known places was accepted", evidence.size());
    return choice;
  }
  // The best place is clearly better than each rival; the order by margin alone does not guarantee that.
  for (const std::size_t i : choice.order) {
    if (!choice.judged[i].accepted) continue;
    const bool beats_all = std::all_of(choice.order.begin(), choice.order.end(), [&](std::size_t j) {
      if (j == i || !choice.judged[j].accepted) return true;
      return !AreRivals(evidence[i], choice.judged[i], evidence[j], choice.judged[j], options) ||
             (IsClearlyBetter(evidence[i], choice.judged[i], evidence[j], choice.judged[j], options) &&
              !IsClearlyBetter(evidence[j], choice.judged[j], evidence[i], choice.judged[i], options));
    });
    if (!beats_all) continue;
    choice.chosen = i;
    choice.reason = choice.judged[i].reason;
    return choice;
  }
  choice.ambiguous = true;
  choice.reason =
      fmt::format("places that look alike and that the graph cannot tell apart, {} and others: none is chosen",
                  evidence[best].link_point.value());
  return choice;
}

DoorComparison ToComparison(const PlaceEvidence& evidence, const JudgedPlace& judged) {
  DoorComparison comparison;
  comparison.link_point = evidence.link_point;
  comparison.map = evidence.map;
  comparison.distance = evidence.distance;
  if (evidence.images) {
    comparison.image_matches = evidence.images->matches;
    comparison.images_agree = evidence.images->agree;
  }
  if (evidence.clouds) {
    comparison.rmse = evidence.clouds->rmse;
    comparison.inlier_share = evidence.clouds->inlier_share;
    comparison.clouds_agree = evidence.clouds->agree;
  }
  comparison.chi2 = judged.chi2;
  comparison.accepted = judged.accepted;
  comparison.reason = judged.reason;
  return comparison;
}

}  // namespace enfilade::closure

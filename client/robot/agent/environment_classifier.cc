// SPDX-License-Identifier: Apache-2.0
#include "client/robot/agent/environment_classifier.h"

#include <utility>
#include <vector>

#include "core/base/environment.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "perception/environment/frame_similarity.h"
#include "perception/image/decode.h"

namespace enfilade::robot {
namespace {

constexpr int kSsim = 1;
constexpr int kScene = 3;

}  // namespace

absl::StatusOr<EnvironmentClassifier> EnvironmentClassifier::Make(const EnvironmentOptions& options) {
  EnvironmentClassifier choice(options);
  if (options.criterion == kScene) {
    ENFILADE_ASSIGN_OR_RETURN(
        choice.classifier_,
        perception::SceneClassifier::Load({options.scene_model, options.scene_labels, options.scene_mapping}));
  }
  return choice;
}

void EnvironmentClassifier::Add(const client::SpoolItem& item) {
  const auto* image = std::get_if<sensor::Image>(&item.payload);
  if (!image || image->camera != sensor::Camera::kFront || options_.criterion == 0) return;
  const bool depth = image->encoding == sensor::ImageEncoding::kDepthPng16;
  if (depth == (options_.criterion == kScene)) return;  // not what the criterion uses
  auto& images = depth ? depth_ : photos_;
  images.push_back(item);
  while (images.size() > static_cast<std::size_t>(options_.num_depth_imgs)) images.pop_front();
}

EnvironmentClassifier::Verdict EnvironmentClassifier::Classify(TimeNs since) {
  if (options_.criterion == 0) return ByRange();
  absl::StatusOr<Verdict> verdict = options_.criterion == kScene ? ByScene(since) : BySimilarity(since);
  if (verdict.ok()) return *std::move(verdict);
  Verdict by_range = ByRange();
  by_range.reason += fmt::format(" (config_criterion {} cannot decide: {})", options_.criterion,
                                 std::string(verdict.status().message()));
  return by_range;
}

EnvironmentClassifier::Verdict EnvironmentClassifier::ByRange() const {
  if (!scan_) return {std::nullopt, "no scan"};
  sensor::RangeCriterion criterion;
  criterion.side_limit = options_.range_thr;
  criterion.half_width = options_.low_pass_filter_size;
  const absl::StatusOr<sensor::RangeChoice> choice = sensor::ChooseByRange(*scan_, criterion);
  if (!choice.ok()) return {std::nullopt, std::string(choice.status().message())};
  if (!choice->environment) return {std::nullopt, "the scan has no hit"};
  return {choice->environment, fmt::format("{}: {} of 4 sides beyond {} m", ToString(*choice->environment),
                                           choice->far_sides, options_.range_thr)};
}

absl::StatusOr<EnvironmentClassifier::Verdict> EnvironmentClassifier::BySimilarity(TimeNs since) const {
  std::vector<perception::DepthFrame> frames;
  for (const client::SpoolItem& item : depth_) {
    if (TimeOf(item) < since) continue;
    ENFILADE_ASSIGN_OR_RETURN(perception::DepthFrame frame, perception::DecodeDepth(item.content));
    frames.push_back(std::move(frame));
  }
  const bool ssim = options_.criterion == kSsim;
  perception::SimilarityCriterion criterion;
  criterion.measure = ssim ? perception::SimilarityMeasure::kSsim : perception::SimilarityMeasure::kPsnr;
  criterion.threshold = ssim ? options_.ssim_thr : options_.psnr_thr;
  criterion.frames = options_.num_depth_imgs;
  ENFILADE_ASSIGN_OR_RETURN(const perception::SimilarityChoice choice,
                            perception::ChooseBySimilarity(frames, criterion));
  return Verdict{choice.environment,
                 fmt::format("{}: {} of {} pairs of depth images is {:.3f}, threshold {}", ToString(choice.environment),
                             ssim ? "SSIM" : "PSNR", choice.pairs, choice.mean, criterion.threshold)};
}

absl::StatusOr<EnvironmentClassifier::Verdict> EnvironmentClassifier::ByScene(TimeNs since) {
  double outdoor = 0.0;
  int classified = 0;
  std::string best;
  for (const client::SpoolItem& item : photos_) {
    if (TimeOf(item) < since) continue;
    ENFILADE_ASSIGN_OR_RETURN(const perception::ColorFrame frame, perception::DecodeColor(item.content));
    ENFILADE_ASSIGN_OR_RETURN(const perception::SceneVerdict scene, classifier_->Classify(frame));
    outdoor += scene.outdoor_probability;
    best = scene.best_class;
    ++classified;
  }
  if (classified == 0) return FailedPrecondition("no image from the front camera since the door");
  const Environment environment = outdoor / classified > 0.5 ? Environment::kOutdoor : Environment::kIndoor;
  return Verdict{environment, fmt::format("{}: outdoors by {:.2f} over {} images, the last one {}",
                                          ToString(environment), outdoor / classified, classified, best)};
}

}  // namespace enfilade::robot

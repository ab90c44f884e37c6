// SPDX-License-Identifier: Apache-2.0
#include "perception/image/match_images.h"

#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "perception/image/decode.h"
#include "perception/image/draw_matches.h"

namespace enfilade::cli {
namespace {

using perception::GeometricModel;

const std::map<std::string, GeometricModel> kModels = {{"none", GeometricModel::kNone},
                                                       {"planes", GeometricModel::kPlanes},
                                                       {"fundamental", GeometricModel::kFundamental},
                                                       {"essential", GeometricModel::kEssential}};

struct MatchImagesCommandOptions {
  std::string a;
  std::string b;
  std::string output;
  std::string model = "planes";
  bool original = false;
  bool one_way = false;
  std::vector<double> intrinsics;  // fx fy cx cy of both cameras
  perception::FeatureOptions features;
  perception::ImageMatchOptions match;
};

struct Side {
  perception::GreyFrame frame;
  perception::FeatureSet features;
};

absl::StatusOr<Side> LoadImage(const std::string& path, const perception::FeatureOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
  Side side;
  absl::StatusOr<perception::GreyFrame> frame = perception::DecodeGrey(bytes);
  if (!frame.ok()) return WithContext(frame.status(), path);
  side.frame = *std::move(frame);
  ENFILADE_ASSIGN_OR_RETURN(side.features, perception::ExtractFeatures(side.frame, options));
  return side;
}

perception::ImageMatchOptions MatchOptionsOf(const MatchImagesCommandOptions& options) {
  if (options.original) return perception::MapManagerImageMatchOptions();
  perception::ImageMatchOptions match = options.match;
  match.model = kModels.at(options.model);
  match.ratios.mutual = !options.one_way;
  if (options.intrinsics.size() == 4) {
    match.intrinsics_a = perception::Intrinsics{options.intrinsics[0], options.intrinsics[1], options.intrinsics[2],
                                                options.intrinsics[3]};
    match.intrinsics_b = match.intrinsics_a;
  }
  return match;
}

absl::Status RunMatchImages(const Globals& globals, const MatchImagesCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const Side a, LoadImage(options.a, options.features));
  ENFILADE_ASSIGN_OR_RETURN(const Side b, LoadImage(options.b, options.features));
  const auto start = std::chrono::steady_clock::now();
  ENFILADE_ASSIGN_OR_RETURN(const perception::ImageMatch match,
                            perception::MatchImages(a.features, b.features, MatchOptionsOf(options)));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  if (!options.output.empty()) {
    ENFILADE_ASSIGN_OR_RETURN(const grid::RgbImage picture, perception::DrawMatches(a.frame, b.frame, match));
    ENFILADE_ASSIGN_OR_RETURN(const std::string png, grid::EncodePng(picture));
    ENFILADE_RETURN_IF_ERROR(io::WriteFile(options.output, png));
  }
  if (globals.json) {
    PrintJson(std::cout, {{"a", options.a},
                          {"b", options.b},
                          {"accepted", match.accepted},
                          {"matches", match.matches},
                          {"inliers", match.inliers},
                          {"features_a", match.features_a},
                          {"features_b", match.features_b},
                          {"overlap", match.overlap},
                          {"view_share", match.view_share},
                          {"other_place", match.other_place},
                          {"reason", match.reason},
                          {"seconds", seconds}});
  } else if (!globals.quiet) {
    std::cout << fmt::format("{}: {}\nfeatures  {} and {}\nmatches   {}\ninliers   {}\n",
                             match.accepted ? "the same place" : "not recognised as the same place", match.reason,
                             match.features_a, match.features_b, match.matches, match.inliers);
    if (!options.output.empty()) std::cout << "picture   " << options.output << '\n';
  }
  return absl::OkStatus();
}

}  // namespace

void AddMatchImages(CLI::App& match, const Globals& globals) {
  auto options = std::make_shared<MatchImagesCommandOptions>();
  CLI::App* command =
      AddCommand(match, "images", "Match SIFT and AKAZE features of two images, and verify them by geometry",
                 [&globals, options] { return RunMatchImages(globals, *options); });
  command->add_option("A", options->a, "PNG or JPEG")->required();
  command->add_option("B", options->b, "PNG or JPEG")->required();
  command->add_option("-o,--output", options->output, "Draw the matches into a PNG: inliers green, others red");
  command->add_option("--threshold", options->match.threshold, "Accept with more inliers than this ...")
      ->capture_default_str();
  command
      ->add_option("--min-share", options->match.min_share,
                   "... and more than this share of the features in both images")
      ->capture_default_str();
  command
      ->add_option("--min-view-share", options->match.min_view_share,
                   "... of which this share, mean over the image, is of about the same size: what is near counts, too")
      ->capture_default_str();
  command->add_option("--model", options->model, "The geometry to verify: planes, fundamental, essential, none")
      ->check(CLI::IsMember(&kModels))
      ->capture_default_str();
  command->add_option("--intrinsics", options->intrinsics, "fx fy cx cy in pixels, for --model essential")->expected(4);
  command->add_option("--sift-ratio", options->match.ratios.sift, "Ratio test of SIFT features")->capture_default_str();
  command->add_option("--akaze-ratio", options->match.ratios.akaze, "Ratio test of AKAZE features")
      ->capture_default_str();
  command->add_flag("--one-way", options->one_way, "No mutual check of matches");
  command->add_option("--max-side", options->features.max_side, "Larger images are scaled down to this, pixels")
      ->capture_default_str();
  command->add_option("--seed", options->match.seed, "The seed of RANSAC")->capture_default_str();
  command->add_flag("--original", options->original, "As map_manager: accept more than 30 matches, unverified");
  command->footer("Example:\n  enfilade match images door_then.jpg door_now.jpg -o matches.png");
}

}  // namespace enfilade::cli

// SPDX-License-Identifier: Apache-2.0
#include "core/base/environment.h"

#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/output.h"
#include "client/sources/log_reader.h"
#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/sensor/environment_choice.h"
#include "io/file.h"
#include "perception/environment/frame_similarity.h"
#include "perception/environment/scene_classifier.h"
#include "perception/image/decode.h"
#include "perception/image/image_header.h"

namespace enfilade::cli {
namespace {

struct EnvironmentCommandOptions {
  std::vector<std::string> inputs;
  std::string criterion;  // empty: range for a log, ssim for images
  std::string preset;
  sensor::RangeCriterion range;
  perception::SimilarityCriterion similarity;
  std::optional<double> threshold;
  perception::SceneClassifierFiles classifier;
};

// The readings to judge by, in order.
struct Material {
  std::vector<sensor::LaserScan> scans;
  std::vector<std::string> depth_files;
  std::vector<std::string> color_files;
};

absl::StatusOr<Material> ReadLog(const std::string& path) {
  ENFILADE_ASSIGN_OR_RETURN(sources::LogReader reader, sources::LogReader::Open(path));
  Material material;
  for (;;) {
    ENFILADE_ASSIGN_OR_RETURN(std::optional<sources::LogEntry> entry, reader.Next());
    if (!entry) return material;
    if (auto* scan = std::get_if<sensor::LaserScan>(&entry->payload)) material.scans.push_back(std::move(*scan));
    if (const auto* image = std::get_if<sensor::Image>(&entry->payload);
        image != nullptr && image->camera == sensor::Camera::kFront) {
      auto& files = image->encoding == sensor::ImageEncoding::kDepthPng16 ? material.depth_files : material.color_files;
      files.push_back(entry->content);
    }
  }
}

// One log, or images; those of 16 bits are depth images.
absl::StatusOr<Material> Gather(const std::vector<std::string>& inputs) {
  Material material;
  for (const std::string& path : inputs) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    const absl::StatusOr<perception::ImageHeader> header = perception::ReadImageHeader(bytes);
    if (header.ok()) {
      (header->bit_depth == 16 ? material.depth_files : material.color_files).push_back(path);
    } else if (inputs.size() == 1) {
      return ReadLog(path);
    } else {
      return WithContext(header.status(), path);
    }
  }
  return material;
}

struct Verdict {
  Environment environment = Environment::kIndoor;
  nlohmann::json details;
  std::string text;
};

// The first scan with hits decides, as when a robot enters a new map; the others show how stable the verdict is.
absl::StatusOr<Verdict> ByRange(const Material& material, const sensor::RangeCriterion& criterion) {
  if (material.scans.empty()) return InvalidArgument("criterion range: no scans: give a log that has some");
  std::optional<sensor::RangeChoice> first;
  std::int64_t outdoor = 0;
  std::int64_t judged = 0;
  for (const sensor::LaserScan& scan : material.scans) {
    ENFILADE_ASSIGN_OR_RETURN(const sensor::RangeChoice choice, sensor::ChooseByRange(scan, criterion));
    if (!choice.environment) continue;
    if (!first) first = choice;
    ++judged;
    if (choice.environment == Environment::kOutdoor) ++outdoor;
  }
  if (!first) return InvalidArgument("criterion range: none of {} scans has a hit", material.scans.size());
  Verdict verdict{*first->environment, {}, {}};
  verdict.details = {{"front", first->front},  {"back", first->back},           {"left", first->left},
                     {"right", first->right},  {"far_sides", first->far_sides}, {"scans", material.scans.size()},
                     {"scans_judged", judged}, {"scans_outdoor", outdoor}};
  verdict.text = fmt::format(
      "first scan: front {:.1f} m, back {:.1f} m, left {:.1f} m, right {:.1f} m; {} of 4 beyond {} m\n{} of {} scans "
      "would say outdoor\n",
      first->front, first->back, first->left, first->right, first->far_sides, criterion.side_limit, outdoor, judged);
  return verdict;
}

absl::StatusOr<Verdict> BySimilarity(const Material& material, const perception::SimilarityCriterion& criterion) {
  std::vector<perception::DepthFrame> frames;
  for (const std::string& path : material.depth_files) {
    if (frames.size() == static_cast<std::size_t>(criterion.frames)) break;
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    absl::StatusOr<perception::DepthFrame> frame = perception::DecodeDepth(bytes);
    if (!frame.ok()) return WithContext(frame.status(), path);
    frames.push_back(*std::move(frame));
  }
  ENFILADE_ASSIGN_OR_RETURN(const perception::SimilarityChoice choice,
                            perception::ChooseBySimilarity(frames, criterion));
  Verdict verdict{choice.environment, {}, {}};
  verdict.details = {{"mean", choice.mean}, {"pairs", choice.pairs}, {"threshold", criterion.threshold}};
  verdict.text = fmt::format("mean of {} pairs of depth images: {:.4f}; below {} is outdoor\n", choice.pairs,
                             choice.mean, criterion.threshold);
  return verdict;
}

absl::StatusOr<Verdict> ByScene(const Material& material, const perception::SceneClassifierFiles& files) {
  if (material.color_files.empty())
    return InvalidArgument("criterion scene: no photographs: give some, or a log that has them");
  ENFILADE_ASSIGN_OR_RETURN(perception::SceneClassifier classifier, perception::SceneClassifier::Load(files));
  Verdict verdict{Environment::kIndoor, {{"images", nlohmann::json::array()}}, {}};
  double outdoor = 0.0;
  for (const std::string& path : material.color_files) {
    ENFILADE_ASSIGN_OR_RETURN(const std::string bytes, io::ReadFile(path));
    const absl::StatusOr<perception::ColorFrame> frame = perception::DecodeColor(bytes);
    if (!frame.ok()) return WithContext(frame.status(), path);
    ENFILADE_ASSIGN_OR_RETURN(const perception::SceneVerdict scene, classifier.Classify(*frame));
    outdoor += scene.outdoor_probability;
    verdict.details["images"].push_back({{"file", path},
                                         {"outdoor_probability", scene.outdoor_probability},
                                         {"class", scene.best_class},
                                         {"class_probability", scene.best_probability}});
    verdict.text += fmt::format("{}: outdoor {:.3f}, {} {:.3f}\n", path, scene.outdoor_probability, scene.best_class,
                                scene.best_probability);
  }
  const double mean = outdoor / static_cast<double>(material.color_files.size());
  verdict.environment = mean > 0.5 ? Environment::kOutdoor : Environment::kIndoor;
  verdict.details["outdoor_probability"] = mean;
  return verdict;
}

absl::StatusOr<Verdict> Judge(const EnvironmentCommandOptions& options, const std::string& criterion,
                              const Material& material) {
  if (criterion == "range") {
    if (options.preset == "original-yaml") return ByRange(material, sensor::RangeCriterion::MapManagerYaml());
    if (options.preset == "original-code") return ByRange(material, sensor::RangeCriterion::MapManagerCode());
    return ByRange(material, options.range);
  }
  if (criterion == "scene") return ByScene(material, options.classifier);
  perception::SimilarityCriterion similarity = options.similarity;
  const bool is_ssim = criterion == "ssim";
  similarity.measure = is_ssim ? perception::SimilarityMeasure::kSsim : perception::SimilarityMeasure::kPsnr;
  similarity.threshold = options.threshold.value_or(is_ssim ? 0.7 : 0.0);
  return BySimilarity(material, similarity);
}

absl::Status RunEnvironment(const Globals& globals, const EnvironmentCommandOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const Material material, Gather(options.inputs));
  std::string criterion = options.criterion;
  if (criterion.empty()) criterion = material.scans.empty() ? "ssim" : "range";
  ENFILADE_ASSIGN_OR_RETURN(const Verdict verdict, Judge(options, criterion, material));
  if (globals.json) {
    nlohmann::json document = verdict.details;
    document["criterion"] = criterion;
    document["environment"] = ToString(verdict.environment);
    PrintJson(std::cout, document);
  } else if (!globals.quiet) {
    std::cout << fmt::format("{} (by {})\n{}", ToString(verdict.environment), criterion, verdict.text);
  }
  return absl::OkStatus();
}

}  // namespace

void AddEnvironment(CLI::App& app, const Globals& globals) {
  auto options = std::make_shared<EnvironmentCommandOptions>();
  CLI::App* command =
      AddCommand(app, "environment", "Classify a log as indoor or outdoor by scans, depth images or a scene classifier",
                 [&globals, options] { return RunEnvironment(globals, *options); });
  command->add_option("INPUT", options->inputs, "A log, or images (a PNG of 16 bits is a depth image in mm)")
      ->required();
  command
      ->add_option(
          "--criterion", options->criterion,
          "range (scans), ssim or psnr (depth images), scene (photographs); default: range for scans, else ssim")
      ->check(CLI::IsMember({"range", "ssim", "psnr", "scene"}));
  command->add_option("--range-thr", options->range.side_limit, "Range: a side beyond this distance is far, m")
      ->capture_default_str();
  command->add_option("--filter-half-width", options->range.half_width, "Range: beams averaged on either side")
      ->capture_default_str();
  command->add_option("--preset", options->preset, "Range: original-yaml (13 m) or original-code (10 m)")
      ->check(CLI::IsMember({"original-yaml", "original-code"}));
  command->add_option("--threshold", options->threshold,
                      "ssim, psnr: a mean below this is outdoor (default: 0.7; 0 dB)");
  command->add_option("--frames", options->similarity.frames, "ssim, psnr: how many depth images to compare")
      ->capture_default_str();
  command->add_option("--model", options->classifier.model, "Scene: the network (ONNX, input 1x3x224x224)");
  command->add_option("--labels", options->classifier.labels, "Scene: class names, in the order of the outputs");
  command->add_option("--mapping", options->classifier.mapping,
                      "Scene: lines \"class 1\" (indoor), \"class 2\" (outdoor)");
  command->footer(
      "Examples:\n  enfilade environment drive.clf\n  enfilade environment depth_*.png --criterion psnr --threshold "
      "20\n"
      "  enfilade environment view.jpg --criterion scene --model places365.onnx --labels categories_places365.txt "
      "--mapping IO_places365.txt");
}

}  // namespace enfilade::cli

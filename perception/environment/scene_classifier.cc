// SPDX-License-Identifier: Apache-2.0
#include "perception/environment/scene_classifier.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/environment.h"
#include "core/base/status_macros.h"
#include "io/file.h"
#include "perception/image/opencv_guard.h"

namespace enfilade::perception {
namespace {

constexpr int kSide = 256;
constexpr int kCrop = 224;

absl::StatusOr<std::string> ReadPart(const std::string& path, const char* what) {
  absl::StatusOr<std::string> bytes = io::ReadFile(path);
  if (absl::IsNotFound(bytes.status())) {
    return NotFound(
        "the scene classifier's {} \"{}\" does not exist: name an existing file, or choose another criterion", what,
        path);
  }
  if (!bytes.ok()) return WithContext(bytes.status(), fmt::format("the scene classifier's {}", what));
  return bytes;
}

// 1x3x224x224 of an RGB image.
cv::Mat Preprocess(const cv::Mat& rgb) {
  cv::Mat scaled;
  cv::resize(rgb, scaled, cv::Size(kSide, kSide), 0.0, 0.0,
             std::min(rgb.cols, rgb.rows) > kSide ? cv::INTER_AREA : cv::INTER_LINEAR);
  const cv::Mat middle = scaled(cv::Rect((kSide - kCrop) / 2, (kSide - kCrop) / 2, kCrop, kCrop));
  cv::Mat real;
  middle.convertTo(real, CV_32FC3, 1.0 / 255.0);
  cv::subtract(real, cv::Scalar(0.485, 0.456, 0.406), real);
  cv::divide(real, cv::Scalar(0.229, 0.224, 0.225), real);
  return cv::dnn::blobFromImage(real);
}

std::vector<double> Softmax(const cv::Mat& scores) {
  const auto* first = scores.ptr<float>();
  std::vector<double> shares(first, first + scores.total());
  const double highest = *std::max_element(shares.begin(), shares.end());
  double sum = 0.0;
  for (double& share : shares) sum += share = std::exp(share - highest);
  for (double& share : shares) share /= sum;
  return shares;
}

}  // namespace

struct SceneClassifier::Network {
  cv::dnn::Net net;
  std::size_t classes = 0;

  // One number per class.
  absl::StatusOr<cv::Mat> Run(const cv::Mat& input) {
    net.setInput(input);
    const cv::Mat output = net.forward();
    if (output.type() != CV_32F || output.total() != classes) {
      return InvalidArgument("the scene classifier's model has {} outputs for {} labels", output.total(), classes);
    }
    if (!cv::checkRange(output)) return InvalidArgument("the scene classifier's model has outputs that are not finite");
    return output.clone();
  }
};

SceneClassifier::SceneClassifier(std::unique_ptr<Network> network, std::vector<SceneClass> classes)
    : network_(std::move(network)), classes_(std::move(classes)) {}
SceneClassifier::~SceneClassifier() = default;
SceneClassifier::SceneClassifier(SceneClassifier&&) noexcept = default;
SceneClassifier& SceneClassifier::operator=(SceneClassifier&&) noexcept = default;

absl::StatusOr<SceneClassifier> SceneClassifier::Load(const SceneClassifierFiles& files) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string model, ReadPart(files.model, "model"));
  ENFILADE_ASSIGN_OR_RETURN(const std::string labels, ReadPart(files.labels, "labels"));
  ENFILADE_ASSIGN_OR_RETURN(const std::string mapping, ReadPart(files.mapping, "mapping"));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<SceneClass> classes, ParseSceneClasses(labels, mapping));
  absl::StatusOr<SceneClassifier> classifier = Make(model, std::move(classes));
  if (!classifier.ok()) return WithContext(classifier.status(), files.model);
  return classifier;
}

absl::StatusOr<SceneClassifier> SceneClassifier::Make(std::string_view onnx, std::vector<SceneClass> classes) {
  if (classes.empty()) return InvalidArgument("the scene classifier has no classes");
  auto network = std::make_unique<Network>();
  network->classes = classes.size();
  // Any error from OpenCV here is the model's fault, not this program's.
  const absl::Status status = GuardOpenCv("the scene classifier's model", [&]() -> absl::Status {
    network->net = cv::dnn::readNetFromONNX(onnx.data(), onnx.size());
    if (network->net.empty()) return InvalidArgument("the scene classifier's model has no layers");
    return network->Run(Preprocess(cv::Mat(kCrop, kCrop, CV_8UC3, cv::Scalar(128, 128, 128)))).status();
  });
  if (status.code() == absl::StatusCode::kInternal) {
    return InvalidArgument("{}; expected an ONNX network that takes 1x3x224x224", std::string(status.message()));
  }
  ENFILADE_RETURN_IF_ERROR(status);
  return SceneClassifier(std::move(network), std::move(classes));
}

absl::StatusOr<SceneVerdict> SceneClassifier::Classify(const ColorFrame& frame) {
  ENFILADE_RETURN_IF_ERROR(Validate(frame));
  return GuardOpenCv("classifying a scene", [&]() -> absl::StatusOr<SceneVerdict> {
    const cv::Mat rgb(frame.height, frame.width, CV_8UC3, const_cast<std::uint8_t*>(frame.samples.data()));
    ENFILADE_ASSIGN_OR_RETURN(const cv::Mat scores, network_->Run(Preprocess(rgb)));
    const std::vector<double> shares = Softmax(scores);
    SceneVerdict verdict;
    for (std::size_t i = 0; i < shares.size(); ++i) {
      if (classes_[i].environment == Environment::kOutdoor) verdict.outdoor_probability += shares[i];
      if (shares[i] > verdict.best_probability) {
        verdict.best_probability = shares[i];
        verdict.best_class = classes_[i].name;
      }
    }
    verdict.environment = verdict.outdoor_probability > 0.5 ? Environment::kOutdoor : Environment::kIndoor;
    return verdict;
  });
}

}  // namespace enfilade::perception

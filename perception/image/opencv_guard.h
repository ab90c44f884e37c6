// SPDX-License-Identifier: Apache-2.0
#pragma once

// For perception only: nothing outside it sees OpenCV.

#include <new>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/error.h"

namespace enfilade::perception {

#if defined(__SANITIZE_THREAD__)
// ThreadSanitizer cannot see how OpenCV's pool synchronises its threads and reports false races: tens of thousands for
// a pair of images, each of which takes time even if suppressed.
inline const bool kOpenCvRunsOnOneThread = (cv::setNumThreads(1), true);
#endif

// Runs `work`, which returns a Status or a StatusOr, and converts OpenCV's exceptions: INTERNAL with `what` and
// OpenCV's message, RESOURCE_EXHAUSTED if memory ran out.
template <typename Work>
auto GuardOpenCv(const char* what, Work&& work) -> decltype(work()) {
  try {
    return std::forward<Work>(work)();
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) return ResourceExhausted("{}: OpenCV is out of memory: {}", what, error.err);
    return Internal("{}: OpenCV failed: {}", what, error.err);
  } catch (const std::bad_alloc&) {
    return ResourceExhausted("{}: out of memory", what);
  }
}

}  // namespace enfilade::perception

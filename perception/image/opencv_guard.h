// SPDX-License-Identifier: Apache-2.0
#pragma once

// For sources of this folder only: nothing outside of perception sees OpenCV.

#include <new>
#include <opencv2/core.hpp>
#include <utility>

#include "absl/status/statusor.h"
#include "core/base/error.h"

namespace enfilade::perception {

#if defined(__SANITIZE_THREAD__)
// ThreadSanitizer sees nothing of how OpenCV's pool hands work from thread to thread, and takes all of it for races:
// tens of thousands for a pair of images, each of which takes time even where it is suppressed.
inline const bool kOpenCvRunsOnOneThread = (cv::setNumThreads(1), true);
#endif

// Runs `work`, which returns a Status or a StatusOr; OpenCV's exceptions end here. INTERNAL with `what` and OpenCV's
// words, RESOURCE_EXHAUSTED where memory ran out.
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

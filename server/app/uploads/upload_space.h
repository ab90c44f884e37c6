// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "absl/base/thread_annotations.h"
#include "core/base/mutex.h"

namespace enfilade::server {

// What uploads under way may hold, in memory and on disk, of all calls together. Thread-safe.
class UploadSpace {
 public:
  struct Options {
    std::string directory;          // for what does not fit into memory
    std::int64_t memory_bytes = 0;  // at most
    std::int64_t disk_bytes = 0;    // at most
  };
  // At present.
  struct Use {
    std::int64_t memory_bytes = 0;
    std::int64_t disk_bytes = 0;
  };

  // `on_change`: called with each change, from any thread, one call at a time. Null: nothing is called.
  explicit UploadSpace(Options options, std::function<void(const Use&)> on_change = nullptr)
      : options_(std::move(options)), on_change_(std::move(on_change)) {}
  UploadSpace(const UploadSpace&) = delete;
  UploadSpace& operator=(const UploadSpace&) = delete;

  const Options& options() const { return options_; }
  Use use() const;

  // False, and nothing is taken, if there is not so much left.
  [[nodiscard]] bool TakeMemory(std::int64_t bytes);
  [[nodiscard]] bool TakeDisk(std::int64_t bytes);
  void Return(const Use& use);

 private:
  const Options options_;
  const std::function<void(const Use&)> on_change_;
  mutable Mutex mutex_;
  Use use_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace enfilade::server

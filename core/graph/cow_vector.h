// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <unordered_set>
#include <vector>

namespace enfilade::graph {

// A vector whose copies share their chunks of `kChunk` elements (copy on write): a copy costs one pointer per chunk, a
// change the copy of one chunk, and nobody who reads an older copy sees it or waits. Changes are made between
// construction or copying and `Freeze`; a frozen vector may be copied and read from any thread.
template <typename T, std::size_t kChunk = 128>
class CowVector {
 public:
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return (*chunks_[i / kChunk])[i % kChunk]; }

  T& Mutable(std::size_t i) {
    std::shared_ptr<Chunk>& chunk = chunks_[i / kChunk];
    // Not by use_count(): it does not order another thread's last reads before our writes.
    if (own_.insert(i / kChunk).second) chunk = std::make_shared<Chunk>(*chunk);
    return (*chunk)[i % kChunk];
  }

  T& Append() {
    if (size_ % kChunk == 0) {
      own_.insert(chunks_.size());
      chunks_.push_back(std::make_shared<Chunk>());
    }
    return Mutable(size_++);
  }

  void Freeze() { own_.clear(); }

 private:
  using Chunk = std::array<T, kChunk>;

  std::vector<std::shared_ptr<Chunk>> chunks_;
  std::size_t size_ = 0;
  std::unordered_set<std::size_t> own_;  // the chunks made since the last Freeze
};

}  // namespace enfilade::graph

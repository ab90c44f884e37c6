// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <unordered_set>
#include <vector>

namespace enfilade::graph {

// A copy-on-write vector whose copies share chunks of `kChunk` elements: copying costs one pointer per chunk, a change
// the copy of one chunk. Readers of an older copy never wait and never see changes. Change a vector only between its
// construction or copying and `Freeze`; a frozen vector can be copied and read from any thread.
template <typename T, std::size_t kChunk = 128>
class CowVector {
 public:
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return (*chunks_[i / kChunk])[i % kChunk]; }

  T& Mutable(std::size_t i) {
    std::shared_ptr<Chunk>& chunk = chunks_[i / kChunk];
    // use_count() would not do: it does not order another thread's last reads before our writes.
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
  std::unordered_set<std::size_t> own_;  // chunks created since the last Freeze
};

}  // namespace enfilade::graph

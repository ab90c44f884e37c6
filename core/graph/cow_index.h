// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "core/graph/cow_vector.h"

namespace enfilade::graph {

// A hash map from Key to non-negative integers that shares memory between copies as CowVector does.
template <typename Key>
class CowIndex {
 public:
  CowIndex() { Clear(kChunk); }

  std::size_t size() const { return size_; }

  // -1 if absent.
  int Find(const Key& key) const {
    for (const auto& [k, value] : buckets_[BucketOf(key)]) {
      if (k == key) return value;
    }
    return -1;
  }

  // `key` must be absent.
  void Insert(const Key& key, int value) {
    if (size_ >= kLoad * buckets_.size()) Grow();
    buckets_.Mutable(BucketOf(key)).emplace_back(key, value);
    ++size_;
  }

  // `key` must be present.
  void Erase(const Key& key) {
    Bucket& bucket = buckets_.Mutable(BucketOf(key));
    for (auto& entry : bucket) {
      if (entry.first != key) continue;
      std::swap(entry, bucket.back());
      bucket.pop_back();
      --size_;
      return;
    }
  }

  void Freeze() { buckets_.Freeze(); }

 private:
  using Bucket = std::vector<std::pair<Key, int>>;
  static constexpr std::size_t kChunk = 16;
  static constexpr std::size_t kLoad = 4;

  std::size_t BucketOf(const Key& key) const { return std::hash<Key>()(key) % buckets_.size(); }

  void Clear(std::size_t buckets) {
    buckets_ = {};
    for (std::size_t i = 0; i < buckets; ++i) buckets_.Append();
    size_ = 0;
  }

  void Grow() {
    const CowVector<Bucket, kChunk> old = buckets_;
    Clear(2 * old.size());
    for (std::size_t i = 0; i < old.size(); ++i) {
      for (const auto& [key, value] : old[i]) {
        buckets_.Mutable(BucketOf(key)).emplace_back(key, value);
        ++size_;
      }
    }
  }

  CowVector<Bucket, kChunk> buckets_;
  std::size_t size_ = 0;
};

}  // namespace enfilade::graph

// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/graph_versions.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>

namespace enfilade::client {
namespace {

// Metadata are limited to some kilobytes.
constexpr std::size_t kMaxSites = 16;
constexpr auto kKept = std::chrono::minutes(1);

}  // namespace

void GraphVersions::Note(const grpc::ClientContext& context) {
  const auto& metadata = context.GetServerTrailingMetadata();
  const auto found = metadata.find("enfilade-graph-version");
  if (found == metadata.end()) return;
  const std::string_view text(found->second.data(), found->second.size());
  const std::size_t separator = text.find('=');
  if (separator == std::string_view::npos) return;
  std::int64_t version = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + separator + 1, end, version);
  if (read.ec != std::errc() || read.ptr != end) return;
  const std::string site(text.substr(0, separator));
  const auto now = std::chrono::steady_clock::now();
  MutexLock lock(mutex_);
  std::erase_if(versions_, [&](const auto& known) { return known.second.noted < now - kKept; });
  Version& known = versions_[site];
  known = {std::max(known.version, version), now};
  if (versions_.size() <= kMaxSites) return;
  versions_.erase(std::min_element(versions_.begin(), versions_.end(),
                                   [](const auto& a, const auto& b) { return a.second.noted < b.second.noted; }));
}

void GraphVersions::Send(grpc::ClientContext& context) const {
  const auto since = std::chrono::steady_clock::now() - kKept;
  MutexLock lock(mutex_);
  for (const auto& [site, known] : versions_) {
    if (known.noted < since) continue;
    context.AddMetadata("enfilade-min-graph-version", site + "=" + std::to_string(known.version));
  }
}

}  // namespace enfilade::client

// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/resource_name.h"
#include "core/base/status_macros.h"
#include "proto/convert/names.h"
#include "server/rpc/prior/convert.h"
#include "server/rpc/prior/handlers.h"

namespace enfilade::server {
namespace {

constexpr std::size_t kPriorMapChunkBytes = 1U << 20;
constexpr auto kTimeToReadFile = std::chrono::seconds(30);

// The manifest first, then the files chunk by chunk. One file at a time is in memory.
class PriorMapFiles {
 public:
  PriorMapFiles(const Services& services, storage::CallContext context, convert::PriorMapName name,
                std::vector<storage::PriorMapFile> files)
      : services_(services), context_(std::move(context)), name_(std::move(name)), files_(std::move(files)) {}

  absl::StatusOr<bool> operator()(v1::ExportPriorMapResponse& message) {
    message.Clear();
    if (!std::exchange(manifest_sent_, true)) {
      v1::ExportPriorMapManifest& manifest = *message.mutable_manifest();
      manifest.set_name(convert::NameOf(name_));
      for (const storage::PriorMapFile& file : files_) {
        v1::FileEntry& entry = *manifest.add_files();
        entry.set_name(file.name);
        entry.set_size_bytes(file.size);
        entry.set_sha256(file.sha256);
      }
      return true;
    }
    if (next_ > 0 && offset_ == content_.size()) content_.clear(), offset_ = 0;
    if (content_.empty()) {
      if (next_ == files_.size()) return false;
      // Each file has its own time: a client may read slowly.
      context_.deadline = std::chrono::steady_clock::now() + kTimeToReadFile;
      ENFILADE_ASSIGN_OR_RETURN(content_, services_.blobs.Get(context_, name_.site, files_[next_].sha256));
      ++next_;
    }
    v1::FileChunk& chunk = *message.mutable_chunk();
    chunk.set_file(static_cast<std::int32_t>(next_ - 1));
    chunk.set_offset(static_cast<std::int64_t>(offset_));
    chunk.set_data(content_.substr(offset_, kPriorMapChunkBytes));
    offset_ += chunk.data().size();
    return true;
  }

 private:
  const Services& services_;
  storage::CallContext context_;
  convert::PriorMapName name_;
  std::vector<storage::PriorMapFile> files_;
  bool manifest_sent_ = false;
  std::size_t next_ = 0;  // the file after `content_`
  std::string content_;
  std::size_t offset_ = 0;
};

}  // namespace

absl::StatusOr<MessageSource<v1::ExportPriorMapResponse>> ExportPriorMap(const Services& services, const Call& call,
                                                                         const v1::ExportPriorMapRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const convert::PriorMapName name, convert::ParsePriorMapName("name", request.name()));
  ENFILADE_ASSIGN_OR_RETURN(const auto products, ProductsOf(request.products()));
  ENFILADE_RETURN_IF_ERROR(services.prior_maps.Get(call.context(), name.site, name.prior_map).status());
  ENFILADE_ASSIGN_OR_RETURN(auto files, services.prior_maps.ListFiles(call.context(), name.site, name.prior_map));
  for (const storage::PriorMapProduct product : products) {
    const bool is_there = std::any_of(files.begin(), files.end(),
                                      [&](const storage::PriorMapFile& file) { return file.product == product; });
    if (!is_there) return FailedPrecondition("{} is not aligned yet", convert::NameOf(name));
  }
  std::erase_if(files, [&](const storage::PriorMapFile& file) {
    if (file.product == storage::PriorMapProduct::kTies) return true;  // for the server's own use
    return !products.empty() && std::find(products.begin(), products.end(), file.product) == products.end();
  });
  return PriorMapFiles(services, call.context(), name, std::move(files));
}

}  // namespace enfilade::server

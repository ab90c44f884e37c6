// SPDX-License-Identifier: Apache-2.0
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "core/grid/tile_codec.h"
#include "proto/convert/names.h"
#include "server/rpc/raster/handlers.h"

namespace enfilade::server {
namespace {

constexpr int kMaxTiles = 256;

// Each once, in their order.
absl::StatusOr<std::vector<std::string>> DigestsOf(const v1::ReadTilesRequest& request) {
  if (request.sha256_size() == 0 || request.sha256_size() > kMaxTiles) {
    return InvalidArgument("sha256 has {} values: expected 1 to {}", request.sha256_size(), kMaxTiles);
  }
  std::vector<std::string> digests;
  std::set<std::string> known;
  for (const std::string& digest : request.sha256()) {
    if (digest.size() != 32) return InvalidArgument("sha256 has a value of {} bytes: expected 32", digest.size());
    if (known.insert(digest).second) digests.push_back(digest);
  }
  return digests;
}

}  // namespace

absl::StatusOr<MessageSource<v1::ReadTilesResponse>> ReadTiles(const Services& services, const Call& call,
                                                               const v1::ReadTilesRequest& request) {
  ENFILADE_ASSIGN_OR_RETURN(const SiteId site, convert::ParseSiteName("parent", request.parent()));
  ENFILADE_ASSIGN_OR_RETURN(std::vector<std::string> digests, DigestsOf(request));
  ENFILADE_ASSIGN_OR_RETURN(auto read, services.pyramids.ReadTiles(call.context(), site, digests));
  for (const std::string& digest : digests) {
    if (!read.contains(digest)) return NotFound("tile {} of {} does not exist", ToHex(digest), NameOf(site));
  }
  const auto tiles = std::make_shared<const std::map<std::string, std::string>>(std::move(read));
  return [tiles, digests = std::move(digests),
          next = std::size_t{0}](v1::ReadTilesResponse& message) mutable -> absl::StatusOr<bool> {
    if (next == digests.size()) return false;
    message.set_sha256(digests[next]);
    message.set_zstd_cells(std::string(grid::FrameOfTile(tiles->at(digests[next]))));
    ++next;
    return true;
  };
}

}  // namespace enfilade::server

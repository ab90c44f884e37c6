// SPDX-License-Identifier: Apache-2.0
#include "core/slam/submaps/submap.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/compression/compression.h"
#include "core/geometry/pose_codec.h"

namespace enfilade::slam {
namespace {

constexpr std::uint8_t kSubmapVersion = 1;
constexpr std::size_t kMaxContentBytes = std::size_t{1} << 30;

void PutNode(BinaryWriter& writer, const SubmapNode& node) {
  writer.Put(node.node);
  writer.Put<std::uint8_t>(node.carried);
  writer.Put(node.length);
  PutPose(writer, node.T_submap_node);
  PutMatrix(writer, node.information);
}

SubmapNode GetNode(BinaryReader& reader) {
  SubmapNode node;
  node.node = reader.Get<std::int64_t>();
  node.carried = reader.Get<std::uint8_t>() != 0;
  node.length = reader.Get<double>();
  node.T_submap_node = GetPose(reader);
  node.information = GetMatrix(reader);
  return node;
}

void PutNext(BinaryWriter& writer, const std::optional<NextSubmap>& next) {
  writer.Put<std::uint8_t>(next.has_value());
  PutPose(writer, next.value_or(NextSubmap{}).T_submap_next);
  PutMatrix(writer, next.value_or(NextSubmap{}).information);
}

std::optional<NextSubmap> GetNext(BinaryReader& reader) {
  const bool has_value = reader.Get<std::uint8_t>() != 0;
  NextSubmap next;
  next.T_submap_next = GetPose(reader);
  next.information = GetMatrix(reader);
  return has_value ? std::optional(next) : std::nullopt;
}

template <typename T, typename PutOne>
void PutAll(BinaryWriter& writer, const std::vector<T>& items, PutOne put) {
  writer.Put<std::uint64_t>(items.size());
  for (const T& item : items) put(writer, item);
}

template <typename T, typename GetOne>
void GetAll(BinaryReader& reader, std::vector<T>& items, GetOne get) {
  items.clear();
  for (auto n = reader.Get<std::uint64_t>(); n > 0 && reader.ok(); --n) items.push_back(get(reader));
}

}  // namespace

int Submap::own_nodes() const {
  return static_cast<int>(
      std::count_if(content.nodes.begin(), content.nodes.end(), [](const SubmapNode& n) { return !n.carried; }));
}

std::size_t Submap::bytes() const {
  std::size_t bytes = content.grid.bytes() + content.nodes.capacity() * sizeof(SubmapNode);
  for (const grid::ScanRays& rays : content.scans) {
    bytes += sizeof(grid::ScanRays) + (rays.hits.capacity() + rays.free_ends.capacity()) * sizeof(Eigen::Vector2d);
  }
  return bytes;
}

void Serialize(const SubmapContent& content, BinaryWriter& writer) {
  writer.Put(kSubmapVersion);
  PutAll(writer, content.nodes, PutNode);
  PutNext(writer, content.next);
  PutAll(writer, content.scans, PutRays);
  content.grid.Serialize(writer);
}

absl::StatusOr<SubmapContent> DeserializeSubmapContent(BinaryReader& reader, const OccupancyOptions& options) {
  if (reader.Get<std::uint8_t>() != kSubmapVersion)
    return DataLoss("a submap's content has a version that this program does not know");
  std::vector<SubmapNode> nodes;
  std::vector<grid::ScanRays> scans;
  GetAll(reader, nodes, GetNode);
  std::optional<NextSubmap> next = GetNext(reader);
  GetAll(reader, scans, GetRays);
  if (!reader.ok() || (!scans.empty() && nodes.size() != scans.size())) {
    return DataLoss("a submap's content is damaged");
  }
  ENFILADE_ASSIGN_OR_RETURN(SubmapGrid grid, SubmapGrid::Deserialize(reader, options));
  return SubmapContent{std::move(nodes), std::move(next), std::move(scans), std::move(grid)};
}

std::string Encode(const SubmapContent& content) {
  SubmapContent stored{content.nodes, content.next, {}, content.grid};
  stored.grid.Crop();
  stored.grid.RoundMeans();
  std::string bytes;
  BinaryWriter writer(bytes);
  Serialize(stored, writer);
  return Compress(bytes);
}

absl::StatusOr<SubmapContent> DecodeSubmapContent(std::string_view bytes, const OccupancyOptions& options) {
  ENFILADE_ASSIGN_OR_RETURN(const std::string raw, Decompress(bytes, kMaxContentBytes));
  BinaryReader reader(raw);
  ENFILADE_ASSIGN_OR_RETURN(SubmapContent content, DeserializeSubmapContent(reader, options));
  if (!reader.at_end()) return DataLoss("a submap's content has trailing bytes");
  return content;
}

}  // namespace enfilade::slam

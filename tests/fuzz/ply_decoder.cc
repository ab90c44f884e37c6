// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/decode_cloud.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {
namespace {

std::string Header(const std::string& format, const std::string& type) {
  return "ply\nformat " + format + " 1.0\ncomment by the project\nelement vertex 2\nproperty " + type +
         " x\nproperty " + type + " y\nproperty " + type + " z\nproperty uchar red\nend_header\n";
}

}  // namespace

std::vector<std::string> Seeds() {
  return {Header("ascii", "float") + "1 2 3 4\n5 6 7 8\n",
          Header("binary_little_endian", "float") + std::string(26, '\x3F'),
          Header("binary_little_endian", "double") + std::string(50, '\x3F'),
          "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
          "element face 1\nproperty list uchar int vertex_indices\nend_header\n1 2 3\n3 0 0 0\n"};
}

bool Decode(std::string_view bytes) {
  (void)perception::DecodeCloud(bytes);
  const auto cloud = perception::DecodePly(bytes);
  if (cloud.ok()) Expect(cloud->points.size() <= perception::kMaxCloudPoints, "no more points than the limit");
  return cloud.ok();
}

}  // namespace enfilade::fuzz

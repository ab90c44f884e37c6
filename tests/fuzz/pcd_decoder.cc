// SPDX-License-Identifier: Apache-2.0
// PCD, and bare float32 x y z, which has no header.
#include "perception/cloud/decode_cloud.h"
#include "tests/fuzz/decoder.h"

namespace enfilade::fuzz {
namespace {

std::string Header(const std::string& data) {
  return "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1\nWIDTH 3\n"
         "HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 3\nDATA " +
         data + "\n";
}

}  // namespace

std::vector<std::string> Seeds() {
  const std::string points(39, '\x3F');
  // 39 bytes as literals of at most 32, each after its length less one.
  const std::string literals = std::string("\x1F") + points.substr(0, 32) + '\x06' + points.substr(0, 7);
  const std::string sizes = std::string("\x29\0\0\0", 4) + std::string("\x27\0\0\0", 4);
  return {Header("ascii") + "1 2 3 4\n-1.5 nan 0 255\n1e3 2e-3 0 0\n", Header("binary") + points,
          Header("binary_compressed") + sizes + literals};
}

bool Decode(std::string_view bytes) {
  (void)perception::DecodeXyz32(bytes);
  const auto cloud = perception::DecodePcd(bytes);
  if (cloud.ok()) Expect(cloud->points.size() <= perception::kMaxCloudPoints, "no more points than the limit");
  return cloud.ok();
}

}  // namespace enfilade::fuzz

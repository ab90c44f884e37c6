// SPDX-License-Identifier: Apache-2.0
#include "perception/cloud/lzf.h"

#include <algorithm>
#include <cstddef>

#include "core/base/error.h"

namespace enfilade::perception {

absl::StatusOr<std::string> UnpackLzf(std::string_view packed, std::size_t size) {
  std::string out;
  out.reserve(std::min(size, 100 * packed.size()));  // a reference of 3 bytes gives at most 264
  std::size_t position = 0;
  const auto next = [&] { return static_cast<unsigned char>(packed[position++]); };
  while (position < packed.size()) {
    const std::size_t control = next();
    if (control < 32) {  // a literal run of control + 1 bytes
      if (packed.size() - position < control + 1) return DataLoss("LZF: a run exceeds the input");
      out.append(packed.substr(position, control + 1));
      position += control + 1;
    } else {  // a reference to earlier bytes
      std::size_t length = control >> 5;
      if (packed.size() - position < (length == 7 ? 2U : 1U)) return DataLoss("LZF: a reference is truncated");
      if (length == 7) length += next();
      length += 2;
      const std::size_t distance = ((control & 31U) << 8 | next()) + 1;
      if (distance > out.size()) return DataLoss("LZF: a reference precedes the start");
      if (length > size - std::min(size, out.size())) return DataLoss("LZF: more than {} bytes", size);
      for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - distance]);  // may overlap itself
    }
    if (out.size() > size) return DataLoss("LZF: more than {} bytes", size);
  }
  if (out.size() != size) return DataLoss("LZF: {} bytes instead of {}", out.size(), size);
  return out;
}

}  // namespace enfilade::perception

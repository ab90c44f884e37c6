// SPDX-License-Identifier: Apache-2.0
#include "storage/postgres/driver/params.h"

namespace enfilade::storage::postgres {

Params::Bound Params::Bind() const {
  // libpq takes a null pointer for NULL, so that an empty text needs one that is not null.
  static constexpr char kEmpty[] = "";
  Bound bound;
  bound.formats.assign(params_.size(), 1);
  for (const Param& param : params_) {
    bound.types.push_back(static_cast<unsigned>(param.type));
    bound.lengths.push_back(static_cast<int>(param.size));
    if (param.place == kNull) {
      bound.values.push_back(nullptr);
    } else if (param.place == kView) {
      bound.values.push_back(param.view ? param.view : kEmpty);
    } else {
      bound.values.push_back(buffer_.data() + param.place);
    }
  }
  return bound;
}

// array_recv: dimensions, a flag for nulls, the element's type, then each dimension's length and lower bound.
void Params::AppendArrayHeader(TypeOid element_type, std::size_t count) {
  AppendBinary(std::int32_t{count > 0 ? 1 : 0}, buffer_);
  AppendBinary(std::int32_t{0}, buffer_);
  AppendBinary(static_cast<std::int32_t>(element_type), buffer_);
  if (count == 0) return;
  AppendBinary(static_cast<std::int32_t>(count), buffer_);
  AppendBinary(std::int32_t{1}, buffer_);
}

void Params::AppendElement(std::string_view value) {
  AppendBinary(static_cast<std::int32_t>(value.size()), buffer_);
  buffer_.append(value);
}

}  // namespace enfilade::storage::postgres

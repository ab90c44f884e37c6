// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace enfilade::perception::testing {

// Writes protobuf's wire format by hand, for small ONNX models (onnx.proto3, IR version 7, opset 11) without the onnx
// package.
class ProtoWriter {
 public:
  ProtoWriter& Int(int field, std::uint64_t value) {
    Varint(static_cast<std::uint64_t>(field) << 3);
    Varint(value);
    return *this;
  }
  ProtoWriter& Bytes(int field, const std::string& bytes) {
    Varint(static_cast<std::uint64_t>(field) << 3 | 2);
    Varint(bytes.size());
    out_ += bytes;
    return *this;
  }
  const std::string& out() const { return out_; }

 private:
  void Varint(std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out_ += static_cast<char>(value | 0x80);
    out_ += static_cast<char>(value);
  }
  std::string out_;
};

inline std::string OnnxNode(const std::string& op, const std::vector<std::string>& inputs, const std::string& output,
                            const std::string& int_attribute = "", std::uint64_t value = 0) {
  ProtoWriter node;
  for (const std::string& input : inputs) node.Bytes(1, input);
  node.Bytes(2, output).Bytes(3, output).Bytes(4, op);
  if (!int_attribute.empty()) {
    node.Bytes(5, ProtoWriter().Bytes(1, int_attribute).Int(3, value).Int(20, 2).out());
  }
  return node.out();
}

inline std::string OnnxTensor(const std::string& name, const std::vector<std::uint64_t>& dims,
                              const std::vector<float>& values) {
  ProtoWriter tensor;
  for (const std::uint64_t dim : dims) tensor.Int(1, dim);
  std::string raw(values.size() * sizeof(float), '\0');
  std::memcpy(raw.data(), values.data(), raw.size());
  return tensor.Int(2, 1).Bytes(8, name).Bytes(9, raw).out();
}

inline std::string OnnxValue(const std::string& name, const std::vector<std::uint64_t>& dims) {
  ProtoWriter shape;
  for (const std::uint64_t dim : dims) shape.Bytes(1, ProtoWriter().Int(1, dim).out());
  const std::string tensor = ProtoWriter().Int(1, 1).Bytes(2, shape.out()).out();
  return ProtoWriter().Bytes(1, name).Bytes(2, ProtoWriter().Bytes(1, tensor).out()).out();
}

// A network that looks at the mean colour of its input: scores = W (classes x 3) * mean + b.
inline std::string MeanColorModel(const std::vector<float>& weights, const std::vector<float>& bias, std::uint64_t side,
                                  std::uint64_t channels = 3) {
  const std::uint64_t classes = bias.size();
  ProtoWriter graph;
  graph.Bytes(1, OnnxNode("GlobalAveragePool", {"image"}, "pooled"))
      .Bytes(1, OnnxNode("Flatten", {"pooled"}, "flat", "axis", 1))
      .Bytes(1, OnnxNode("Gemm", {"flat", "weights", "bias"}, "scores", "transB", 1))
      .Bytes(2, "mean_color")
      .Bytes(5, OnnxTensor("weights", {classes, channels}, weights))
      .Bytes(5, OnnxTensor("bias", {classes}, bias))
      .Bytes(11, OnnxValue("image", {1, channels, side, side}))
      .Bytes(12, OnnxValue("scores", {1, classes}));
  return ProtoWriter().Int(1, 7).Bytes(7, graph.out()).Bytes(8, ProtoWriter().Bytes(1, "").Int(2, 11).out()).out();
}

}  // namespace enfilade::perception::testing

// SPDX-License-Identifier: Apache-2.0
#include "core/prior/formats/svg_plan.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <sstream>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "core/prior/formats/plan_lines.h"
#include "core/prior/formats/svg_numbers.h"
#include "fmt/format.h"

namespace enfilade::prior {
namespace {

using Eigen::Affine2d;
using Eigen::Vector2d;

std::string_view LocalName(const pugi::xml_node& node) {
  const std::string_view name = node.name();
  const std::size_t colon = name.find(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

// A property of the style attribute, or the attribute of that name.
std::string StyleOf(const pugi::xml_node& node, const std::string& property) {
  const std::string style = node.attribute("style").value();
  std::size_t at = 0;
  while (at < style.size()) {
    const std::size_t end = std::min(style.find(';', at), style.size());
    const std::string part = style.substr(at, end - at);
    at = end + 1;
    const std::size_t colon = part.find(':');
    if (colon == std::string::npos) continue;
    const std::size_t first = part.find_first_not_of(" \t\r\n");
    const std::size_t value = part.find_first_not_of(" \t\r\n", colon + 1);
    if (first < colon && part.substr(first, property.size()) == property &&
        part.find_first_not_of(" \t", first + property.size()) == colon && value != std::string::npos) {
      return part.substr(value);
    }
  }
  return node.attribute(property.c_str()).value();
}

// What an element takes over from those around it.
struct Inherited {
  Affine2d T = Affine2d::Identity();
  double stroke_width = 1;
  bool dashed = false;
  bool wanted = false;
  int uses = 0;
};

class SvgReader {
 public:
  SvgReader(const pugi::xml_document& document, const std::vector<std::string>& layers)
      : document_(document), layers_(layers) {}

  absl::StatusOr<VectorPlan> Read() {
    const pugi::xml_node root = document_.document_element();
    if (LocalName(root) != "svg") return InvalidArgument("not an SVG drawing");
    Inherited inherited;
    inherited.wanted = layers_.empty();
    ENFILADE_RETURN_IF_ERROR(ReadChildren(root, inherited, 0));
    VectorPlan plan{lines_.TakePlan(), {}};
    for (const std::string& left_out : left_out_) plan.warnings.push_back("left out: " + left_out);
    return plan;
  }

 private:
  static constexpr int kDeepest = 200;  // elements within each other
  static constexpr int kMostUses = 8;
  // What is used repeatedly counts each time, by the length of its attributes, too.
  static constexpr std::int64_t kMostElements = 4'000'000;
  static constexpr std::size_t kElementBytes = 64;

  absl::Status ReadChildren(const pugi::xml_node& node, const Inherited& inherited, int depth) {
    if (depth > kDeepest) return InvalidArgument("more than {} SVG elements within each other", kDeepest);
    for (const pugi::xml_node& child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      ENFILADE_RETURN_IF_ERROR(ReadElement(child, inherited, depth));
    }
    return lines_.status();
  }

  absl::Status Count(const pugi::xml_node& node) {
    std::size_t bytes = 0;
    for (const pugi::xml_attribute& attribute : node.attributes()) bytes += std::strlen(attribute.value());
    elements_ += 1 + static_cast<std::int64_t>(bytes / kElementBytes);
    if (elements_ <= kMostElements) return absl::OkStatus();
    return ResourceExhausted("more than {} SVG elements, with those that are used repeatedly", kMostElements);
  }

  absl::Status ReadElement(const pugi::xml_node& node, const Inherited& around, int depth) {
    ENFILADE_RETURN_IF_ERROR(Count(node));
    const std::string_view name = LocalName(node);
    if (name == "script" || name == "image" || name == "foreignObject") {
      left_out_.insert(std::string(name));
      return absl::OkStatus();
    }
    if (StyleOf(node, "display") == "none" || StyleOf(node, "visibility") == "hidden") return absl::OkStatus();
    const Inherited inherited = InheritedBy(node, around);
    if (name == "g" || name == "a" || name == "svg" || name == "switch") {
      return ReadChildren(node, inherited, depth + 1);
    }
    if (name == "use") return ReadUse(node, inherited, depth);
    if (inherited.wanted && !inherited.dashed) ReadShape(node, name, inherited);
    return lines_.status();
  }

  Inherited InheritedBy(const pugi::xml_node& node, Inherited inherited) const {
    inherited.T = inherited.T * SvgTransform(node.attribute("transform").value());
    if (const std::string width = StyleOf(node, "stroke-width"); !width.empty()) {
      inherited.stroke_width = SvgNumber(width, inherited.stroke_width);
    }
    if (const std::string dashes = StyleOf(node, "stroke-dasharray"); !dashes.empty()) {
      inherited.dashed = dashes.substr(0, 4) != "none";
    }
    if (!inherited.wanted) {
      for (const char* attribute : {"inkscape:label", "id", "class"}) {
        const char* value = node.attribute(attribute).value();
        inherited.wanted = inherited.wanted || (*value != '\0' && IsWantedLayer(layers_, value));
      }
    }
    return inherited;
  }

  absl::Status ReadUse(const pugi::xml_node& node, Inherited inherited, int depth) {
    std::string_view target = node.attribute("href").value();
    if (target.empty()) target = node.attribute("xlink:href").value();
    if (target.empty()) return absl::OkStatus();
    if (target[0] != '#') {
      left_out_.insert("references to other files");
      return absl::OkStatus();
    }
    if (++inherited.uses > kMostUses) {
      return InvalidArgument("use of \"{}\": more than {} within each other", target, kMostUses);
    }
    if (ids_.empty()) CollectIds();
    const auto found = ids_.find(std::string(target.substr(1)));
    if (found == ids_.end()) return absl::OkStatus();
    inherited.T.translate(
        Vector2d(SvgNumber(node.attribute("x").value(), 0), SvgNumber(node.attribute("y").value(), 0)));
    if (LocalName(found->second) == "symbol") return ReadChildren(found->second, inherited, depth + 1);
    if (depth > kDeepest) return InvalidArgument("more than {} SVG elements within each other", kDeepest);
    return ReadElement(found->second, inherited, depth + 1);
  }

  void CollectIds() {
    struct Walker : pugi::xml_tree_walker {
      std::map<std::string, pugi::xml_node>* ids = nullptr;
      bool for_each(pugi::xml_node& node) override {
        if (const char* id = node.attribute("id").value(); *id != '\0') ids->emplace(id, node);
        return true;
      }
    } walker;
    walker.ids = &ids_;
    const_cast<pugi::xml_document&>(document_).traverse(walker);
  }

  void ReadShape(const pugi::xml_node& node, std::string_view name, const Inherited& inherited) {
    const auto number = [&](const char* attribute) { return SvgNumber(node.attribute(attribute).value(), 0); };
    const double scale = std::sqrt(std::abs(inherited.T.linear().determinant()));
    const double thickness = StyleOf(node, "stroke") == "none" ? 0 : std::max(0.0, inherited.stroke_width * scale);
    if (name == "line") {
      lines_.Add(inherited.T, {{number("x1"), number("y1")}, {number("x2"), number("y2")}}, false, thickness);
    } else if (name == "rect") {
      const Vector2d p(number("x"), number("y")), size(number("width"), number("height"));
      if (size.minCoeff() <= 0) return;
      lines_.Add(inherited.T, {p, p + Vector2d(size.x(), 0), p + size, p + Vector2d(0, size.y())}, true, thickness);
    } else if (name == "polyline" || name == "polygon") {
      std::vector<Vector2d> points;
      SvgScanner scanner(node.attribute("points").value());
      while (const auto point = scanner.Point()) points.push_back(*point);
      lines_.Add(inherited.T, points, name == "polygon", thickness);
    } else if (name == "path") {
      for (const SvgSubpath& subpath : SvgPath(node.attribute("d").value())) {
        lines_.Add(inherited.T, subpath.points, subpath.closed, thickness);
      }
    }
  }

  const pugi::xml_document& document_;
  const std::vector<std::string>& layers_;
  std::map<std::string, pugi::xml_node> ids_;
  std::set<std::string> left_out_;
  PlanLines lines_;
  std::int64_t elements_ = 0;
};

}  // namespace

absl::StatusOr<VectorPlan> ReadSvgPlan(std::string_view text, const std::vector<std::string>& layers) {
  pugi::xml_document document;
  // Without parse_doctype, declarations of entities are skipped and nothing of them is expanded.
  const pugi::xml_parse_result result =
      document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_auto);
  if (!result) {
    return InvalidArgument("not an SVG drawing: {} at byte {}", result.description(), result.offset);
  }
  return SvgReader(document, layers).Read();
}

std::string WriteSvgPlan(const PlanGraph& plan) {
  Eigen::Vector2d low(0, 0);
  Eigen::Vector2d high(0, 0);
  for (const PlanCorner& corner : plan.corners) {
    low = low.cwiseMin(corner.point);
    high = high.cwiseMax(corner.point);
  }
  const Eigen::Vector2d size = high - low;
  const auto number = [](double value) { return fmt::format("{:.3f}", value); };
  pugi::xml_document document;
  pugi::xml_node svg = document.append_child("svg");
  svg.append_attribute("xmlns") = "http://www.w3.org/2000/svg";
  svg.append_attribute("width") = number(size.x()).c_str();
  svg.append_attribute("height") = number(size.y()).c_str();
  svg.append_attribute("viewBox") =
      fmt::format("{:.3f} {:.3f} {:.3f} {:.3f}", low.x(), low.y(), size.x(), size.y()).c_str();
  pugi::xml_node walls = svg.append_child("g");
  walls.append_attribute("id") = "walls";
  walls.append_attribute("stroke") = "black";
  for (const PlanWall& wall : plan.walls) {
    const Eigen::Vector2d from = plan.corners[static_cast<std::size_t>(wall.from)].point;
    const Eigen::Vector2d to = plan.corners[static_cast<std::size_t>(wall.to)].point;
    pugi::xml_node line = walls.append_child("line");
    line.append_attribute("x1") = number(from.x()).c_str();
    line.append_attribute("y1") = number(from.y()).c_str();
    line.append_attribute("x2") = number(to.x()).c_str();
    line.append_attribute("y2") = number(to.y()).c_str();
    line.append_attribute("stroke-width") = number(wall.thickness > 0 ? wall.thickness : 1.0).c_str();
  }
  pugi::xml_node names = svg.append_child("g");
  names.append_attribute("id") = "rooms";
  for (const PlanRoom& room : plan.rooms) {
    if (room.name.empty() || room.outline.empty()) continue;
    Eigen::Vector2d middle(0, 0);
    for (const Eigen::Vector2d& corner : room.outline) middle += corner / static_cast<double>(room.outline.size());
    pugi::xml_node text = names.append_child("text");
    text.append_attribute("x") = number(middle.x()).c_str();
    text.append_attribute("y") = number(middle.y()).c_str();
    text.text() = room.name.c_str();
  }
  std::ostringstream out;
  document.save(out, " ");
  return out.str();
}

}  // namespace enfilade::prior

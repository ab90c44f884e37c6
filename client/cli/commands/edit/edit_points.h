// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "core/edit/map_edit.h"
#include "core/options/strict_mapping.h"

namespace enfilade::cli {

// The points of a file of edits on a lattice: in metres of the map's frame, or in cells, where (3, 5) is the centre of
// the cell in column 3 and row 5. The first error goes into the status of the mapping that the points belong to.
class EditPoints {
 public:
  EditPoints(const edit::Lattice& lattice, bool in_cells) : lattice_(lattice), in_cells_(in_cells) {}

  // [x, y]
  edit::LatticePoint One(yaml_options::StrictMapping& of, const std::string& key, const YAML::Node& value) const;
  // [[x, y], ...]
  std::vector<edit::LatticePoint> Many(yaml_options::StrictMapping& of, const std::string& key,
                                       const YAML::Node& value) const;
  // The corners of the rectangle between two opposite ones, along the axes of the map's frame or of the cells.
  std::vector<edit::LatticePoint> Rectangle(yaml_options::StrictMapping& of, const std::string& key,
                                            const YAML::Node& value) const;
  std::int32_t Length(yaml_options::StrictMapping& of, const std::string& key) const;

 private:
  edit::LatticePoint PointOf(yaml_options::StrictMapping& of, const std::string& key, const YAML::Node& where, double x,
                             double y) const;

  const edit::Lattice& lattice_;
  bool in_cells_;
};

// The box around the cells of points.
edit::CellBox BoxAround(const std::vector<edit::LatticePoint>& points);

}  // namespace enfilade::cli

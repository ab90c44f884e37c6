// SPDX-License-Identifier: Apache-2.0
#include "core/edit/apply.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/grid/occupancy_values.h"
#include "tests/support/status_assertions.h"
#include "tests/unit/core/edit/covered_cells.h"
#include "tests/unit/core/edit/edited_maps.h"

namespace enfilade::edit {
namespace {

using grid::CellClass;
using grid::GreyCells;
using grid::GreyInterpretation;
using grid::MapDialect;
using grid::MapMode;
using grid::MapRaster;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr auto kPrecondition = absl::StatusCode::kFailedPrecondition;

grid::GridGeometry SizedGrid(int width, int height) { return {0.05, {}, width, height}; }

// Of a raster far from the origin of its lattice.
grid::RasterHeader FarHeaderOf(const MapRaster& raster) {
  grid::RasterHeader header{.raster = {raster.geometry, raster.cells}, .lattice_min = {-7, 250}};
  if (auto* const grey = std::get_if<GreyCells>(&header.raster.cells)) {
    header.has_alpha = !grey->alpha.empty();
    grey->grey.clear();
    grey->alpha.clear();
  }
  if (auto* const unit = std::get_if<grid::UnitCells>(&header.raster.cells)) unit->values.clear();
  if (auto* const own = std::get_if<grid::OccupancyCells>(&header.raster.cells)) own->values.clear();
  return header;
}

// Whether any value of the form reads back as the instruction says.
bool HasValueFor(const MapRaster& raster, Instruction instruction) {
  const std::int8_t wanted = instruction == Instruction::kUnknown
                                 ? grid::kUnknownValue
                                 : (instruction == Instruction::kFree ? std::int8_t{0} : std::int8_t{100});
  if (std::holds_alternative<grid::UnitCells>(raster.cells)) return instruction != Instruction::kUnknown;
  const auto* const grey = std::get_if<GreyCells>(&raster.cells);
  if (grey == nullptr) return true;
  const auto values = grid::LoadedValues(grey->interpretation, grey->max_value);
  for (int level = 0; level <= grey->max_value; ++level) {
    if (grey->alpha.empty() && values[static_cast<std::size_t>(level)] == wanted) return true;
    for (const int alpha : {0, 255}) {
      if (!grey->alpha.empty() && grid::LoadedValue(grey->interpretation, level, alpha) == wanted) return true;
    }
  }
  return false;
}

TEST(ApplyEdits, EveryFormSaysWhatItCanAndKeepsAllOtherCells) {
  std::mt19937 random(22);
  int said = 0;
  int refused = 0;
  for (const MapRaster& form : EveryForm(random)) {
    ASSERT_OK(grid::Validate(form));
    for (const Instruction instruction : {Instruction::kUnknown, Instruction::kFree, Instruction::kOccupied}) {
      const bool can = HasValueFor(form, instruction);
      ASSERT_EQ(CanSay(FarHeaderOf(form), instruction).ok(), can) << NameOf(form) << static_cast<int>(instruction);
      Overlay overlay;
      overlay.Draw({instruction, Brush{{Centre(-3, 255), Centre(9, 262)}, 800}, false});
      MapRaster edited = form;
      const absl::Status applied = Apply(overlay, {-7, 250}, edited);
      ASSERT_EQ(applied.ok(), can) << NameOf(form);
      if (can) {
        ExpectExactlyApplied(form, edited, overlay, {-7, 250});
      } else {
        EXPECT_EQ(applied.code(), kPrecondition);
        EXPECT_EQ(edited, form) << "a refused edit has changed " << NameOf(form);
      }
      (can ? said : refused) += 1;
    }
  }
  EXPECT_GT(said, 200);
  EXPECT_GT(refused, 20);
}

GreyCells OneGrey(GreyInterpretation by, int max_value = 255, std::uint8_t grey = 128) {
  return {.grey = {grey}, .max_value = max_value, .interpretation = by};
}
// The grey that a single cell gets.
int GreyAfter(GreyCells cells, Instruction instruction) {
  MapRaster raster{SizedGrid(1, 1), std::move(cells)};
  Overlay overlay;
  overlay.Draw({instruction, Line{Centres({{0, 0}})}, false});
  const absl::Status applied = Apply(overlay, {0, 0}, raster);
  EXPECT_OK(applied);
  return std::get<GreyCells>(raster.cells).grey[0];
}

TEST(ApplyEdits, UsualGreysAreNav2s) {
  const GreyInterpretation usual;
  EXPECT_EQ(GreyAfter(OneGrey(usual), Instruction::kFree), 254);
  EXPECT_EQ(GreyAfter(OneGrey(usual), Instruction::kOccupied), 0);
  EXPECT_EQ(GreyAfter(OneGrey(usual), Instruction::kUnknown), 205);
  GreyInterpretation negated = usual;
  negated.negate = true;
  EXPECT_EQ(GreyAfter(OneGrey(negated), Instruction::kFree), 1);
  EXPECT_EQ(GreyAfter(OneGrey(negated), Instruction::kOccupied), 255);
  EXPECT_EQ(GreyAfter(OneGrey(negated), Instruction::kUnknown), 50);
}

// 205 is the grey that Nav2 writes for "unknown", and 0.25 the free_thresh that it writes beside it: it reads as free.
TEST(ApplyEdits, A205ThatReadsAsFreeIsNotUsedForUnknown) {
  GreyInterpretation by;
  by.free_thresh = 0.25;
  EXPECT_EQ(grid::LoadedValue(by, 205), 0);
  const int grey = GreyAfter(OneGrey(by), Instruction::kUnknown);
  EXPECT_EQ(grid::LoadedValue(by, grey), grid::kUnknownValue);
  EXPECT_EQ(grey, 191);  // the nearest
}

TEST(ApplyEdits, RefusalsNameTheFormAndTheRemedy) {
  GreyInterpretation scale;
  scale.mode = MapMode::kScale;
  MapRaster raster{SizedGrid(1, 1), OneGrey(scale)};
  EXPECT_STATUS(CanSay(FarHeaderOf(raster), Instruction::kUnknown), kPrecondition,
                AllOf(HasSubstr("mode scale"), HasSubstr("reads back as unknown"), HasSubstr("free or occupied")));
  EXPECT_OK(CanSay(FarHeaderOf(raster), Instruction::kFree));
  raster.cells = grid::UnitCells{{0.5}, {}};
  EXPECT_STATUS(CanSay(FarHeaderOf(raster), Instruction::kUnknown), kPrecondition, HasSubstr("JSON"));
  GreyInterpretation raw;
  raw.mode = MapMode::kRaw;
  raster.cells = OneGrey(raw, 1, 0);  // 0 or 255, which is unknown
  EXPECT_STATUS(CanSay(FarHeaderOf(raster), Instruction::kOccupied), kPrecondition,
                AllOf(HasSubstr("mode raw"), HasSubstr("occupied")));
  EXPECT_OK(CanSay(FarHeaderOf(raster), Instruction::kNone));
  EXPECT_OK(CanSay(FarHeaderOf(raster), Instruction::kClear));
}

// A refusal because of one cell changes none, and cells outside of the raster are no reason.
TEST(ApplyEdits, AreAllOrNone) {
  const MapRaster before{SizedGrid(4, 2), grid::UnitCells{{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}, {}}};
  MapRaster raster = before;
  EXPECT_CODE(Apply(OverlayIn({"####", "---?"}), {0, 0}, raster), kPrecondition);
  EXPECT_EQ(raster, before);
  EXPECT_OK(Apply(OverlayIn({"??????", "?-#..?", "?....?", "??????"}), {1, 1}, raster));
  EXPECT_EQ(std::get<grid::UnitCells>(raster.cells).values,
            (std::vector<double>{0.1, 0.2, 0.3, 0.4, 0.0, 1.0, 0.7, 0.8}));
}

TEST(ApplyEdits, CellsOfOurOwnMapsBecomeCertain) {
  MapRaster raster{SizedGrid(4, 1), grid::OccupancyCells{{7, 7, 7, 7}}};
  EXPECT_OK(Apply(OverlayIn({"?-#"}, -5, 9), {-5, 9}, raster));
  EXPECT_EQ(std::get<grid::OccupancyCells>(raster.cells).values, (std::vector<std::uint8_t>{0, 1, 255, 7}));
  EXPECT_EQ(ClassesOf(raster)[0], CellClass::kUnknown);
  EXPECT_EQ(ClassesOf(raster)[1], CellClass::kFree);
  EXPECT_EQ(ClassesOf(raster)[2], CellClass::kOccupied);
}

TEST(ApplyEdits, AnEmptyOverlayChangesNothing) {
  std::mt19937 random(3);
  for (const MapRaster& form : EveryForm(random)) {
    MapRaster raster = form;
    EXPECT_OK(Apply(Overlay(), {0, 0}, raster));
    EXPECT_EQ(raster, form);
  }
}

TEST(ApplyEdits, LatticesAreThoseOfTheTiles) {
  grid::RasterHeader own{.raster = {{0.05, {-1.35, 2.1, 0}, 30, 20}, grid::OccupancyCells{}}, .lattice_min = {-27, 42}};
  EXPECT_EQ(LatticeOf(own), (Lattice{0.05, {}}));
  EXPECT_EQ(BoxOf(own), (CellBox{-27, 42, 30, 20}));
  grid::RasterHeader imported{.raster = {{0.03, {1, 2, 0.5}, 30, 20}, GreyCells{}}, .lattice_min = {}};
  EXPECT_EQ(LatticeOf(imported), (Lattice{0.03, {1, 2, 0.5}}));
  EXPECT_EQ(BoxOf(imported), (CellBox{0, 0, 30, 20}));
}

}  // namespace
}  // namespace enfilade::edit

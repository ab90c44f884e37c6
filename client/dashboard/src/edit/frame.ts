// SPDX-License-Identifier: Apache-2.0
import type { MapLattice } from '../gen/enfilade/v1/map_edit_pb';
import type { Point } from '../scene/camera';
import { affineOf, apply, inverted, type Affine } from '../scene/affine';
import { UNITS, type Box, type Units } from './lattice';

// Between metres of a map's frame and cells of its lattice.
export class LatticeFrame {
  readonly resolution: number;
  private readonly toMap: Affine; // from cells
  private readonly toCells: Affine;

  constructor(lattice: MapLattice | undefined) {
    this.resolution = lattice?.resolutionM || 0.05;
    const { x = 0, y = 0, yaw = 0 } = lattice?.poseMapLattice ?? {};
    this.toMap = affineOf({ x, y, yaw }, this.resolution);
    this.toCells = inverted(this.toMap);
  }

  // Cells as numbers with a fraction: the middle of cell (0, 0) is (0.5, 0.5).
  metres = (cells: Point): Point => apply(this.toMap, cells);
  cells = (metres: Point): Point => apply(this.toCells, metres);

  units(metres: Point): Units {
    const { x, y } = this.cells(metres);
    return { x: Math.round(x * UNITS), y: Math.round(y * UNITS) };
  }

  // "2.40 × 0.35 m at 12.40, -3.10", of a box's size and middle.
  place({ firstColumn, firstRow, width, height }: Box): string {
    const { x, y } = this.metres({ x: firstColumn + width / 2, y: firstRow + height / 2 });
    return `${(width * this.resolution).toFixed(2)} × ${(height * this.resolution).toFixed(2)} m at ${x.toFixed(2)}, ${y.toFixed(2)}`;
  }
}

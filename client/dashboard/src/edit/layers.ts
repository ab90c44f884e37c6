// SPDX-License-Identifier: Apache-2.0
import type { Value } from './cells';
import { boxOf, tilesOf, type Spans } from './raster/spans';
import type { Box } from './lattice';

// The cells of an edit between those of others.
export class Layer {
  readonly box: Box | undefined;
  readonly tiles: Set<number>;

  // `id`: of the edit. `order`: later ones lie over earlier ones.
  constructor(readonly id: string, readonly spans: Spans, readonly value: Value, readonly order: number, readonly active: boolean) {
    this.box = boxOf(spans);
    this.tiles = tilesOf(spans);
  }
}

// Puts a layer where it belongs; returns how many lie over it.
export function insert(layers: Layer[], layer: Layer): number {
  let at = layers.length;
  while (at > 0 && layers[at - 1]!.order > layer.order) --at;
  layers.splice(at, 0, layer);
  return layers.length - 1 - at;
}

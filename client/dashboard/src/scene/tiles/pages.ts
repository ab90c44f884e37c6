// SPDX-License-Identifier: Apache-2.0

export interface Slot {
  page: WebGLTexture;
  layer: number;
  // The frame that drew it last.
  used: number;
}

export const TILE = 256;
const LAYERS = 192;
// 3 * 192 tiles of 64 KiB: 36 MiB, and three draw calls.
const PAGES = 3;

export function createPage(gl: WebGL2RenderingContext, size: number, layers: number): WebGLTexture {
  const page = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, page);
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.R8, size, size, layers);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  return page;
}

export function fillLayer(gl: WebGL2RenderingContext, page: WebGLTexture, layer: number, width: number, height: number, cells: Uint8Array) {
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, page);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, width, height, 1, gl.RED, gl.UNSIGNED_BYTE, cells);
}

// Tiles by their SHA-256 in texture arrays; when all layers are taken, the one that was not drawn for longest goes. A texture
// array cannot grow: there are several.
export class TilePages {
  private readonly slots = new Map<string, Slot>();
  private readonly free: Slot[] = [];
  private pages = 0;

  constructor(private readonly gl: WebGL2RenderingContext) {}

  get count() {
    return this.slots.size;
  }

  find(key: string, frame: number): Slot | undefined {
    const slot = this.slots.get(key);
    if (slot) slot.used = frame;
    return slot;
  }

  has(key: string) {
    return this.slots.has(key);
  }

  // Returns false if all that is there is on screen.
  put(key: string, cells: Uint8Array, frame: number): boolean {
    const slot = this.free.pop() ?? this.grown() ?? this.evicted(frame);
    if (!slot) return false;
    slot.used = frame;
    this.slots.set(key, slot);
    fillLayer(this.gl, slot.page, slot.layer, TILE, TILE, cells);
    return true;
  }

  private grown(): Slot | undefined {
    if (this.pages >= PAGES) return undefined;
    ++this.pages;
    const page = createPage(this.gl, TILE, LAYERS);
    for (let layer = LAYERS - 1; layer >= 0; --layer) this.free.push({ page, layer, used: 0 });
    return this.free.pop();
  }

  private evicted(frame: number): Slot | undefined {
    let oldest: string | undefined;
    let used = frame;
    for (const [key, slot] of this.slots) {
      if (slot.used >= used) continue;
      used = slot.used;
      oldest = key;
    }
    if (oldest === undefined) return undefined;
    const slot = this.slots.get(oldest);
    this.slots.delete(oldest);
    return slot;
  }
}

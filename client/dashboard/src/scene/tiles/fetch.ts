// SPDX-License-Identifier: Apache-2.0
// The two answers of the gateway that are no JSON: the overview, and tiles in batches (docs/web.md, "Rasters").
import { hex } from '../../api/digests';
import { errorOfResponse } from '../../api/errors';
import { siteName } from '../../api/names';
import { THUMBNAIL_FREE, THUMBNAIL_OCCUPIED } from '../palette';
import { middleOf, type Thumbnail } from './manifest';

interface OverviewEntry {
  revision: string;
  resolutionM: number;
  x: number;
  y: number;
  yaw: number;
  width: number;
  height: number;
  offset: number;
}

const shown = Uint8Array.of(0, THUMBNAIL_FREE, THUMBNAIL_OCCUPIED);

// A line of JSON with the index, then the cells of all thumbnails.
export function parseOverview(bytes: Uint8Array): Thumbnail[] {
  const end = bytes.indexOf(10);
  const { thumbnails } = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end))) as { thumbnails: OverviewEntry[] };
  return thumbnails.map(({ revision, resolutionM, x, y, yaw, width, height, offset }) => {
    const begin = end + 1 + offset;
    const cells = bytes.slice(begin, begin + width * height).map((value) => shown[value] ?? 0);
    return { revision, resolution: resolutionM, pose: { x, y, yaw }, width, height, cells, layer: -1, middle: middleOf(cells, width) };
  });
}

// Frames of 32 bytes SHA-256, 4 bytes length (little-endian) and the cells, as far as they are complete; and what is left.
export function parseTiles(bytes: Uint8Array): { tiles: [key: string, cells: Uint8Array][]; rest: Uint8Array } {
  const tiles: [string, Uint8Array][] = [];
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = 0;
  while (at + 36 <= bytes.length) {
    const length = view.getUint32(at + 32, true);
    if (at + 36 + length > bytes.length) break;
    tiles.push([hex(bytes.subarray(at, at + 32)), bytes.subarray(at + 36, at + 36 + length)]);
    at += 36 + length;
  }
  return { tiles, rest: bytes.subarray(at) };
}

function joined(a: Uint8Array, b: Uint8Array): Uint8Array {
  if (a.length === 0) return b;
  const both = new Uint8Array(a.length + b.length);
  both.set(a);
  both.set(b, a.length);
  return both;
}

export async function fetchOverview(site: string): Promise<Thumbnail[]> {
  const response = await fetch(`/v1/${siteName(site)}/overview`);
  if (!response.ok) throw await errorOfResponse(response);
  return parseOverview(new Uint8Array(await response.arrayBuffer()));
}

export async function fetchTiles(site: string, keys: string[], take: (key: string, cells: Uint8Array) => void) {
  const response = await fetch(`/v1/${siteName(site)}/tiles:batch`, {
    method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ sha256: keys }),
  });
  if (!response.ok || !response.body) throw await errorOfResponse(response);
  const reader = response.body.getReader();
  let rest: Uint8Array = new Uint8Array();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const parsed = parseTiles(joined(rest, value));
    rest = parsed.rest;
    for (const [key, cells] of parsed.tiles) take(key, cells);
  }
}

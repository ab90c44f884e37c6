// SPDX-License-Identifier: Apache-2.0
import { useMemo, useSyncExternalStore } from 'react';
import type { Drawn, Mark, Stats } from './model';
import { worldToScreen, type Camera, type Point, type Size } from './camera';
import { Scene } from './Scene';
import type { Thumbnail } from './tiles/manifest';

declare global {
  interface Window {
    // What was drawn last, for tests.
    __scene?: {
      drawn(): Drawn[];
      marks(): Mark[];
      camera(): Camera;
      stats(): Stats;
      settled(): boolean;
      project(world: Point): Point;
      setCamera(camera: Camera): void;
    };
  }
}

let scene: Scene | undefined;
let tried = false;

// One canvas for all pages: a browser keeps few WebGL contexts. Undefined if it has none.
export function sharedScene(): Scene | undefined {
  if (tried) return scene;
  tried = true;
  const canvas = document.createElement('canvas');
  canvas.className = 'scene-canvas';
  canvas.tabIndex = 0;
  canvas.setAttribute('role', 'application');
  canvas.setAttribute('aria-label', 'Map. Arrow keys move, plus and minus zoom, 0 shows all. All objects are also in the list “In view”.');
  const gl = canvas.getContext('webgl2', { alpha: false, antialias: false, depth: true, powerPreference: 'high-performance' });
  if (!gl) return undefined; // pages show their lists, and say why there is no map
  const made = new Scene(canvas, gl);
  scene = made;
  window.__scene = {
    drawn: () => made.drawn,
    marks: () => made.marks,
    camera: () => made.camera,
    stats: () => made.stats(),
    settled: () => made.settled(),
    project: (world) => worldToScreen(made.camera, made.size, world),
    setCamera: (camera) => made.setCamera(camera),
  };
  return scene;
}

export const sceneCanvas = () => sharedScene()?.canvas;

const never = () => () => {};

// Pixels per metre.
export function useScale(): number {
  const shared = sharedScene();
  return useSyncExternalStore(shared?.scaleChanged.subscribe ?? never, () => shared?.camera.scale ?? 1);
}

// What the canvas shows of the world, for what lies over it; undefined: there is no canvas.
export function useShown(): { camera: Camera; size: Size } | undefined {
  const shared = sharedScene();
  return useSyncExternalStore(shared?.viewChanged.subscribe ?? never, () => shared?.shown);
}

// The names of what the canvas shows; undefined: there is no canvas.
export function useInView(): ReadonlySet<string> | undefined {
  const shared = sharedScene();
  return useSyncExternalStore(shared?.seenChanged.subscribe ?? never, () => shared?.inView());
}

// The pictures of the maps, by name: another table whenever one has come.
export function useThumbnails(): ReadonlyMap<string, Thumbnail> {
  const shared = sharedScene();
  const pictures = useSyncExternalStore(shared?.picturesChanged.subscribe ?? never, () => shared?.pictures ?? 0);
  return useMemo(() => (pictures > 0 ? new Map(shared?.thumbnails) : new Map<string, Thumbnail>()), [shared, pictures]);
}

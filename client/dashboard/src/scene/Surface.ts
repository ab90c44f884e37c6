// SPDX-License-Identifier: Apache-2.0
import type { LiveSite } from '../live/site';
import type { Size } from './camera';
import type { Sources } from './drawing';
import { GlyphLayer } from './gl/glyphLayer';
import { RasterLayer } from './gl/rasterLayer';
import type { Frame } from './model';
import { defaultClasses, readPalette, type Palette } from './palette';
import { Outlines } from './outlines';
import { RasterLoader } from './tiles/loader';
import { THUMBNAIL } from './tiles/manifest';
import { createPage, fillLayer, TilePages } from './tiles/pages';

// All that lives in the graphics card: rebuilt when the context comes back after it was lost.
export class Surface {
  loader: RasterLoader | undefined;
  tiles!: TilePages;
  palette!: Palette;
  private readonly outlines = new Outlines();
  private rasters!: RasterLayer;
  private glyphs!: GlyphLayer;
  private thumbnailPage: WebGLTexture | undefined;
  private thumbnailLayers = 0;
  private thumbnailsStale = false;
  // Counts how often pictures of maps have come.
  pictures = 0;
  private frame = 0;
  // The graphics card has dropped all that it had; the browser says when it gives it back.
  lost = false;
  private graphSeen = -1;
  private rasterSeen = -1;

  constructor(private readonly canvas: HTMLCanvasElement, private readonly gl: WebGL2RenderingContext, private readonly changed: () => void) {
    this.build();
    canvas.addEventListener('webglcontextlost', (event) => {
      event.preventDefault();
      this.lost = true;
      this.changed();
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.lost = false;
      this.build();
      this.changed();
    });
  }

  show(site: LiveSite) {
    this.loader?.stop();
    this.loader = new RasterLoader(site.id, {
      thumbnails: () => {
        this.thumbnailsStale = true;
        this.changed();
      },
      manifest: this.changed,
      tile: (key, cells) => {
        const put = !this.lost && this.tiles.put(key, cells, this.frame);
        this.changed();
        return put;
      },
    });
    this.graphSeen = this.rasterSeen = -1;
    this.outlines.clear();
  }

  // Whether there is something to fit the camera to: all pictures, or nothing that would have one.
  hasPictures(site: LiveSite): boolean {
    return site.complete && (site.rasters.size === 0 || (this.loader?.thumbnails.size ?? 0) > 0);
  }

  readTheme() {
    this.palette = readPalette(defaultClasses);
    this.rasters.setPalette(this.palette);
    this.changed();
  }

  resize({ width, height }: Size) {
    this.canvas.width = Math.round(width * devicePixelRatio);
    this.canvas.height = Math.round(height * devicePixelRatio);
  }

  begin(site: LiveSite) {
    ++this.frame;
    if (this.graphSeen !== site.graphRevision || this.rasterSeen !== site.rasterRevision || this.frame % 64 === 0) {
      this.graphSeen = site.graphRevision;
      this.rasterSeen = site.rasterRevision;
      void this.loader?.wantThumbnails([...site.rasters].map(([map, { revision }]) => [map, revision]));
    }
    if (this.thumbnailsStale) this.fillThumbnails();
    this.rasters.clear();
    this.glyphs.list.clear();
    return { rasters: this.rasters, glyphs: this.glyphs.list, palette: this.palette };
  }

  sources(): Sources {
    return { loader: this.loader!, tiles: this.tiles, thumbnailPage: this.thumbnailPage, outlines: this.outlines, frame: this.frame, deviceRatio: devicePixelRatio };
  }

  // Returns the number of draw calls.
  end({ size, view }: Frame, missing: string[]): number {
    this.loader?.wantTiles(missing);
    if (this.lost) return 0;
    const { gl } = this;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...this.palette.background);
    gl.clearDepth(1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const swipe = view.compare === 'swipe' ? (view.swipe ?? 0.5) * this.canvas.width : -1;
    const blend = view.compare === 'difference' ? (this.palette.dark ? 'lighten' : 'darken') : undefined;
    return this.rasters.draw(swipe, blend) + this.glyphs.draw(size.width, size.height);
  }

  private build() {
    this.tiles = new TilePages(this.gl);
    this.rasters = new RasterLayer(this.gl);
    this.glyphs = new GlyphLayer(this.gl);
    this.thumbnailPage = undefined;
    this.thumbnailLayers = 0;
    this.thumbnailsStale = true;
    this.readTheme();
  }

  private fillThumbnails() {
    this.thumbnailsStale = false;
    ++this.pictures;
    const { gl, loader } = this;
    if (!loader || loader.thumbnails.size === 0) return;
    const most = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS) as number;
    if (loader.thumbnails.size > this.thumbnailLayers) {
      if (this.thumbnailPage) gl.deleteTexture(this.thumbnailPage);
      this.thumbnailLayers = Math.min(most, Math.max(64, 2 ** Math.ceil(Math.log2(loader.thumbnails.size))));
      this.thumbnailPage = createPage(gl, THUMBNAIL, this.thumbnailLayers);
    }
    let layer = 0;
    for (const thumbnail of loader.thumbnails.values()) {
      thumbnail.layer = layer < this.thumbnailLayers ? layer++ : -1;
      if (thumbnail.layer >= 0) fillLayer(gl, this.thumbnailPage!, thumbnail.layer, thumbnail.width, thumbnail.height, thumbnail.cells);
    }
  }
}

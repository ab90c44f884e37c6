// SPDX-License-Identifier: Apache-2.0
import { rasters } from '../../api/clients';
import { fetchOverview, fetchTiles } from './fetch';
import { manifestOf, type Manifest, type Thumbnail } from './manifest';

const BATCH = 48;
// A browser has six connections to a host.
const BATCHES_AT_ONCE = 2;
const MANIFESTS_AT_ONCE = 4;
const MANIFESTS_KEPT = 512;
const THUMBNAILS_AGAIN_MS = 3000;

export interface LoaderEvents {
  thumbnails(): void;
  manifest(): void;
  // Returns false if there is no room for it now.
  tile(key: string, cells: Uint8Array): boolean;
}

// sites/s/maps/m of sites/s/maps/m/revisions/3.
const mapOf = (revision: string) => revision.slice(0, revision.lastIndexOf('/revisions/'));

// Fetches the rasters of a site as they are wanted. What is wanted again while it is under way is fetched once; what failed
// may be asked for again after a while.
export class RasterLoader {
  readonly thumbnails = new Map<string, Thumbnail>();
  // Counts what has changed them.
  overviews = 0;
  tileRequests = 0;
  // Whether the overview has been asked for once; it may have failed.
  hasOverview = false;
  private readonly manifests = new Map<string, Manifest>();
  private readonly pending = new Set<string>();
  private readonly failed = new Map<string, number>();
  private loading = false;
  private thumbnailsAt = -Infinity;
  private batches = 0;
  private manifestCalls = 0;
  private stopped = false;

  constructor(private readonly site: string, private readonly events: LoaderEvents) {}

  // Whether nothing is being fetched.
  get idle() {
    return !this.loading && this.pending.size === 0;
  }

  stop() {
    this.stopped = true;
  }

  // Loads the overview if a map's newest revision is not the one that it shows.
  async wantThumbnails(revisions: Iterable<[map: string, revision: string]>) {
    if (this.loading || Date.now() < this.thumbnailsAt + THUMBNAILS_AGAIN_MS) return;
    let stale = false;
    for (const [map, revision] of revisions) stale ||= this.thumbnails.get(map)?.revision !== revision;
    if (!stale) return;
    this.loading = true;
    try {
      for (const thumbnail of await fetchOverview(this.site)) this.thumbnails.set(mapOf(thumbnail.revision), thumbnail);
      ++this.overviews;
      if (!this.stopped) this.events.thumbnails();
    } catch {
      // The banner of the stream says what is wrong; tried again later.
    } finally {
      this.loading = false;
      this.hasOverview = true;
      this.thumbnailsAt = Date.now();
    }
  }

  manifest(revision: string): Manifest | undefined {
    const found = this.manifests.get(revision);
    if (!found && this.manifestCalls < MANIFESTS_AT_ONCE && this.begin(revision)) void this.loadManifest(revision);
    return found;
  }

  // The first are fetched first.
  wantTiles(keys: string[]) {
    if (this.batches >= BATCHES_AT_ONCE) return;
    const wanted: string[] = [];
    for (const key of keys) {
      if (wanted.length >= BATCH) break;
      if (this.begin(key)) wanted.push(key);
    }
    if (wanted.length > 0) void this.loadTiles(wanted);
  }

  private begin(key: string): boolean {
    if (this.pending.has(key) || (this.failed.get(key) ?? 0) > Date.now()) return false;
    this.pending.add(key);
    return true;
  }

  private end(key: string, failed: boolean) {
    this.pending.delete(key);
    if (failed) this.failed.set(key, Date.now() + 5000);
    else this.failed.delete(key);
  }

  private async loadManifest(revision: string) {
    ++this.manifestCalls;
    let failed = false;
    try {
      const manifest = manifestOf(await rasters.getRasterManifest({ name: revision }));
      if (this.manifests.size >= MANIFESTS_KEPT) this.manifests.delete(this.manifests.keys().next().value!);
      this.manifests.set(revision, manifest);
    } catch {
      failed = true;
    }
    --this.manifestCalls;
    this.end(revision, failed);
    if (!this.stopped) this.events.manifest();
  }

  private async loadTiles(keys: string[]) {
    ++this.batches;
    ++this.tileRequests;
    const left = new Set(keys);
    try {
      await fetchTiles(this.site, keys, (key, cells) => {
        if (this.stopped) return;
        left.delete(key);
        this.end(key, !this.events.tile(key, cells));
      });
    } catch {
      // As above.
    } finally {
      --this.batches;
      for (const key of left) this.end(key, true);
      if (!this.stopped) this.events.manifest();
    }
  }
}

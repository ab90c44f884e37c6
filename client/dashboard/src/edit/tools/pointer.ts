// SPDX-License-Identifier: Apache-2.0
import type { Client } from '@connectrpc/connect';
import type { MapEditService } from '../../gen/enfilade/v1/map_edit_service_pb';
import type { Units } from '../lattice';

const AT_MOST_EACH_MS = 250;
// The server forgets it after 15 s.
const AGAIN_MS = 8000;

// Tells the others who work on the draft where this pointer is.
export class PointerReport {
  private place: Units | undefined;
  private tool = '';
  private timer: ReturnType<typeof setTimeout> | undefined;
  private last = 0;
  private isChanged = true;
  private readonly beat = setInterval(() => this.soon(), AGAIN_MS);

  constructor(private readonly draft: string, private readonly clientId: string, private readonly author: () => string,
              private readonly service: Pick<Client<typeof MapEditService>, 'reportMapDraftPresence'>) {
    this.soon();
  }

  at(place: Units | undefined, tool: string) {
    if (place?.x === this.place?.x && place?.y === this.place?.y && tool === this.tool) return;
    this.place = place;
    this.tool = tool;
    this.isChanged = true;
    this.soon();
  }

  close() {
    clearInterval(this.beat);
    clearTimeout(this.timer);
  }

  private soon() {
    if (document.hidden || (!this.isChanged && Date.now() - this.last < AGAIN_MS)) return;
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      void this.send();
    }, Math.max(0, this.last + AT_MOST_EACH_MS - Date.now()));
  }

  // One that is lost is made up for by the next.
  private async send() {
    this.last = Date.now();
    this.isChanged = false;
    const { clientId, place, tool } = this;
    await this.service.reportMapDraftPresence({ name: this.draft, presence: { clientId, author: this.author(), tool, ...(place && { pointer: place }) } }, { timeoutMs: 5000 }).catch(() => undefined);
  }
}

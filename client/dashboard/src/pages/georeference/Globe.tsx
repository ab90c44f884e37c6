// SPDX-License-Identifier: Apache-2.0
import type { LatLon } from '../../geo/wgs84';

const RADIUS = 70;
const RAD = Math.PI / 180;

// Seen from above a point a little south of the place, so that the equator is in view: orthographic.
function project({ latitude, longitude }: LatLon, from: LatLon): { x: number; y: number; front: boolean } {
  const [p, l] = [latitude * RAD, (longitude - from.longitude) * RAD];
  const p0 = from.latitude * RAD;
  return {
    x: RADIUS * Math.cos(p) * Math.sin(l),
    y: -RADIUS * (Math.cos(p0) * Math.sin(p) - Math.sin(p0) * Math.cos(p) * Math.cos(l)),
    front: Math.sin(p0) * Math.sin(p) + Math.cos(p0) * Math.cos(p) * Math.cos(l) > 0,
  };
}

// The visible parts of a line.
function pathOf(line: LatLon[], from: LatLon): string {
  let path = '';
  let drawing = false;
  for (const place of line) {
    const { x, y, front } = project(place, from);
    if (front) path += `${drawing ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`;
    drawing = front;
  }
  return path;
}

const range = (from: number, to: number, step: number) => Array.from({ length: (to - from) / step + 1 }, (_, i) => from + i * step);

const parallel = (latitude: number) => range(-180, 180, 4).map((longitude) => ({ latitude, longitude }));
const meridian = (longitude: number) => range(-90, 90, 3).map((latitude) => ({ latitude, longitude }));

// Where a place lies on the globe: a graticule of 30 degrees; the equator and the meridian of Greenwich are stronger.
export function Globe({ place }: { place: LatLon }) {
  const from = { latitude: place.latitude * 0.6, longitude: place.longitude };
  const at = project(place, from);
  const lines = [...range(-60, 60, 30).filter((value) => value !== 0).map(parallel), ...range(-150, 180, 30).filter((value) => value !== 0).map(meridian)];
  const name = `${Math.abs(place.latitude).toFixed(1)}° ${place.latitude < 0 ? 'south' : 'north'}, ${Math.abs(place.longitude).toFixed(1)}° ${place.longitude < 0 ? 'west' : 'east'}`;
  return (
    <figure className="globe">
      <svg viewBox="-72 -72 144 144" role="img" aria-label={`The site on the globe: ${name}`}>
        <circle className="globe-sea" r={RADIUS} />
        {lines.map((line, i) => (
          <path key={i} className="globe-line" d={pathOf(line, from)} />
        ))}
        <path className="globe-main" d={pathOf(parallel(0), from)} />
        <path className="globe-main" d={pathOf(meridian(0), from)} />
        <circle className="globe-place" cx={at.x} cy={at.y} r="4" />
      </svg>
      <figcaption className="sub">{name}</figcaption>
    </figure>
  );
}

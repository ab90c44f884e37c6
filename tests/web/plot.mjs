// SPDX-License-Identifier: Apache-2.0
// The figures of a soak over time as SVG: one panel each, from zero.
const panels = [
  ['heap_mib', 'JavaScript heap of the tab, MiB'], ['tiles', 'Tiles in the graphics card'],
  ['gateway_mib', 'Memory of the gateway, MiB'], ['server_mib', 'Memory of the server, MiB'],
];
const [width, height, left, top] = [640, 130, 60, 30];

function panel(rows, name, title, index) {
  const most = Math.max(1, ...rows.map((row) => row[name])) * 1.1;
  const end = rows.at(-1).minute;
  const x = (minute) => left + (minute / end) * (width - left - 20);
  const y = (value) => top + (height - top - 20) * (1 - value / most);
  const points = rows.map((row) => `${x(row.minute).toFixed(1)},${y(row[name]).toFixed(1)}`).join(' ');
  const last = rows.at(-1)[name];
  return `<g transform="translate(0 ${index * height})">
<text x="${left}" y="18" font-weight="bold">${title}: ${last.toFixed(last < 100 ? 1 : 0)}</text>
<path d="M${left} ${top}V${y(0)}H${width - 20}" fill="none" stroke="#888"/>
<text x="${left - 6}" y="${y(0)}" text-anchor="end">0</text><text x="${left - 6}" y="${top + 8}" text-anchor="end">${most.toFixed(0)}</text>
<text x="${width - 20}" y="${y(0) + 14}" text-anchor="end">${end.toFixed(0)} min</text>
<polyline points="${points}" fill="none" stroke="#2456c8" stroke-width="1.5"/>
</g>`;
}

export const plot = (rows) => `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${panels.length * height}" font-family="sans-serif" font-size="12">
<rect width="100%" height="100%" fill="#fff"/>
${panels.map(([name, title], index) => panel(rows, name, title, index)).join('\n')}
</svg>
`;

// SPDX-License-Identifier: Apache-2.0
// What the map shows, against what the API says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { drawnMaps, open, picture, settled } from '../browser.mjs';
import { downloaded, importMap, moveDoor, pgmOf, twoRooms } from '../maps.mjs';
import { look, pixelsOf, placed, seenFrom, toScreen, toWorld } from '../pixels.mjs';
import { Robots } from '../robots.mjs';
import { until } from '../system.mjs';

const size = (page) => page.evaluate(() => { const { width, height } = document.querySelector('.scene-canvas').getBoundingClientRect(); return { width, height }; });
const drawnOf = (page, name) => page.evaluate((wanted) => window.__scene.drawn().find((item) => item.name === wanted), name);
const shift = (a, b) => Math.hypot(a.x - b.x, a.y - b.y);

const poseOf = async (system, site, map) => {
  const { graph } = await system.call(`sites/${site}/graph`);
  return graph.maps.find((one) => one.map === map).poseWorldMap?.pose;
};

// A cell in whose surroundings (12 cells) the walls are such that a shift shows in any direction; none of the map's border.
function cornerOf({ columns, rows, wall }) {
  const cells = [];
  for (let y = 20; y < rows - 20; ++y) for (let x = 20; x < columns - 20; ++x) if (wall(x, y)) cells.push([x, y]);
  const shifts = [[2, 0], [0, 2], [2, 2], [2, -2]];
  const shows = ([x, y]) => Math.min(...shifts.map(([dx, dy]) => {
    let differ = 0;
    for (let v = -12; v <= 12; v += 2) for (let u = -12; u <= 12; u += 2) if (wall(x + u, y + v) !== wall(x + u + dx, y + v + dy)) ++differ;
    return differ;
  }));
  const step = Math.ceil(cells.length / 400);
  return cells.filter((_, i) => i % step === 0).map((cell) => [shows(cell), cell]).reduce((a, b) => (b[0] > a[0] ? b : a))[1];
}

const REACH = 4;

// How far, in pixels, the walls on the screen are from where `expects` wants them; and the share of pixels that still differ.
function displacement(pixels, isWall, expects, centre, half) {
  const around = (reach, test) => {
    const side = 2 * reach + 1;
    return Array.from({ length: side * side }, (_, i) => test(centre.x - reach + (i % side), centre.y - reach + Math.floor(i / side)));
  };
  const wanted = around(half, expects);
  const seen = around(half + REACH, (x, y) => isWall(pixels.at(x, y)));
  const [side, wide] = [2 * half + 1, 2 * (half + REACH) + 1];
  let best = { share: Infinity };
  for (let dy = -REACH; dy <= REACH; ++dy) {
    for (let dx = -REACH; dx <= REACH; ++dx) {
      const differ = wanted.filter((wall, i) => wall !== seen[(Math.floor(i / side) + REACH + dy) * wide + (i % side) + REACH + dx]).length;
      if (differ / wanted.length < best.share) best = { dx, dy, share: differ / wanted.length };
    }
  }
  return { ...best, walls: wanted.filter(Boolean).length };
}

export function addScene({ system, browser, at, campus }) {
  test('campus_figure1: all maps are drawn, and link points where the graph places them', async () => {
    await campus();
    const { graph } = await system.call('sites/demo/graph');
    const placed = graph.maps.filter(({ poseWorldMap }) => poseWorldMap);
    assert.ok(placed.length >= 4, `${placed.length} maps are placed`);
    const { page, close } = await open(browser(), at('demo/campus'));
    await until('all maps are drawn', async () => (await drawnMaps(page)).length >= placed.length);
    await settled(page);
    for (const name of ['light', 'dark']) {
      await page.emulateMedia({ colorScheme: name });
      await picture(page, `campus-${name}`);
    }
    const names = new Set((await drawnMaps(page)).map(({ name }) => name));
    for (const { map } of placed) assert.ok(names.has(map), `${map} is drawn`);
    const away = await page.evaluate((points) => {
      const drawn = new Map(window.__scene.drawn().map((object) => [object.name, object]));
      return points.map(({ linkPoint, poseWorldPlace: { pose } }) => {
        const [at, wanted] = [drawn.get(linkPoint), window.__scene.project(pose)];
        return at ? Math.hypot(at.x - wanted.x, at.y - wanted.y) : Infinity;
      });
    }, graph.linkPoints.filter(({ poseWorldPlace }) => poseWorldPlace));
    assert.ok(away.length >= 5 && Math.max(...away) < 1, `pixels between link points and their places: ${away}`);
    const list = page.getByRole('listbox', { name: 'Objects in view' });
    await until('the list has what is drawn', async () => await list.getByRole('option').count() >= names.size);
    await list.focus();
    await page.keyboard.press('ArrowDown');
    await page.keyboard.press('Enter');
    await until('the selection is in the address', () => page.url().includes('sel='));
    assert.equal(await list.getByRole('option', { selected: true }).count(), 1);
    await close();
  });

  test('campus_figure1: a wall corner of each map is drawn where GetGraph and the map\'s file place it, within a pixel', async () => {
    await campus();
    const { graph } = await system.call('sites/demo/graph');
    for (const { map, poseWorldMap } of graph.maps) {
      const raster = await downloaded(system, map);
      const [column, row] = cornerOf(raster);
      const inMap = placed(raster.origin, { x: (column + 0.5) * raster.resolution, y: (row + 0.5) * raster.resolution });
      const corner = placed(poseWorldMap.pose, inMap);
      // The selected map lies above the others, and its walls are red.
      const { page, close } = await open(browser(), `${at('demo/campus')}?sel=${encodeURIComponent(map.split('/').slice(2).join('/'))}`);
      await settled(page);
      const camera = { ...corner, scale: 5 / raster.resolution };
      await look(page, camera);
      const canvas = await size(page);
      const pixels = await pixelsOf(page);
      await picture(page, `corner-${map.split('/').pop()}`);
      const expects = (x, y) => {
        const cell = seenFrom(raster.origin, seenFrom(poseWorldMap.pose, toWorld(camera, canvas, { x: x + 0.5, y: y + 0.5 })));
        return raster.wall(Math.floor(cell.x / raster.resolution), Math.floor(cell.y / raster.resolution));
      };
      const centre = { x: Math.round(canvas.width / 2), y: Math.round(canvas.height / 2) };
      const found = displacement(pixels, ([red, green]) => red - green > 50, expects, centre, 60);
      assert.ok(found.walls > 100, `${map}: ${found.walls} pixels of walls are expected`);
      assert.ok(Math.abs(found.dx) <= 1 && Math.abs(found.dy) <= 1 && found.share < 0.03, `${map}: ${JSON.stringify(found)}`);
      await close();
    }
  });

  test('optimise_moves: a link point that is moved moves maps on the screen, without a request for tiles', async (t) => {
    await twoRooms(system, 'moves');
    const b = 'sites/moves/maps/b';
    const { page, close } = await open(browser(), at('moves/campus'));
    await until('both are drawn', async () => (await drawnMaps(page)).length === 2);
    await settled(page);
    const before = await drawnOf(page, b);
    const requests = [];
    page.on('request', (request) => requests.push(new URL(request.url()).pathname));
    const begin = performance.now();
    await moveDoor(system, 'moves', { x: 10, y: 8, yaw: 0.3 });
    await until('the map moves', async () => shift(await drawnOf(page, b), before) > 20);
    t.diagnostic(`the map moved after ${Math.round(performance.now() - begin)} ms`);
    const pose = await poseOf(system, 'moves', b);
    await settled(page);
    const camera = await page.evaluate(() => window.__scene.camera());
    const wanted = toScreen(camera, await size(page), placed(pose, { x: 5, y: 5 }));
    await until('it has arrived', async () => shift(await drawnOf(page, b), wanted) < 1);
    assert.deepEqual(requests.filter((path) => /tiles|overview|manifest/.test(path)), [], 'no raster is fetched');
    await close();
  });

  test('ellipse: contains the 95 % contour of the pose in the world, within a pixel, for 20 covariances', async (t) => {
    await twoRooms(system, 'ellipses');
    const robots = new Robots(system, 'ellipses');
    t.after(() => robots.close());
    let seed = 7;
    const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    const reports = [];
    for (let i = 0; i < 20; ++i) {
      const [sx, sy, sw, rho, tau] = [0.05 + 0.7 * random(), 0.05 + 0.7 * random(), 0.1 * random(), 1.8 * (random() - 0.5), 0.3 * (random() - 0.5)];
      await robots.begin(`r${i}`, 'b');
      const covariance = [sx * sx, rho * sx * sy, tau * sx * sw, rho * sx * sy, sy * sy, 0, tau * sx * sw, 0, sw * sw];
      const pose = { x: 8 * (i % 5), y: 8 * Math.floor(i / 5), yaw: 6 * random() };
      reports.push(() => robots.report(`r${i}`, 'b', pose, covariance));
    }
    // Again and again: an old pose is grey.
    const report = () => reports.forEach((one) => one());
    report();
    const timer = setInterval(report, 2000);
    t.after(() => clearInterval(timer));
    const poses = [];
    for (let i = 0; i < 20; ++i) {
      const { globalPose } = await until('the pose is known', () => system.call(`sites/ellipses/robots/r${i}/globalPose`).catch(() => undefined));
      poses.push(globalPose.poseWorldRobot);
    }
    const { page, close } = await open(browser(), at('ellipses/campus'));
    await until('all robots are drawn', () => page.evaluate(() => window.__scene?.drawn().filter(({ kind }) => kind === 'robot').length === 20));
    await settled(page);
    await page.evaluate(() => document.querySelector('[aria-label="Show all"]').click());
    await settled(page);
    const canvas = await size(page);
    const camera = await page.evaluate(() => window.__scene.camera());
    const pixels = await pixelsOf(page);
    await picture(page, 'ellipses');
    const isBlue = ([red, , blue]) => blue - red > 40;
    for (const [i, { pose, covariance }] of poses.entries()) {
      const drawn = await drawnOf(page, `sites/ellipses/robots/r${i}`);
      const place = toScreen(camera, canvas, pose);
      assert.ok(shift(drawn, place) < 1, `r${i} is at ${JSON.stringify(place)}`);
      // Points of the contour, from the Cholesky factor of the covariance; 5.991: chi-squared of 95 % and two dimensions.
      const [xx, xy, , , yy] = covariance;
      const [l11, l21] = [Math.sqrt(xx), xy / Math.sqrt(xx)];
      const l22 = Math.sqrt(yy - l21 * l21);
      const contour = Array.from({ length: 360 }, (_, degree) => {
        const [c, s] = [Math.cos((degree * Math.PI) / 180), Math.sin((degree * Math.PI) / 180)];
        return { x: Math.sqrt(5.991464547) * l11 * c * camera.scale, y: Math.sqrt(5.991464547) * (l21 * c + l22 * s) * camera.scale };
      });
      const radii = contour.map(({ x, y }) => Math.hypot(x, y));
      assert.ok(Math.abs(Math.max(...radii) - drawn.halfX) < 1 && Math.abs(Math.min(...radii) - drawn.halfY) < 1, `r${i}: axes ${drawn.halfX}, ${drawn.halfY}`);
      for (const point of contour) {
        const { x, y } = placed({ yaw: -drawn.angle }, point);
        assert.ok((x / (drawn.halfX + 1)) ** 2 + (y / (drawn.halfY + 1)) ** 2 <= 1, `r${i}: the contour is inside`);
      }
      // The line on the screen: within a pixel of the contour, where that is clear of the arrow in its middle.
      const clear = contour.filter((_, k) => k % 5 === 0 && radii[k] > 16);
      const seen = clear.filter((point) => [-1, 0, 1].some((dx) => [-1, 0, 1].some((dy) => isBlue(pixels.at(Math.floor(place.x + point.x) + dx, Math.floor(place.y - point.y) + dy)))));
      assert.ok(seen.length >= 0.95 * clear.length, `r${i}: ${seen.length} of ${clear.length} points of the contour are drawn`);
    }
    await close();
  });

  test('wall_survives_zoom: walls of one cell are drawn at every zoom', async () => {
    const side = 512;
    const [level, from, to] = [256, 40, 470];
    system.enfilade('walls', 'site', 'create', 'walls');
    await importMap(system, 'walls', 'w', pgmOf(side, side, (x, y) => x >= from && x <= to && (y === level || x === y)));
    const { page, close } = await open(browser(), at('walls/campus'));
    await until('the map is drawn', async () => (await drawnMaps(page)).length === 1);
    const isWall = ([red, green, blue]) => red + green + blue < 330;
    const canvas = await size(page);
    for (let scale = 400; scale * side * 0.05 > 12; scale /= 2) {
      const camera = { x: 12.81, y: 12.82, scale }; // where they cross
      await look(page, camera);
      const pixels = await pixelsOf(page);
      await picture(page, `walls-${scale}`);
      for (const [name, height] of [['the level wall', () => level], ['the diagonal wall', (x) => x]]) {
        let [looked, gaps] = [0, 0];
        for (let cell = from + 0.5; cell < to; cell += Math.max(0.5, 20 / scale)) {
          const point = toScreen(camera, canvas, { x: cell * 0.05, y: (height(Math.floor(cell)) + 0.5) * 0.05 });
          const [x, y] = [Math.floor(point.x), Math.floor(point.y)];
          if (x < 1 || y < 1 || x >= canvas.width - 1 || y >= canvas.height - 1) continue;
          ++looked;
          if (![-1, 0, 1].some((dx) => [-1, 0, 1].some((dy) => isWall(pixels.at(x + dx, y + dy))))) ++gaps;
        }
        assert.ok(looked > 5, `${name} is in view`);
        assert.equal(gaps, 0, `${name} at ${scale} pixels per metre: ${gaps} gaps at ${looked} places`);
      }
    }
    await close();
  });
}

'use strict';
// Opens the pages of a folder in a browser, at desktop and at phone width, and does what people do there.
//   node check.js BROWSER FOLDER
// The folder has fit.html, detect.html, empty.html and bench.html; the pictures of the pages are written beside them.

const assert = require('node:assert/strict');
const path = require('node:path');
const { pathToFileURL } = require('node:url');
const puppeteer = require('puppeteer-core');

const [browserPath, folder] = process.argv.slice(2);
/** Milliseconds that a step may take on the busiest machine. */
const PATIENCE = 600000;
const SIZES = [
  { name: 'desktop', width: 1280, height: 900 },
  { name: 'phone', width: 390, height: 844, isMobile: true, hasTouch: true, deviceScaleFactor: 2 },
];

/** What every page must be. */
async function sound(page) {
  const layout = await page.evaluate(() => ({
    overflow: document.scrollingElement.scrollWidth - document.documentElement.clientWidth,
    small: [...document.querySelectorAll('body *')].filter((e) => e.children.length === 0 && e.textContent.trim() && e.checkVisibility()
      && !e.closest('script, style') && parseFloat(getComputedStyle(e).fontSize) < 11.5).map((e) => e.outerHTML),
  }));
  assert.equal(layout.overflow, 0, 'the page is wider than the window');
  assert.deepEqual(layout.small, [], 'text too small');
}

const texts = (page, selector) => page.$$eval(selector, (all) => all.map((e) => e.textContent));

async function fit(page, phone) {
  const names = await texts(page, 'td.name');
  assert.ok(names.length >= 4, names.join());
  assert.ok(names.some((name) => name.includes('<img src=x')), 'a name is text, not markup');
  assert.equal(await page.$('td.name img'), null);
  const verdicts = await texts(page, 'td.verdict');
  assert.ok(verdicts.includes('pass'), verdicts.join());
  assert.ok(verdicts.some((text) => /^failradius [\d.]+ mm (above|below) the limit of [\d.]+ mm$/.test(text)), verdicts.join());
  assert.ok(verdicts.some((text) => /^undecided(radius|in doubt: )/.test(text)), verdicts.join());
  assert.match(await page.$eval('#summary', (e) => e.textContent), /^6 frames, 5 cylinders, 1 failed, radius from /);
  assert.ok((await texts(page, 'td.number')).some((text) => /^\d+\.\d+ ± \d+\.\d+$/.test(text)));
  assert.ok((await texts(page, 'td.warnings')).some((text) => /missing field/.test(text)), 'the failure is told');
  assert.ok((await page.$$('#bars rect')).length >= 5, 'bars');
  assert.equal((await page.$$('#bars line[stroke-dasharray]')).length, 2, 'limits in the histogram');
  // Sorted by radius, both ways; the row without one stays last.
  const radii = () => page.$$eval('tbody tr', (rows) => rows.map((row) => parseFloat(row.querySelector('td.number').textContent) || null));
  if (phone) await page.select('#order', '1');
  else await page.click('th:nth-child(3) button');
  const ascending = (await radii()).filter(Number.isFinite);
  assert.deepEqual(ascending, [...ascending].sort((a, b) => a - b));
  assert.equal((await radii()).at(-1), null, 'no radius comes last');
  if (!phone) {
    await page.click('th:nth-child(3) button');
    assert.deepEqual((await radii()).filter(Number.isFinite), [...ascending].reverse());
    assert.equal((await radii()).at(-1), null, 'no radius comes last');
  }
  await page.select('#quantity', 'length');
  assert.match(await page.$eval('#bars', (e) => e.textContent), /length \(mm\)/);
  await page.select('#quantity', 'radius');
  // Words on a picture lie within it.
  const outside = await page.$$eval('#pictures .label', (all) => all.filter((e) => {
    const [own, around] = [e.getBoundingClientRect(), e.parentElement.getBoundingClientRect()];
    return own.left < around.left || own.right > around.right || own.top < around.top || own.bottom > around.bottom;
  }).map((e) => e.textContent));
  assert.deepEqual(outside, []);
  assert.equal((await page.$$('#pictures .label')).length, 2, 'the states of both ends');
}

/** Colours in the picture of points and cylinder, and that it turns when it is dragged. */
async function turns(page) {
  const colours = () => page.$eval('#view canvas', (canvas) => {
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [200, 150];
    const context = copy.getContext('2d');
    context.drawImage(canvas, 0, 0, 200, 150);
    return { shades: new Set(new Uint32Array(context.getImageData(0, 0, 200, 150).data.buffer)).size, url: copy.toDataURL() };
  });
  const before = await colours();
  assert.ok(before.shades > 50, `${before.shades} colours in 3D`);
  const box = await (await page.$('#view canvas')).boundingBox();
  await page.mouse.move(box.x + 100, box.y + 100);
  await page.mouse.down();
  await page.mouse.move(box.x + 180, box.y + 130, { steps: 5 });
  await page.mouse.up();
  // The page draws when the browser next has the time for it.
  const last = Date.now() + PATIENCE;
  while ((await colours()).url === before.url) assert.ok(Date.now() < last, 'dragging turns the view');
}

async function detect(page) {
  const names = await texts(page, 'td.name');
  assert.ok(names.length >= 2 && names.every((name) => / · \d+$/.test(name)), names.join());
  assert.ok((await texts(page, 'td.number')).some((text) => /^0\.\d\d$|^1\.00$/.test(text)), 'scores');
  // Each row has a picture of its own, with its number.
  const pictures = await page.$$eval('td.picture img', (all) => all.map((e) => e.src));
  assert.equal(new Set(pictures).size, names.length, 'a picture a cylinder');
  assert.deepEqual(await texts(page, 'td.picture .badge'), names.map((name) => name.split(' ').at(-1)));
  assert.equal((await page.$$('#pictures .labelled')).length, 2, 'the cylinder, and the frame');
  await page.click('tbody tr:last-child');
  assert.equal(await page.$eval('#detail h2', (e) => e.textContent), await page.$eval('tbody tr:last-child td.name', (e) => e.textContent));
}

async function empty(page) {
  assert.match(await page.$eval('#summary', (e) => e.textContent), /^1 frame, 0 cylinders, 1 failed/);
  assert.equal((await texts(page, 'td.warnings.error')).length, 1);
}

async function bench(page, phone) {
  // What is wide scrolls by itself, with the first column in view.
  const wide = await page.$$eval('.table', (all) => all.filter((e) => e.scrollWidth > e.clientWidth).map((e) => {
    e.scrollLeft = 10000;
    const first = e.querySelector('td').getBoundingClientRect();
    return { scrolled: e.scrollLeft, left: first.left - e.getBoundingClientRect().left, part: first.width / e.clientWidth };
  }));
  assert.equal(wide.length > 0, phone, 'tables that are wider than the page');
  for (const { scrolled, left, part } of wide) assert.ok(scrolled > 0 && Math.abs(left) < 1 && part < 0.5, `${scrolled} ${left} ${part}`);
  // Letters of plots as they are shown, in pixels.
  const sizes = await page.$$eval('svg text', (all) => all.map((e) => {
    const svg = e.ownerSVGElement;
    return parseFloat(getComputedStyle(e).fontSize) * svg.getBoundingClientRect().width / (svg.viewBox.baseVal.width || svg.width.baseVal.value);
  }));
  assert.ok(sizes.length > 50 && Math.min(...sizes) > 11, `${sizes.length} words, the smallest of ${Math.min(...sizes)} px`);
}

const PAGES = [
  ['fit', fit, true],
  ['detect', detect, true],
  ['empty', empty, false],
  ['bench', bench, false],
];

async function main() {
  const browser = await puppeteer.launch({
    executablePath: browserPath,
    timeout: PATIENCE,
    protocolTimeout: PATIENCE,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--force-color-profile=srgb'],
  });
  let [passed, failed] = [0, 0];
  for (const { name: size, isMobile, ...viewport } of SIZES) {
    for (const [name, check, solid] of PAGES) {
      const page = await browser.newPage();
      page.setDefaultTimeout(PATIENCE);
      const said = [];
      page.on('console', (message) => {
        if (['error', 'warn', 'assert'].includes(message.type())) said.push(`${message.type()}: ${message.text()}`);
      });
      page.on('pageerror', (error) => said.push(String(error)));
      page.on('request', (request) => {
        if (!/^(file|data):/.test(request.url())) said.push(`asks the network for ${request.url()}`);
      });
      try {
        await page.setViewport({ ...viewport, isMobile });
        await page.goto(pathToFileURL(path.resolve(folder, `${name}.html`)).href, { waitUntil: 'load' });
        await sound(page);
        await page.screenshot({ path: path.join(folder, `${name}-${size}.png`), fullPage: true });
        if (solid) await turns(page);
        await check(page, Boolean(isMobile));
        await sound(page);
        assert.deepEqual(said, []);
        passed += 1;
      } catch (error) {
        failed += 1;
        console.log(`${name} at ${size} width: ${error.message}\n${said.join('\n')}`);
      }
      await page.close();
    }
  }
  await browser.close();
  console.log(`report: ${passed} passed, ${failed} failed`);
  process.exitCode = failed ? 1 : 0;
}

main();

'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { test } = require('node:test');
const { Worker } = require('node:worker_threads');
const cylfuse = require('..');
const native = require('../lib/native.js');
const { enumerations } = require('../lib/names.js');
const { frame, pipe, camera, can, collect, memoryStaysFlat } = require('./support.js');

const root = path.join(__dirname, '..', '..', '..');
const coded = (code, message = /./) => (error) => {
  assert.ok(error instanceof cylfuse.CylfuseError, String(error));
  assert.equal(error.code, code);
  assert.match(error.message, message);
  return true;
};

function canFitter() {
  const { depth, mask, edges } = can();
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(camera);
  fitter.pushDepth(depth, mask);
  fitter.pushEdges(edges);
  return fitter;
}

test('structs, functions and statuses are those of the C interface', () => {
  const layout = fs.readFileSync(path.join(root, 'tests/data/abi_layout.txt'), 'utf8');
  let fields = 0;
  for (const block of layout.trim().split(/\n(?=\S)/)) {
    const [[name, size], ...offsets] = block.split('\n').map((line) => line.trim().split(' '));
    const struct = native.structs[name.replace('cylfuse_', '')];
    assert.equal(native.koffi.sizeof(struct), Number(size), name);
    for (const [field, offset] of offsets) {
      assert.equal(native.koffi.offsetof(struct, field), Number(offset), `${name}.${field}`);
      fields += 1;
    }
  }
  assert.ok(fields > 200);
  assert.equal(Object.keys(native.structs).length, layout.match(/^\S/gm).length);
  const symbols = fs.readFileSync(path.join(root, 'tests/data/symbols.txt'), 'utf8').trim().split('\n');
  assert.deepEqual(Object.keys(native.functions).sort(), symbols.sort());
  const statuses = fs.readFileSync(path.join(root, 'tests/data/status_codes.txt'), 'utf8').trim().split('\n');
  assert.deepEqual(enumerations.status, Object.fromEntries(statuses.map((line) => line.split(' ').reverse())
    .map(([name, number]) => [name, Number(number)])));
});

test('points of either type and any stride', async () => {
  const xyz = pipe();
  const packed = await cylfuse.fitPoints(xyz);
  assert.ok(Math.abs(packed.cylinder.radius - 0.5) < 1e-9);
  assert.deepEqual([packed.flags, packed.pointsUsed], [[], 200]);
  const single = (await cylfuse.fitPoints(Float32Array.from(xyz))).cylinder.radius - 0.5;
  assert.ok(single !== 0 && Math.abs(single) < 1e-6, String(single));

  const padded = new Float64Array(1000).fill(NaN);
  for (let k = 0; k < 200; k += 1) padded.set(xyz.subarray(3 * k, 3 * k + 3), 5 * k + 2);
  const fitter = new cylfuse.Fitter();
  // A view into the middle of a buffer; the last point ends with its own numbers.
  fitter.pushPoints({ data: padded.subarray(2), pointStride: 5, weights: new Float64Array(200).fill(1) });
  assert.deepEqual(fitter.fitSync().cylinder, packed.cylinder);
  fitter.close();
});

test('a frame, and all that follows a fit', async () => {
  const fitter = canFitter();
  fitter.reserve(10, 2);
  const result = await fitter.fit();
  assert.ok(Math.abs(result.cylinder.radius - 0.04) < 1e-5, String(result.cylinder.radius));
  assert.equal(result.segmentsUsed, 2);
  assert.ok(Math.abs(Math.sqrt(result.covariance[48]) / result.radiusDeviation - 1) < 1e-9);
  assert.deepEqual(fitter.result(), result);
  assert.deepEqual(fitter.fitSync().cylinder, result.cylinder);
  assert.ok(Math.abs(fitter.evaluate(result.cylinder).energyPoints / result.energyPoints - 1) < 1e-6);

  const residuals = fitter.residuals('points');
  const rms = Math.sqrt(residuals.reduce((sum, value) => sum + value * value, 0) / residuals.length);
  assert.equal(residuals.length, result.pointsUsed);
  assert.ok(Math.abs(rms / result.pointRms - 1) < 1e-9);
  assert.equal(fitter.residuals('edges', result.cylinder).length, 4);
  const diagnosis = fitter.diagnose();
  assert.equal(diagnosis.rank, 5);
  assert.ok(Math.abs(diagnosis.singularValues[0] / diagnosis.singularValues[4] / diagnosis.condition - 1) < 1e-9);

  const extent = fitter.extent();
  assert.ok(Math.abs(extent.length - 0.1) < 0.005, String(extent.length));
  const along = result.cylinder.direction.reduce((sum, d, i) => sum + d * (extent.end[i] - extent.start[i]), 0);
  assert.ok(Math.abs(along - extent.length) < 1e-9);

  const { points, completion } = fitter.complete();
  assert.equal(points.length, 3 * completion.count);
  assert.equal(completion.count, completion.hits);
  assert.ok(cylfuse.distances(result.cylinder, points).every((distance) => Math.abs(distance) < 1e-9));
  const organised = fitter.complete({ layout: 'organised', type: Float32Array, model: result.cylinder, mask: can().mask });
  assert.equal(organised.points.length, 3 * 160 * 120);
  assert.ok(organised.points instanceof Float32Array && Number.isNaN(organised.points[0]));
  const completed = fitter.completeDepth({ type: Uint16Array, scale: 0.001 });
  assert.equal(completed.depth.data.filter((value) => value !== 0).length, completed.completion.count);
  fitter.close();
});

test('a frame of a camera, with its image', async () => {
  const { intrinsics, depth, mask, image, edges } = frame();
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(intrinsics);
  fitter.pushDepth(depth, mask);
  assert.throws(() => fitter.pushImage({ ...image, gamma: 22 }), /gamma of the image is 22/);
  fitter.pushImage(image);
  fitter.pushEdges(edges);
  const result = await fitter.fit();
  // The pipe of this frame has r = 57.0 mm (tests/data/README.md).
  assert.ok(Math.abs(result.cylinder.radius - 0.057) < 0.001, String(result.cylinder.radius));
  assert.equal(result.limbsLocated, 2);
  const samples = fitter.limbSamples();
  assert.ok(samples.length >= 8);
  for (const { view, pixel, deviation, weight, limb } of samples) {
    assert.equal(view, 0);
    assert.ok(pixel[0] > 0 && pixel[0] < 640 && pixel[1] > 0 && pixel[1] < 480 && deviation > 0);
    assert.ok(weight >= 0 && weight <= 1 && (limb === 0 || limb === 1));
  }
  assert.deepEqual(new Set(samples.map(({ limb }) => limb)), new Set([0, 1]));
  assert.ok(fitter.extent().lengthDeviation > 0);
  // The given edges lie on the limbs; a line across the image lies on none.
  const found = Float64Array.of(10, 10, 600, 30, ...edges);
  const [none, ...limbs] = fitter.selectEdges(found);
  assert.deepEqual([none, limbs.sort()], [0, [1, 2]]);
  assert.throws(() => fitter.selectEdges(found, { reach: -1 }), coded('INVALID_ARGUMENT', /-1/));
  fitter.close();
});

test('options come back', () => {
  const options = {
    method: 'ransac', objective: 'paper', start: 'moments', nearWall: 'off', chart: 'local', edgeUse: 'as-given',
    extentRule: 'extremes', maxThreads: 2, maxIterations: 7, costTolerance: 1e-9, gradientTolerance: 1e-8,
    stepTolerance: 1e-7, initialLambda: 0.5, lambdaFactor: 3, maxLambda: 1e6, edgeWeight: 0.25, seed: 2n ** 63n + 5n,
    ransacMaxIterations: 77, ransacThreshold: 0.125, independentPoints: 50, depthNoise: 0.001, imageNoise: 2,
    edgeNoise: 0.75, maskNoise: 1.25, imageBlur: 0.9, drawnPixel: 1.5, radiusMin: 0.01, radiusMax: 0.75, axis: [0, 1, 0], axisMaxAngle: 0.3,
    depthShared: 0.004,
  };
  const fitter = new cylfuse.Fitter();
  fitter.setOptions(options);
  assert.deepEqual(fitter.getOptions(), options);
  fitter.setOptions({});
  assert.equal(fitter.getOptions().edgeWeight, 0.6);
  fitter.close();
});

test('failures carry the status and the message of the library', async () => {
  const fitter = new cylfuse.Fitter();
  await assert.rejects(cylfuse.fitPoints(new Float64Array([0, 0, 1, 0, 1, 1])), coded('TOO_FEW_POINTS'));
  assert.throws(() => fitter.setOptions({ edgeWeight: 2 }), coded('INVALID_ARGUMENT', /options.edge_weight is 2; it must lie/));
  assert.throws(() => fitter.setIntrinsics({ ...camera, fx: NaN }), coded('INVALID_INTRINSICS', /fx/));
  assert.throws(() => fitter.pushDepth(can().depth), coded('BAD_STATE'));
  assert.throws(() => fitter.result(), coded('BAD_STATE'));
  // On a thread of the pool, after a call of this thread on the same fitter.
  fitter.pushPoints(new Float64Array(6));
  await assert.rejects(fitter.fit(), coded('TOO_FEW_POINTS', /^2 of 2 points are usable/));
  assert.throws(() => fitter.completeDepth(), coded('BAD_STATE'));
  const none = { point: [0, 0, 0], direction: [0, 0, 0], radius: 1 };
  assert.throws(() => cylfuse.compare(none, none), coded('INVALID_ARGUMENT', /^axis direction is /));
  fitter.close();
  fitter.close();
  assert.throws(() => fitter.counts(), /closed/);
  await assert.rejects(fitter.fit(), /closed/);
  assert.throws(() => fitter.cancel(), /closed/);
});

test('types and shapes are checked before the call', () => {
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(camera);
  const xyz = new Float64Array(12);
  const refused = [
    [TypeError, () => fitter.pushPoints([1, 2, 3])],
    [TypeError, () => fitter.pushPoints({ data: new Int32Array(12) })],
    [RangeError, () => fitter.pushPoints(xyz.subarray(1))],
    [RangeError, () => fitter.pushPoints({ data: xyz, width: 5 })],
    [RangeError, () => fitter.pushPoints({ data: xyz, pointStride: -3 })],
    [RangeError, () => fitter.pushPoints({ data: xyz, width: 2 ** 52, height: 2 ** 52 })],
    [RangeError, () => fitter.pushPoints({ data: xyz, width: 1000, height: 1, pointStride: 1 })],
    [TypeError, () => fitter.pushPoints({ data: xyz, pointstride: 3 })],
    [TypeError, () => fitter.pushPoints({ data: xyz, height: 2 })],
    [RangeError, () => fitter.pushPoints({ data: xyz, weights: new Float64Array(3) })],
    [TypeError, () => fitter.pushPoints({ data: xyz, weights: new Float32Array(4) })],
    [RangeError, () => fitter.pushPoints({ data: xyz, normals: new Float64Array(3) })],
    [RangeError, () => fitter.pushPoints(xyz, { data: new Uint8Array(1), width: 4, height: 1 })],
    [RangeError, () => fitter.pushDepth({ data: new Float32Array(7), width: 4, height: 2 })],
    [TypeError, () => fitter.pushDepth({ data: new Float64Array(8), width: 4, height: 2 })],
    [TypeError, () => fitter.pushDepth({ data: new Float32Array(8), width: 4 })],
    [RangeError, () => fitter.pushImage({ data: new Uint8Array(22), width: 4, height: 2, pixelStride: 3, rowStride: 13 })],
    [TypeError, () => fitter.pushImage({ data: new Uint8Array(8), width: 4, height: 2, gamma: '2.2' })],
    [RangeError, () => fitter.pushImage({ data: new Uint8Array(23), width: 4, height: 2, format: 'bgr' })],
    [RangeError, () => fitter.pushImage({ data: new Uint8Array(24), width: 4, height: 2, format: 'rgba' })],
    [TypeError, () => fitter.pushImage({ data: new Uint16Array(24), width: 4, height: 2, format: 'rgb' })],
    [TypeError, () => fitter.pushImage({ data: new Uint8Array(24), width: 4, height: 2, format: 'hsv' })],
    [RangeError, () => fitter.selectView(-1)],
    [TypeError, () => fitter.setPose({ rotation: [1, 0, 0], translation: [0, 0, 0] })],
    [TypeError, () => fitter.setDepthCamera({ intrinsics: camera })],
    [TypeError, () => fitter.clearInput('images')],
    [TypeError, () => fitter.useFrame({})],
    [RangeError, () => cylfuse.unprojectPixels(camera, new Float64Array(3))],
    [RangeError, () => fitter.pushEdges(new Float32Array(6))],
    [RangeError, () => fitter.pushEdges({ data: new Float32Array(8), weights: new Float64Array(1) })],
    [TypeError, () => fitter.setOptions({ objective: 'Paper' })],
    [TypeError, () => fitter.setOptions({ objective: 'toString' })],
    [TypeError, () => fitter.setOptions({ edgeweight: 0.5 })],
    [TypeError, () => fitter.setOptions({ edgeWeight: '0.5' })],
    [RangeError, () => fitter.setOptions({ maxIterations: 1.5 })],
    [RangeError, () => fitter.setOptions({ seed: -1n })],
    [TypeError, () => fitter.setStartModel({ point: [0, 0], direction: [0, 1, 0], radius: 1 })],
    [TypeError, () => fitter.setProgress('none')],
    [TypeError, () => fitter.complete({ type: Int32Array })],
    [RangeError, () => fitter.reserve(-1)],
  ];
  for (const [type, call] of refused) assert.throws(call, type, String(call));
  assert.equal(fitter.counts().pointsGiven, 0);
  fitter.close();
});

test('geometry', () => {
  const cylinder = { point: [0, 0, 2], direction: [0, 2, 0], radius: 0.5 };
  const lines = cylfuse.project(cylinder, { width: 100, height: 100, fx: 100, fy: 100, cx: 50, cy: 50 });
  // The limbs stand at the angle asin(r / distance) from the middle.
  const limb = 100 * Math.tan(Math.asin(0.25));
  const at = lines.map(([a, , c]) => -c / a).sort((a, b) => a - b);
  assert.ok(Math.abs(at[0] - (50 - limb)) < 1e-9 && Math.abs(at[1] - (50 + limb)) < 1e-9, String(at));
  const other = { point: [0.25, 0, 2], direction: [0, 1, 0], radius: 0.25 };
  assert.deepEqual(cylfuse.compare(cylinder, other), { angle: 0, axisDistance: 0.25, radiusRelative: -0.5 });
});

test('plan', () => {
  const camera = { width: 640, height: 480, fx: 570, fy: 570, cx: 319.5, cy: 239.5 };
  const can = { distance: 0.7, radius: 0.03, length: 0.1, tilt: 0.35, turn: 0.42 };
  const { scatter, total } = cylfuse.plan(camera, can);
  for (const name of ['radius', 'direction', 'position', 'length']) assert.ok(0 < scatter[name] && scatter[name] < total[name]);
  const noisy = cylfuse.plan(camera, can, [0.01, 0, 0, 9, 0.014, 0.7]);
  assert.ok(noisy.scatter.position > 2 * scatter.position);
  assert.ok(Number.isNaN(cylfuse.plan(camera, { distance: 0.7, radius: 0.03, length: 2 }).total.length));
  assert.throws(() => cylfuse.plan(camera, { ...can, radius: -1 }), coded('INVALID_ARGUMENT', /^radius is -1/));
  assert.throws(() => cylfuse.plan(camera, can, [1]), RangeError);
});

for (const [name, run] of [['fit', (fitter) => fitter.fit()], ['fitSync', async (fitter) => fitter.fitSync()]]) {
  test(`callbacks of ${name}`, async () => {
    const fitter = new cylfuse.Fitter();
    fitter.pushPoints(pipe());
    const lines = [];
    fitter.setLog('info', (level, message) => lines.push([level, message]));
    let solves = 0;
    let last;
    fitter.setProgress((progress) => {
      assert.ok(progress.phase === 'solve' || progress.cylinder === null);
      if (progress.phase !== 'solve') return;
      solves += 1;
      last = progress.cylinder;
      assert.throws(() => fitter.counts(), coded('BUSY'));
      assert.throws(() => fitter.close(), coded('BUSY'));
    });
    const { cylinder } = await run(fitter);
    assert.ok(solves > 0 && lines.length > 0);
    assert.ok(Math.abs(last.radius - cylinder.radius) < 1e-6, JSON.stringify(last));
    assert.ok(lines.every(([level, message]) => ['error', 'warning', 'info'].includes(level) && message.length > 0));

    fitter.setProgress(() => false);
    await assert.rejects(run(fitter), coded('CANCELLED'));
    fitter.setProgress(() => fitter.cancel());
    await assert.rejects(run(fitter), coded('CANCELLED'));
    // Between calls there is nothing to cancel.
    fitter.setProgress(null);
    fitter.cancel();
    await run(fitter);
    fitter.setProgress(() => { throw new Error('of the caller'); });
    await assert.rejects(run(fitter), /of the caller/);

    fitter.setProgress(null);
    fitter.setLog('off', null);
    fitter.clear();
    fitter.pushPoints(pipe());
    assert.deepEqual((await run(fitter)).cylinder, cylinder);
    fitter.close();
  });
}

test('a fit leaves the event loop free, and refuses other calls meanwhile', async () => {
  const fitter = canFitter();
  let turns = 0;
  let running = true;
  // The fit ends only after the loop has turned: its progress waits for this thread.
  fitter.setProgress(() => {});
  const turn = () => { if (running) { turns += 1; setImmediate(turn); } };
  const fitting = fitter.fit();
  turn();
  assert.throws(() => fitter.counts(), coded('BUSY', /another call/));
  assert.throws(() => fitter.close(), coded('BUSY'));
  await assert.rejects(fitter.fit(), coded('BUSY'));
  await fitting;
  running = false;
  assert.ok(turns > 0);
  assert.equal(fitter.counts().segmentsGiven, 2);
  fitter.close();
});

test('memory that is collected during a fit is not what it writes to', async () => {
  const fitter = canFitter();
  const want = fitter.fitSync();
  for (let round = 0; round < 5; round += 1) {
    fitter.setProgress(() => { global.gc(); });
    assert.deepEqual((await fitter.fit()).covariance, want.covariance);
  }
  fitter.close();
});

test('eight fitters at once', async () => {
  const fitters = Array.from({ length: 8 }, canFitter);
  const want = fitters[0].fitSync().cylinder;
  for (let round = 0; round < 5; round += 1) {
    for (const { cylinder } of await Promise.all(fitters.map((fitter) => fitter.fit()))) {
      assert.deepEqual(cylinder, want);
    }
  }
  for (const fitter of fitters) fitter.close();
});

test('eight workers at once', async () => {
  const program = `
    const { parentPort } = require('node:worker_threads');
    const cylfuse = require(${JSON.stringify(path.join(__dirname, '..'))});
    const { pipe } = require(${JSON.stringify(path.join(__dirname, 'support.js'))});
    (async () => {
      let heard = 0;
      let result;
      for (let round = 0; round < 20; round += 1) {
        const fitter = new cylfuse.Fitter();
        fitter.setProgress(() => { heard += 1; });
        fitter.pushPoints(pipe());
        result = round % 2 ? fitter.fitSync() : await fitter.fit();
        fitter.close();
      }
      parentPort.postMessage({ cylinder: result.cylinder, heard });
    })();`;
  const want = (await cylfuse.fitPoints(pipe())).cylinder;
  const runs = Array.from({ length: 8 }, () => new Promise((resolve, reject) => {
    const worker = new Worker(program, { eval: true });
    let message;
    worker.on('message', (value) => { message = value; });
    worker.on('error', reject);
    worker.on('exit', (code) => (code === 0 && message ? resolve(message) : reject(new Error(`exit ${code}`))));
  }));
  for (const { cylinder, heard } of await Promise.all(runs)) {
    assert.deepEqual(cylinder, want);
    assert.ok(heard >= 20);
  }
});

test('memory stays flat over 10,000 fitters', async () => {
  const xyz = pipe();
  const cycles = async (count) => {
    for (let k = 0; k < count; k += 1) {
      const fitter = new cylfuse.Fitter();
      fitter.pushPoints(xyz);
      if (k % 2) fitter.fitSync();
      else await fitter.fit();
      fitter.close();
    }
    await collect();
  };
  await cycles(3000);
  // A fitter and its points take 7 kB at least: a leak of all would be 70 MB.
  await memoryStaysFlat(25, () => cycles(10000));
});

test('forgotten fitters are freed', async () => {
  const xyz = new Float64Array(18000);
  for (let k = 0; k < 30; k += 1) xyz.set(pipe(), 600 * k);
  const forget = async (count) => {
    for (let k = 0; k < count; k += 1) {
      const fitter = new cylfuse.Fitter();
      fitter.pushPoints(xyz);
      // A callback that refers to its fitter must not keep it.
      fitter.setProgress(() => fitter.cancel());
    }
    await collect();
  };
  await forget(100);
  // Their points would be 288 MB.
  await memoryStaysFlat(72, async () => {
    for (let round = 0; round < 20; round += 1) await forget(100);
  });
});

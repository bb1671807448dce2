'use strict';
// Views, frames, depth cameras, colours, and the calls that need no fitter.

const assert = require('node:assert/strict');
const { test } = require('node:test');
const cylfuse = require('..');
const { frame, pipe, camera, can, collect, memoryStaysFlat } = require('./support.js');

const IDENTITY = { rotation: [1, 0, 0, 0, 1, 0, 0, 0, 1], translation: [0, 0, 0] };
// At the right of the can: this camera sees the same as the one in front of it.
const FROM_THE_SIDE = { rotation: [0, 0, -1, 0, 1, 0, 1, 0, 0], translation: [0.5, 0, 0.5] };
const CAN = { point: [0, 0, 0.5], direction: [0, 1, 0], radius: 0.04 };

const coded = (code, message = /./) => (error) => error.code === code && message.test(error.message);

test('two views of one cylinder', async () => {
  const fitter = new cylfuse.Fitter();
  const { depth, mask } = can();
  [IDENTITY, FROM_THE_SIDE].forEach((pose, view) => {
    fitter.selectView(view);
    fitter.setIntrinsics(camera);
    fitter.setPose(pose);
    fitter.pushDepth(depth, mask);
  });
  assert.equal(fitter.viewCount(), 2);
  assert.throws(() => fitter.selectView(3), coded('INVALID_ARGUMENT', /3/));
  assert.throws(() => fitter.setPose({ ...IDENTITY, rotation: new Array(9).fill(0) }), coded('INVALID_ARGUMENT'));
  const result = await fitter.fit();
  const difference = cylfuse.compare(CAN, result.cylinder);
  assert.ok(Math.abs(difference.radiusRelative) < 1e-5 && difference.axisDistance < 1e-6, JSON.stringify(difference));
  const counts = fitter.counts();
  assert.deepEqual([counts.view, result.pointsUsed], [1, 2 * counts.pointsUsed]);
  const { weights, inliers } = fitter.pointWeights();
  assert.deepEqual([weights.length, inliers.length], [counts.pointsUsed, counts.pointsUsed]);
  assert.equal(fitter.residuals('points').length, counts.pointsUsed);
  assert.ok(weights.every((weight, i) => weight >= 0 && weight <= 1 && inliers[i] === Number(weight > 0)));
  const parts = fitter.pointParts();
  assert.deepEqual([parts.length, parts[parts.length >> 1]], [counts.pointsUsed, 'body']);
  assert.deepEqual(fitter.limbs().map(({ view, limb, status }) => [view, limb, status]),
    [[0, 0], [0, 1], [1, 0], [1, 1]].map((place) => [...place, 'not-searched']));
  const extent = fitter.extent();
  assert.ok(Math.abs(extent.length - 0.1) < 0.003, String(extent.length));
  assert.deepEqual(fitter.endSamples(), []);
  // What the second camera sees is in the reference frame, too.
  const { points, completion } = fitter.complete();
  assert.equal(completion.view, 1);
  assert.ok(points.length > 0);
  assert.ok(cylfuse.distances(result.cylinder, points).every((distance) => Math.abs(distance) < 1e-9));
  fitter.clear();
  assert.equal(fitter.viewCount(), 1);
  fitter.close();
});

test('views have cameras of their own', () => {
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(camera);
  fitter.selectView(1);
  fitter.setIntrinsics({ width: 8, height: 6, fx: 7, fy: 7, cx: 3.5, cy: 2.5 });
  for (const [view, width, height] of [[0, 160, 120], [1, 8, 6]]) {
    fitter.selectView(view);
    const mask = { data: new Uint8Array(width * height).fill(1), width, height };
    const { depth, completion } = fitter.completeDepth({ model: CAN, mask });
    assert.deepEqual([depth.width, depth.data.length, completion.view], [width, width * height, view]);
  }
  fitter.close();
});

test('a frame of two fitters', async () => {
  const { intrinsics, depth, mask, image } = frame();
  const alone = new cylfuse.Fitter();
  alone.setIntrinsics(intrinsics);
  alone.pushDepth(depth, mask);
  alone.pushImage(image);
  const want = (await alone.fit()).cylinder;
  alone.close();

  const shared = new cylfuse.Frame();
  assert.throws(() => shared.setDepth(depth), coded('BAD_STATE'));
  shared.setIntrinsics(intrinsics);
  shared.setPose(IDENTITY);
  shared.setDepth(depth);
  shared.setImage(image);
  const fitters = [1, 2].map((label) => {
    // An image of labels, in which all else has another one.
    const data = mask.data.map((inside) => (inside ? label : 9));
    const fitter = new cylfuse.Fitter();
    fitter.useFrame(shared, { ...mask, data, label });
    return fitter;
  });
  assert.throws(() => fitters[0].useFrame(shared, { ...mask, data: new Uint8Array(640 * 480) }), coded('EMPTY_MASK'));
  shared.close();
  shared.close();
  assert.throws(() => shared.setPose(IDENTITY), /the frame is closed/);
  assert.throws(() => fitters[0].useFrame(shared), /the frame is closed/);
  for (const { cylinder, limbsLocated } of await Promise.all(fitters.map((fitter) => fitter.fit()))) {
    assert.deepEqual(cylinder, want);
    assert.equal(limbsLocated, 2);
  }
  const [first] = fitters;
  assert.equal(first.completeDepth().depth.width, 640);
  const limbs = first.limbs();
  assert.deepEqual(limbs.map(({ status }) => status), ['located', 'located']);
  assert.equal(limbs[0].samples + limbs[1].samples, first.limbSamples().length);
  assert.ok(limbs.every(({ line, deviation }) => line.every(Number.isFinite) && deviation > 0));
  const { startSource, endSource, limbsKnown } = first.extent();
  const ends = first.endSamples();
  assert.ok([startSource, endSource].every((source) => ['extreme', 'mask', 'image', 'border'].includes(source)));
  assert.equal(typeof limbsKnown, 'boolean');
  for (const [end, source] of [startSource, endSource].entries()) {
    assert.equal(ends.some((sample) => sample.end === end && sample.deviation > 0), source === 'image');
  }
  for (const fitter of fitters) fitter.close();
});

test('forgotten frames are freed', async () => {
  const data = new Float32Array(640 * 480).fill(1);
  const intrinsics = { width: 640, height: 480, fx: 570, fy: 570, cx: 319.5, cy: 239.5 };
  const forget = async (count) => {
    for (let k = 0; k < count; k += 1) {
      const forgotten = new cylfuse.Frame();
      forgotten.setIntrinsics(intrinsics);
      forgotten.setDepth({ data, width: 640, height: 480 });
    }
    await collect();
  };
  await forget(20);
  // Their depth images would be 234 MB at least.
  await memoryStaysFlat(80, async () => {
    for (let round = 0; round < 10; round += 1) await forget(20);
  });
});

test('depth of a camera of its own', () => {
  const fitter = new cylfuse.Fitter();
  const { depth } = can();
  const mask = { data: new Uint8Array(160 * 120).fill(1), width: 160, height: 120 };
  fitter.setIntrinsics(camera);
  // The colour camera is 30 mm to the right.
  const toColour = { ...IDENTITY, translation: [-0.03, 0, 0] };
  fitter.setDepthCamera({ intrinsics: camera, toColour });
  fitter.pushDepth(depth, mask);
  const difference = cylfuse.compare({ ...CAN, point: [-0.03, 0, 0.5] }, fitter.fitSync().cylinder);
  assert.ok(Math.abs(difference.radiusRelative) < 1e-4 && difference.axisDistance < 1e-5, JSON.stringify(difference));
  fitter.clear();
  fitter.setDepthCamera(null);
  assert.throws(() => fitter.setDepthCamera({ intrinsics: { ...camera, fx: -1 }, toColour }),
    coded('INVALID_INTRINSICS', /fx/));
  fitter.close();
});

test('images in colour', () => {
  const { intrinsics, depth, mask, image } = frame();
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(intrinsics);
  fitter.pushDepth(depth, mask);
  const fit = (given) => {
    fitter.pushImage(given);
    const { cylinder, limbsLocated } = fitter.fitSync();
    assert.equal(limbsLocated, 2);
    return cylinder;
  };
  /** The image in colours that are these parts of the grey value. */
  const colours = (format, parts, more = {}) => {
    const data = new Uint8Array(parts.length * image.data.length);
    image.data.forEach((value, i) => parts.forEach((part, c) => { data[parts.length * i + c] = value * part; }));
    return { ...image, data, format, ...more };
  };
  const grey = fit(image).radius;
  assert.ok(Math.abs(fit(colours('bgr', [1, 1, 1])).radius / grey - 1) < 1e-6);
  const bgr = fit(colours('bgr', [0.25, 0.5, 1]));
  assert.deepEqual(fit(colours('rgb', [1, 0.5, 0.25])), bgr);
  assert.deepEqual(fit(colours('bgra', [0.25, 0.5, 1, 0.3])), bgr);
  assert.deepEqual(fit(colours('rgba', [1, 0.5, 0.25, 0])), bgr);
  assert.deepEqual(fit(colours('rgb', [1, 0.5, 0.25, 0.1, 0.2], { pixelStride: 5 })), bgr);
  fitter.close();
});

test('inputs are cleared one by one', () => {
  const { intrinsics, depth, mask, image, edges } = frame();
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(intrinsics);
  fitter.pushDepth(depth, mask);
  fitter.pushImage(image);
  fitter.pushEdges(edges);
  const all = fitter.fitSync();
  fitter.clearInput('image');
  assert.deepEqual([fitter.fitSync().limbsLocated, fitter.result().segmentsUsed], [0, 2]);
  fitter.clearInput('edges');
  assert.deepEqual([fitter.fitSync().segmentsGiven, fitter.result().pointsUsed], [0, all.pointsUsed]);
  fitter.close();

  const cloud = new cylfuse.Fitter();
  cloud.pushPoints(pipe());
  const { cylinder } = cloud.fitSync();
  cloud.clearInput('points', 'depth');
  assert.throws(() => cloud.fitSync(), coded('TOO_FEW_POINTS'));
  assert.deepEqual(cloud.result().cylinder, cylinder);
  cloud.close();
});

test('a stated number of independent points', () => {
  const fitter = new cylfuse.Fitter();
  fitter.pushPoints(pipe());
  fitter.setOptions({ independentPoints: 40 });
  assert.equal(fitter.fitSync().independentPoints, 40);
  fitter.close();
});

test('points to pixels and back', () => {
  const distorted = { ...camera, distortionModel: 'brown-conrady', distortion: [-0.2, 0.05, 0.001, -0.002] };
  const pixels = Float64Array.of(3, 4, 79.5, 59.5, 150, 100, NaN, 0);
  const rays = cylfuse.unprojectPixels(distorted, pixels);
  assert.deepEqual([rays.length, rays[2], rays[9]], [12, 1, NaN]);
  const seen = cylfuse.projectPoints(distorted, rays.map((value) => 2 * value));
  assert.ok(seen.subarray(0, 6).every((value, i) => Math.abs(value - pixels[i]) < 1e-9), String(seen));
  assert.ok(Number.isNaN(seen[6]) && Number.isNaN(seen[7]));
  assert.equal(cylfuse.unprojectPixels(camera, new Float64Array(0)).length, 0);
  assert.throws(() => cylfuse.projectPoints({ ...camera, fx: 0 }, rays), coded('INVALID_INTRINSICS', /fx/));
});

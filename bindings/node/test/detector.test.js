'use strict';

const assert = require('node:assert/strict');
const { test } = require('node:test');
const cylfuse = require('..');
const { pair, collect, memoryStaysFlat } = require('./support.js');

const coded = (code, message = /./) => (error) => error.code === code && message.test(error.message);
const scene = pair();
const { intrinsics, truths, lengths, owners, depth, image, points } = scene;
const ALL = depth.data.length;

function makeFrame(withImage = true) {
  const frame = new cylfuse.Frame();
  frame.setIntrinsics(intrinsics);
  frame.setDepth(depth);
  if (withImage) frame.setImage(image);
  return frame;
}

/** The number of the cylinder that a model is, from 0; -1 for none. */
const which = (model, tolerance) => truths.findIndex((truth) => {
  const { angle, axisDistance, radiusRelative } = cylfuse.compare(truth, model);
  return angle < tolerance && axisDistance < tolerance * truth.radius && Math.abs(radiusRelative) < tolerance;
});

/** Checks what a detector says of both cylinders, and one thing against another. */
function check(detector, found, tolerance) {
  const { data } = detector.labels();
  assert.equal(data.length, ALL);
  assert.equal(found.length, 2);
  assert.ok(found[0].score >= found[1].score && found[1].score >= 0.5 && found[0].score <= 1);
  const seen = found.map(({ pixels, result, extent }, index) => {
    const truth = which(result.cylinder, tolerance);
    const indices = detector.indices(index);
    assert.ok(indices.length === pixels && pixels > 300);
    assert.ok(indices.every((place, k) => data[place] === index + 1 && (k === 0 || place > indices[k - 1])));
    assert.ok(indices.filter((place) => owners[place] === truth + 1).length > 0.95 * pixels);
    assert.ok(result.startKind === 'model' && result.radiusDeviation > 0);
    assert.ok(result.pointsUsed > 0 && result.pointsUsed <= pixels);
    if (extent) assert.ok(Math.abs(extent.length - lengths[truth]) < 0.05 * lengths[truth]);
    return truth;
  });
  assert.deepEqual(seen.sort(), [0, 1]);
  assert.equal(data.filter((label) => label > 0).length, found[0].pixels + found[1].pixels);
}

/** Without the times. */
const bare = (found) => found.map(({ score, pixels, result, extent }) => [
  score, pixels, result.cylinder, result.covariance, extent,
]);

test('a search that was cut short says so', () => {
  // Bumps in both directions, 12 pixels apart: more to look at than a search may.
  const wave = (k) => Math.sin(Math.PI / 6 * k);
  const bumps = Float32Array.from({ length: 640 * 480 }, (_, k) => (
    1 + 1.2 / 525 * wave(k % 640) * wave(Math.floor(k / 640))
  ));
  const frame = new cylfuse.Frame();
  frame.setIntrinsics({ width: 640, height: 480, fx: 525, fy: 525, cx: 319.5, cy: 239.5 });
  frame.setDepth({ data: bumps, width: 640, height: 480, scale: 1 });
  const detector = new cylfuse.Detector();
  assert.throws(() => detector.isComplete(), coded('BAD_STATE'));
  assert.throws(() => detector.depthMoved(), coded('BAD_STATE'));
  detector.detectSync(frame);
  assert.equal(detector.isComplete(), false);
  detector.detectSync(makeFrame());
  assert.equal(detector.isComplete(), true);
  assert.deepEqual(detector.depthMoved(), [0, 0]);
});

test('the cylinders of a frame', async () => {
  const detector = new cylfuse.Detector();
  const [frame, without] = [makeFrame(), makeFrame(false)];
  const found = await detector.detect(frame);
  check(detector, found, 0.01);
  assert.ok(found.every(({ extent, extentError }) => extent !== null && extentError === null));
  assert.deepEqual([detector.labels().width, detector.labels().height], [160, 120]);
  assert.equal(found[0].result.limbsLocated, 2);
  assert.deepEqual(bare(detector.detections()), bare(found));
  assert.deepEqual(bare(detector.detectSync(frame)), bare(found));

  // The image is not looked at: as if there were none.
  detector.setOptions({ imageUse: 'ignore' });
  const ignored = await detector.detect(frame);
  check(detector, ignored, 0.1);
  detector.setOptions({});
  const missing = await detector.detect(without);
  assert.deepEqual(bare(ignored), bare(missing));

  // In the reference frame.
  without.setPose({ rotation: [0.8, 0, 0.6, 0, 1, 0, -0.6, 0, 0.8], translation: [-0.5, 0.1, 0.2] });
  for (const [index, { result }] of detector.detectSync(without).entries()) {
    const turn = ([x, y, z]) => [0.8 * x + 0.6 * z, y, -0.6 * x + 0.8 * z];
    const { point, direction, radius } = missing[index].result.cylinder;
    const [x, y, z] = turn(point);
    const there = { point: [x - 0.5, y + 0.1, z + 0.2], direction: turn(direction), radius };
    for (const difference of Object.values(cylfuse.compare(there, result.cylinder))) {
      assert.ok(Math.abs(difference) < 1e-9);
    }
  }
  frame.close();
  without.close();
  assert.equal(detector.detections().length, 2);
  detector.close();
});

test('a missing extent has its reason', (t) => {
  const { functions } = require('../lib/native.js');
  const { status: { EDGE_GEOMETRY } } = require('../lib/names.js').enumerations;
  t.mock.method(functions, 'cylfuse_detector_get_extent', () => EDGE_GEOMETRY);
  t.mock.method(functions, 'cylfuse_detector_last_error', () => 'no ray of the region meets it');
  const detector = new cylfuse.Detector();
  const frame = makeFrame();
  const found = detector.detectSync(frame);
  assert.equal(found.length, 2);
  for (const { extent, extentError } of found) {
    assert.equal(extent, null);
    assert.ok(extentError instanceof cylfuse.CylfuseError);
    assert.ok(coded('EDGE_GEOMETRY', /^no ray of the region meets it$/)(extentError));
  }
  detector.close();
  frame.close();
});

test('the cylinders of a cloud', async () => {
  const detector = new cylfuse.Detector();
  const found = await detector.detectPoints(points);
  check(detector, found, 0.1);
  assert.equal(detector.labels().height, 120);
  assert.ok(found.every(({ extent }) => extent.endSource === 'points'));
  assert.deepEqual(bare(detector.detectPointsSync(points)), bare(found));

  // Not organised, float, one after the other with other things between them, and weights.
  const mixed = new Float32Array(6 * ALL);
  for (let k = 0; k < ALL; k += 1) mixed.set([...points.data.subarray(3 * k, 3 * k + 3), 1], 6 * k);
  const view = { data: mixed, width: ALL, pointStride: 6, weights: mixed.subarray(3), weightStride: 6 };
  check(detector, await detector.detectPoints(view), 0.1);
  assert.deepEqual([detector.labels().width, detector.labels().height], [ALL, 1]);
  // Weights of 0 leave points out: all but those of the wall and the first cylinder.
  for (let k = 0; k < ALL; k += 1) mixed[6 * k + 3] = owners[k] === 2 ? 0 : 2;
  const searching = detector.detectPoints(view);
  // The points were copied at once.
  mixed[6 * 7 + 3] = -1;
  assert.equal((await searching).length, 1);
  await assert.rejects(detector.detectPoints(view), coded('INVALID_ARGUMENT', /the weight of point 7 is -1/));
  assert.throws(() => detector.detectPointsSync(view), coded('INVALID_ARGUMENT', /the weight of point 7 is -1/));
  assert.equal(detector.detections().length, 1);
  detector.close();
});

test('a fitter goes on', async () => {
  const detector = new cylfuse.Detector();
  const frame = makeFrame();
  const [, one] = await detector.detect(frame);
  const fitter = detector.fitter(1);
  const indices = detector.indices(1);
  detector.close();
  frame.close();
  assert.deepEqual(fitter.result().covariance, one.result.covariance);
  assert.deepEqual(fitter.extent(), one.extent);
  assert.deepEqual(fitter.limbs().map(({ status }) => status), ['located', 'located']);
  assert.equal(fitter.residuals('points').length, one.result.pointsUsed);
  assert.equal(fitter.completeDepth().depth.width, 160);
  const { points: completed } = fitter.complete();
  assert.ok(completed.length > 0 && completed.length <= 3 * indices.length);
  const { start, maxThreads } = fitter.getOptions();
  assert.deepEqual([start, maxThreads], ['model', 1]);
  // The same fit once more.
  assert.deepEqual((await fitter.fit()).cylinder, one.result.cylinder);
  fitter.close();

  const another = new cylfuse.Detector();
  const found = await another.detectPoints(points);
  const ofPoints = another.fitter(0);
  // Fitted to its whole region: its points share no errors.
  assert.equal(ofPoints.counts().pointsUsed, found[0].pixels);
  assert.deepEqual(ofPoints.result().cylinder, found[0].result.cylinder);
  ofPoints.close();
  const text = /index is 2; it must be less than the number of cylinders, 2/;
  assert.throws(() => another.fitter(2), coded('INVALID_ARGUMENT', text));
  assert.throws(() => another.indices(2), coded('INVALID_ARGUMENT', text));
  assert.throws(() => another.fitter(-1), RangeError);
  another.close();
});

test('limits hold', () => {
  const detector = new cylfuse.Detector();
  const frame = makeFrame();
  const options = {
    imageUse: 'auto', maxThreads: 1, maxCount: 0, minPixels: 100, minScore: 0.5, radiusMin: 0.04, radiusMax: 0.06,
    axis: [0, -3, 0], axisMaxAngle: 0.2,
  };
  detector.setOptions(options);
  assert.deepEqual(detector.getOptions(), options);
  for (const found of [detector.detectSync(frame), detector.detectPointsSync(points)]) {
    assert.equal(found.length, 1);
    assert.ok(Math.abs(found[0].result.cylinder.radius - 0.05) < 0.005);
  }
  detector.setOptions({ maxCount: 1 });
  assert.equal(detector.detectSync(frame).length, 1);
  detector.setOptions({ minPixels: 2n ** 64n - 1n });
  assert.deepEqual(detector.detectSync(frame), []);
  assert.ok(detector.labels().data.every((label) => label === 0));
  assert.throws(() => detector.setOptions({ minScore: 1.5 }), coded('INVALID_ARGUMENT', /options.min_score is 1.5/));
  assert.throws(() => detector.setOptions({ minScores: 1 }), /options has no minScores/);
  detector.setFitOptions({ depthNoise: 0.001 });
  for (const refused of [{ start: 'moments' }, { maxThreads: 2 }, { radiusMax: 0.1 }]) {
    assert.throws(() => detector.setFitOptions(refused), coded('INVALID_ARGUMENT', /of the fits/));
  }
  assert.equal(detector.getFitOptions().depthNoise, 0.001);
  assert.equal(detector.getOptions().minPixels, 2n ** 64n - 1n);
  detector.setOptions({});
  detector.setFitOptions({ objective: 'paper' });
  assert.throws(() => detector.detectSync(frame), coded('UNSUPPORTED'));
  detector.close();
  frame.close();
});

test('any number of threads gives the same bits', async () => {
  const frame = makeFrame();
  const outcomes = await Promise.all([1, 3].map(async (maxThreads) => {
    const detector = new cylfuse.Detector();
    detector.setOptions({ maxThreads });
    const found = bare(await detector.detect(frame));
    detector.close();
    return found;
  }));
  assert.deepEqual(outcomes[0], outcomes[1]);
  frame.close();
});

test('what needs a search', async () => {
  const detector = new cylfuse.Detector();
  const frame = new cylfuse.Frame();
  for (const call of [
    () => detector.detections(), () => detector.labels(), () => detector.indices(0), () => detector.fitter(0),
  ]) assert.throws(call, coded('BAD_STATE', /search a frame or points first/));
  await assert.rejects(detector.detect(frame), coded('BAD_STATE', /intrinsics/));
  frame.setIntrinsics(intrinsics);
  assert.throws(() => detector.detectSync(frame), coded('BAD_STATE', /depth/));
  await assert.rejects(detector.detect({}), { message: 'frame must be a Frame, not Object' });
  await assert.rejects(detector.detectPoints([1, 2, 3]), /points must be a typed array/);
  assert.deepEqual(await detector.detectPoints(new Float64Array(0)), []);
  assert.deepEqual(detector.labels().data, new Uint16Array(0));
  detector.close();
  detector.close();
  assert.throws(() => detector.labels(), /the detector is closed: make a new one/);
  await assert.rejects(detector.detectPoints(points), /the detector is closed/);
  frame.close();
});

for (const [name, run] of [
  ['detect', (detector, frame) => detector.detect(frame)],
  ['detectSync', async (detector, frame) => detector.detectSync(frame)],
]) {
  test(`progress of ${name}`, async () => {
    const detector = new cylfuse.Detector();
    const frame = makeFrame();
    const states = [];
    detector.setProgress((progress) => {
      states.push(progress);
      assert.throws(() => detector.labels(), coded('BUSY'));
      assert.throws(() => detector.close(), coded('BUSY'));
    });
    const found = await run(detector, frame);
    assert.deepEqual(states.slice(0, 2).map(({ phase }) => phase), ['search', 'fit']);
    assert.deepEqual(states.slice(1).map(({ fitsDone }) => fitsDone), states.slice(1).map((_, k) => k));
    assert.ok(states[0].fits === 0 && states.at(-1).fitsDone === states.at(-1).fits);
    for (const stop of [() => false, () => detector.cancel(), ({ phase }) => phase === 'search']) {
      detector.setProgress(stop);
      await assert.rejects(run(detector, frame), coded('CANCELLED'));
    }
    detector.setProgress(() => { throw new Error('of the caller'); });
    await assert.rejects(run(detector, frame), /of the caller/);
    // The last scene is still there.
    detector.setProgress(null);
    assert.deepEqual(bare(detector.detections()), bare(found));
    detector.cancel();
    assert.equal((await run(detector, frame)).length, 2);
    detector.close();
    frame.close();
  });
}

test('a search leaves the event loop free, and refuses other calls meanwhile', async () => {
  const detector = new cylfuse.Detector();
  const frame = makeFrame();
  detector.setProgress(() => {});
  const searching = detector.detect(frame);
  for (const call of [
    () => detector.labels(), () => detector.close(), () => frame.close(), () => frame.setDepth(depth),
  ]) assert.throws(call, coded('BUSY'));
  await assert.rejects(detector.detect(frame), coded('BUSY'));
  detector.cancel();
  await assert.rejects(searching, coded('CANCELLED'));
  frame.setDepth(depth);
  frame.close();
  detector.close();
});

test('forgotten detectors are freed, and one that searches is not', async () => {
  const forget = async (count) => {
    for (let k = 0; k < count; k += 1) {
      const detector = new cylfuse.Detector();
      detector.setProgress(() => { detector.cancel(); });
      detector.setProgress(null);
      detector.detectPointsSync({ data: new Float64Array(3 * 640 * 480), width: 640, height: 480 });
    }
    await collect();
  };
  const searching = new cylfuse.Detector().detectPoints(points);
  await forget(3);
  // Their labels alone would be 29 MB, and the images of their search far more.
  await memoryStaysFlat(25, async () => {
    for (let round = 0; round < 10; round += 1) await forget(5);
  });
  assert.equal((await searching).length, 2);
});

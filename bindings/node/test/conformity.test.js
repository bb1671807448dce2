'use strict';
// Decisions about a tolerance, names as text, and fitters that are cloned.

const assert = require('node:assert/strict');
const { test } = require('node:test');
const cylfuse = require('..');
const { enumerations } = require('../lib/names.js');
const { pipe } = require('./support.js');

test('the interval decides about a tolerance', () => {
  const limits = { lower: 19.5, upper: 20.25 };
  assert.equal(cylfuse.decideConformity(20, 0.12, limits), 'conforming');
  assert.equal(cylfuse.decideConformity(20, 0.13, limits), 'undecided');
  assert.equal(cylfuse.decideConformity(20, 0.13, { ...limits, coverage: 1 }), 'conforming');
  assert.equal(cylfuse.decideConformity(20, 0.13, { upper: 19.5 }), 'not-conforming');
  assert.equal(cylfuse.decideConformity(20, NaN, limits), 'undecided');
  assert.equal(cylfuse.decideConformity(20, 0.12, limits, ['weak-radius']), 'conforming');
  assert.equal(cylfuse.decideConformity(20, 0.12, limits, ['weak-radius', 'poor-fit']), 'undecided');
  assert.throws(() => cylfuse.decideConformity(20, 0.1, { lower: 21, upper: 19 }), /21 to 19/);
  assert.throws(() => cylfuse.decideConformity(20, 0.1, { low: 21 }), /tolerance has no low/);
  assert.throws(() => cylfuse.decideConformity(20, 0.1, { lower: '19' }), /lower must be a number/);
  assert.throws(() => cylfuse.decideConformity(20, 0.1, { lower: 19, coverage: 0 }), /coverage is 0/);
  assert.throws(() => cylfuse.decideConformity(20, 0.1, limits, ['bad']), /flags is "bad"/);
});

test('names are described', () => {
  for (const [kind, describe] of [
    ['flag', (name) => cylfuse.describeFlags([name])[0]], ['termination', cylfuse.describeTermination],
    ['start', cylfuse.describeStart], ['endState', cylfuse.describeEndState], ['endSource', cylfuse.describeEndSource],
    ['limbStatus', cylfuse.describeLimbStatus], ['part', cylfuse.describePart], ['conformity', cylfuse.describeConformity],
  ]) {
    for (const name of Object.keys(enumerations[kind])) {
      const [inC, text] = describe(name).split(': ');
      assert.equal(inC, name.toUpperCase().replaceAll('-', '_'));
      assert.ok(text.length > 5, text);
    }
    assert.throws(() => describe('bad'), { name: 'TypeError', message: new RegExp(`${kind} is "bad"; it must be one of`) });
  }
  const [poor, weak] = cylfuse.describeFlags(['poor-fit', 'weak-radius']);
  assert.ok(poor.startsWith('POOR_FIT: ') && weak.startsWith('WEAK_RADIUS: '));
  assert.deepEqual(cylfuse.describeFlags([]), []);
  // Of a later library.
  assert.equal(typeof cylfuse.describeFlags([String(2 ** 31)])[0], 'string');
});

test('a result is judged by its deviation, and a clone goes its own way', async () => {
  const points = pipe();
  for (let k = 2; k < points.length; k += 3) points[k] += 0.002 * Math.sin(7 * k);
  const fitter = new cylfuse.Fitter();
  assert.throws(() => fitter.getIntrinsics(), { code: 'BAD_STATE' });
  const camera = {
    width: 640, height: 480, fx: 570, fy: 571, cx: 319.5, cy: 239.5, distortionModel: 'kannala-brandt',
    distortion: [0.01, 0, 0, -0.002, 0, 0, 0, 0],
  };
  fitter.setIntrinsics(camera);
  fitter.pushPoints(points);
  const result = await fitter.fit();
  const { cylinder: { radius }, radiusDeviation: deviation } = result;
  assert.ok(deviation > 0 && deviation < 0.1 * radius, String(deviation));
  const about = (width) => ({ lower: radius - width * deviation, upper: radius + width * deviation });
  assert.equal(cylfuse.radiusConforms(result, about(2.1)), 'conforming');
  assert.equal(cylfuse.radiusConforms(result, about(1.9)), 'undecided');
  const doubled = (width) => ({ lower: 2 * about(width).lower, upper: 2 * about(width).upper });
  assert.equal(cylfuse.diameterConforms(result, doubled(2.1)), 'conforming');
  assert.equal(cylfuse.diameterConforms(result, doubled(1.9)), 'undecided');
  assert.equal(cylfuse.diameterConforms(result, about(2.1)), 'not-conforming');

  fitter.setProgress(() => false);
  const clone = fitter.clone();
  assert.deepEqual(clone.getIntrinsics(), camera);
  assert.equal(clone.result().cylinder.radius, radius);
  assert.equal((await clone.fit()).cylinder.radius, radius); // Without the callback.
  clone.clear();
  assert.equal(fitter.counts().pointsGiven, 200);
  fitter.close();
  assert.throws(() => fitter.clone(), /closed/);
  clone.close();
});

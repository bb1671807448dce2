'use strict';

const test = require('node:test');
const assert = require('node:assert/strict');
const cylfuse = require('..');

const coded = (code) => (error) => error.code === code;

/** Pieces of a pipe; that of the third is a line. */
function fitters() {
  return Array.from({ length: 8 }, (_, k) => {
    const count = 200 + 10 * k;
    const points = new Float64Array(3 * count);
    for (let n = 0; n < count; n += 1) {
      const angle = k === 2 ? 0 : 0.007 * n;
      points.set([0.5 * Math.cos(angle), 0.1 * (n % 7), 2 - 0.5 * Math.sin(angle)], 3 * n);
    }
    const fitter = new cylfuse.Fitter();
    fitter.pushPoints(points);
    return fitter;
  });
}

test('fitters at once give the results of each', async () => {
  const alone = fitters();
  for (const threads of [0, 1, 3]) {
    const all = fitters();
    const heard = [];
    const outcomes = await cylfuse.fitAll(all, { threads, progress: (index) => { heard.push(index); } });
    assert.deepEqual(heard.sort(), [0, 1, 2, 3, 4, 5, 6, 7]);
    outcomes.forEach((outcome, k) => {
      if (k === 2) {
        assert.ok(outcome instanceof cylfuse.CylfuseError && outcome.code === 'COLLINEAR_POINTS', String(outcome));
        assert.match(outcome.message, /line/);
      } else {
        assert.deepEqual(outcome.cylinder, alone[k].fitSync().cylinder);
      }
      all[k].close();
    });
  }
  alone.forEach((fitter) => fitter.close());
});

test('fitters at once are stopped and refused', async () => {
  const all = fitters();
  await assert.rejects(cylfuse.fitAll(all, { threads: 1, progress: (index) => index < 3 }), coded('CANCELLED'));
  assert.ok(all[0].result().cylinder.radius > 0);
  const failing = () => { throw new RangeError('heard'); };
  await assert.rejects(cylfuse.fitAll(all, { threads: 2, progress: failing }), /heard/);
  const running = cylfuse.fitAll(all);
  assert.throws(() => all[5].counts(), coded('BUSY'));
  await running;
  await assert.rejects(cylfuse.fitAll([all[0], all[0]]), coded('BUSY'));
  await assert.rejects(cylfuse.fitAll([1]), TypeError);
  assert.deepEqual(await cylfuse.fitAll([]), []);
  all[5].close();
  await assert.rejects(cylfuse.fitAll(all), /closed/);
  all.forEach((fitter, k) => { if (k !== 5) fitter.close(); });
});

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
    const outcomes = await cylfuse.fitAll(all, { threads, progress: (index, status) => { heard[index] = status; } });
    assert.deepEqual(heard, ['OK', 'OK', 'COLLINEAR_POINTS', 'OK', 'OK', 'OK', 'OK', 'OK']);
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
  const stopped = await cylfuse.fitAll(all, { threads: 1, progress: (index) => index < 3 });
  assert.deepEqual(stopped.map((outcome) => outcome.code),
    [undefined, undefined, 'COLLINEAR_POINTS', undefined, 'CANCELLED', 'CANCELLED', 'CANCELLED', 'CANCELLED']);
  assert.ok(stopped[3].cylinder.radius > 0);
  assert.match(stopped[4].message, /cancel/);
  assert.ok(all[0].result().cylinder.radius > 0);
  const failing = () => { throw new RangeError('heard'); };
  await assert.rejects(cylfuse.fitAll(all, { threads: 2, progress: failing }), /heard/);
  const running = cylfuse.fitAll(all);
  assert.throws(() => all[5].counts(), coded('BUSY'));
  await running;
  await assert.rejects(cylfuse.fitAll([all[0], all[1], all[0]]), (error) => coded('INVALID_ARGUMENT')(error)
    && error.message === 'fitters[2] is the same as fitters[0]; it must be another fitter');
  await assert.rejects(cylfuse.fitAll([all[0], 1]), { name: 'TypeError', message: /^fitters\[1\] must be a Fitter, not/ });
  await assert.rejects(cylfuse.fitAll([null]), { name: 'TypeError', message: 'fitters[0] must be a Fitter, not null' });
  assert.deepEqual(await cylfuse.fitAll([]), []);
  all[5].close();
  await assert.rejects(cylfuse.fitAll(all), /closed/);
  all.forEach((fitter, k) => { if (k !== 5) fitter.close(); });
});

test('a busy fitter does not keep the others from their fit', async () => {
  const all = fitters().slice(0, 2);
  const running = all[0].fit();
  const heard = [];
  const [busy, other] = await cylfuse.fitAll(all, { progress: (index, status) => { heard[index] = status; } });
  assert.ok(busy instanceof cylfuse.CylfuseError && busy.code === 'BUSY', String(busy));
  assert.ok(other.cylinder.radius > 0);
  assert.deepEqual(heard, ['BUSY', 'OK']);
  assert.ok((await running).cylinder.radius > 0);
  all.forEach((fitter) => fitter.close());
});

test('callbacks that return a promise are refused', async () => {
  const [fitter] = fitters();
  const isRefused = { name: 'TypeError', message: /^(progress|log) returned a promise; it must be a function that is not async/ };
  // A rejection that nobody handles would end the process.
  for (const answer of [async () => false, async () => { throw new Error('mine'); }, () => ({ then() { throw new Error('odd'); } })]) {
    fitter.setProgress(answer);
    await assert.rejects(fitter.fit(), isRefused);
    assert.throws(() => fitter.fitSync(), isRefused);
    fitter.setProgress(null);
    fitter.setLog('debug', answer);
    assert.throws(() => fitter.fitSync(), isRefused);
    fitter.setLog('off', null);
    await assert.rejects(cylfuse.fitAll([fitter], { progress: answer }), isRefused);
  }
  assert.ok(fitter.fitSync().cylinder.radius > 0);
  fitter.close();
});

'use strict';
// What a careless or hostile caller does.

const assert = require('node:assert/strict');
const { execFileSync, spawnSync } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { test } = require('node:test');
const vm = require('node:vm');
const cylfuse = require('..');
const { pipe, camera, can } = require('./support.js');

const given = (fitter) => fitter.counts().pointsGiven;

test('arrays that lie, are shared, resizable, transferred or of another realm', () => {
  const fitter = new cylfuse.Fitter();
  const liar = Object.defineProperty(new Float64Array(6), 'length', { value: 3e8 });
  fitter.pushPoints(liar);
  assert.throws(() => fitter.pushPoints({ data: liar, width: 1e8 }), RangeError);
  assert.equal(given(fitter), 2);
  assert.throws(() => fitter.pushPoints(Object.create(Float64Array.prototype)), TypeError);

  const shared = new Float64Array(new SharedArrayBuffer(4800));
  shared.set(pipe());
  fitter.clear();
  fitter.pushPoints(shared);
  const { cylinder } = fitter.fitSync();
  assert.ok(Math.abs(cylinder.radius - 0.5) < 1e-9);

  // Node 18 makes a buffer of a fixed size of it.
  const resizable = new Float64Array(new ArrayBuffer(4800, { maxByteLength: 9600 }));
  if (resizable.buffer.resizable) {
    resizable.buffer.resize(2400);
    fitter.pushPoints(resizable);
    assert.equal(given(fitter), 300);
    const gone = new Float64Array(resizable.buffer, 240, 200);
    resizable.buffer.resize(80);
    assert.throws(() => fitter.pushPoints({ data: gone, width: 20 }), /points.data has 0 numbers, too few for 20 x 1/);
  }

  const transferred = pipe();
  structuredClone(transferred, { transfer: [transferred.buffer] });
  assert.throws(() => fitter.pushPoints(transferred), /points.data has no memory: its buffer was transferred/);

  fitter.clear();
  fitter.pushPoints(vm.runInNewContext('Float64Array.from(xyz)', { xyz: pipe() }));
  assert.deepEqual(fitter.fitSync().cylinder, cylinder);
  fitter.close();
});

test('messages name the value and what is expected', () => {
  const fitter = new cylfuse.Fitter();
  const xyz = pipe();
  for (const [message, call] of [
    ['points must be a typed array or an object with one as data, not Array', () => fitter.pushPoints([1, 2, 3])],
    ['points.data must be a Float32Array or Float64Array, not Int32Array', () => fitter.pushPoints(new Int32Array(3))],
    ['points.pointStride is -3; it must be an integer from 0 to 9007199254740991',
      () => fitter.pushPoints({ data: xyz, pointStride: -3 })],
    ['mask must be an object, not boolean', () => fitter.pushPoints(xyz, true)],
    ['method is 99; it must be one of "fused", "points", "ransac", "eberly"', () => fitter.setOptions({ method: 99 })],
    ['method is symbol; it must be one of "fused", "points", "ransac", "eberly"',
      () => fitter.setOptions({ method: Symbol('fused') })],
    ['axis must be an array of 3 numbers, not Array of 2', () => fitter.setOptions({ axis: [0, 1] })],
    ['axis[1] must be a number, not undefined', () => fitter.setOptions({ axis: [0, , 1] })],
    ['distortion must be an array of 0 to 8 numbers, not Array of 9',
      () => fitter.setIntrinsics({ ...camera, distortion: new Array(9).fill(0) })],
    ['progress must be a function or null, not undefined', () => fitter.setProgress()],
    ['depth has no scales; it has data, width, height, rowStride, pixelStride, scale, minDepth, maxDepth',
      () => fitter.pushDepth({ ...can().depth, scales: 1 })],
    ['depth.scale is missing, which a Uint16Array needs; give the length of one unit of depth: 0.001 for millimetres where '
      + 'lengths are to be metres, 1 where they are to be in the unit of the depth',
      () => fitter.pushDepth({ data: new Uint16Array(8), width: 4, height: 2 })],
  ]) assert.throws(call, { message });
  fitter.close();
  assert.throws(() => fitter.counts(), { message: 'the fitter is closed: make a new one' });
});

test('a listing is no error for the log', () => {
  const fitter = new cylfuse.Fitter();
  fitter.setIntrinsics(camera);
  const { depth, mask, edges } = can();
  fitter.pushDepth(depth, mask);
  fitter.pushEdges(edges);
  fitter.fitSync();
  fitter.setLog('error', (level, message) => assert.fail(message));
  assert.ok(fitter.residuals('points').length > 0);
  assert.equal(fitter.residuals('edges').length, 4);
  assert.deepEqual(fitter.limbSamples(), []);
  fitter.close();
});

test('a thousand fits at once', async () => {
  const xyz = pipe();
  const { cylinder } = await cylfuse.fitPoints(xyz);
  for (const result of await Promise.all(Array.from({ length: 1000 }, () => cylfuse.fitPoints(xyz)))) {
    assert.deepEqual(result.cylinder, cylinder);
  }
  let heard = 0;
  const fitters = Array.from({ length: 300 }, () => new cylfuse.Fitter());
  for (const fitter of fitters) {
    fitter.pushPoints(xyz);
    fitter.setProgress(() => { heard += 1; });
  }
  // One that was cancelled while it waited for a place.
  const fits = fitters.map((fitter) => fitter.fit());
  fitters[299].cancel();
  await assert.rejects(fits.pop(), { code: 'CANCELLED' });
  await Promise.all(fits);
  assert.ok(heard >= 299);
  for (const fitter of fitters) fitter.close();
});

/** Runs a program of its own to the end; `long()` in it is a fitter whose fit takes long. */
function run(program, environment = {}) {
  const file = path.join(fs.mkdtempSync(path.join(os.tmpdir(), 'cylfuse-')), 'program.js');
  fs.writeFileSync(file, `
    const { Worker, isMainThread, parentPort } = require('node:worker_threads');
    const cylfuse = require(${JSON.stringify(path.join(__dirname, '..'))});
    function long() {
      const xyz = Float64Array.from({ length: 300000 }, (_, i) => {
        const k = Math.floor(i / 3) * 1e-5;
        return [0.5 * Math.cos(k), 7 * k, 2 - 0.5 * Math.sin(k)][i % 3] + 1e-5 * Math.sin(i * i);
      });
      const fitter = new cylfuse.Fitter();
      fitter.setOptions({ costTolerance: 0 });
      fitter.pushPoints(xyz);
      return fitter;
    }
    ${program}`);
  // Time enough for any end but none, on the busiest machine too.
  const { status, signal, stdout, stderr } = spawnSync(process.execPath, ['--expose-gc', file], {
    encoding: 'utf8', timeout: 900000, env: { ...process.env, ...environment },
  });
  fs.rmSync(path.dirname(file), { recursive: true });
  return { status, signal, stdout, stderr };
}

const FIT = 'long().fit();';
const HEARD = "const fitter = long(); fitter.setProgress(() => {}); fitter.setLog('debug', () => {}); fitter.fit();";

for (const [name, program, status, printed] of [
  ['process.exit at once', `${HEARD} process.exit(5);`, 5, /^$/],
  ['process.exit later', `${HEARD} setTimeout(() => process.exit(6), 1);`, 6, /^$/],
  ['process.exit in a callback', 'const fitter = long(); fitter.setProgress(() => process.exit(7)); fitter.fit();', 7,
    /^$/],
  ['process.exit without callbacks', `${FIT} process.exit(8);`, 8, /^$/],
  ['an exception', `${HEARD} setTimeout(() => { throw new Error('of the caller'); }, 1);`, 1, /Error: of the caller/],
  ['a rejection', `${HEARD} Promise.reject(new Error('of the caller'));`, 1, /Error: of the caller/],
]) {
  test(`the process ends during a fit: ${name}`, () => {
    const ended = run(program);
    assert.deepEqual([ended.status, ended.signal], [status, null], JSON.stringify(ended));
    assert.match(ended.stderr, printed);
  });
}

for (const [name, program] of [['', FIT], [' with callbacks', HEARD]]) {
  for (const end of ['process.exit(3)', 'parentPort.postMessage(null)']) {
    test(`a worker ends during a fit${name}: ${end}`, () => {
      const ended = run(`
        if (isMainThread) {
          const worker = new Worker(__filename);
          worker.on('message', () => worker.terminate());
          worker.on('exit', () => console.log('the program goes on'));
        } else {
          ${program}
          setTimeout(() => ${end}, 1);
        }`);
      assert.deepEqual([ended.status, ended.stdout], [0, 'the program goes on\n'], JSON.stringify(ended));
    });
  }
}

test('a call on the pool takes at most five eighths of the stack that koffi gives it', () => {
  // A search in a cloud takes the most, 70 KB or less.
  const part = (require('koffi').config().async_stack_size * 5) / 8;
  const { status, signal } = spawnSync(process.execPath, ['-e', `
    require('koffi').config({ async_stack_size: ${part} });
    require('./conformance.js');`], { cwd: __dirname });
  assert.deepEqual([status, signal], [0, null]);
});

test('what a worker leaves behind is freed', () => {
  const ended = run(`
    const ends = () => new Promise((resolve) => { new Worker(__filename).on('exit', resolve); });
    if (isMainThread) {
      const { memoryStaysFlat } = require(${JSON.stringify(path.join(__dirname, 'support.js'))});
      (async () => {
        for (let k = 0; k < 10; k += 1) await ends();
        // Their points would be 140 MB.
        await memoryStaysFlat(60, async () => { for (let k = 0; k < 60; k += 1) await ends(); });
        console.log('flat');
      })();
    } else {
      globalThis.left = long();
    }`);
  assert.equal(ended.stdout, 'flat\n', JSON.stringify(ended));
});

test('another library, or none, is refused with a message', () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'cylfuse größer -'));
  const message = (file) => {
    const { stderr } = run('', { CYLFUSE_LIBRARY: file });
    return stderr.split('\n').find((line) => line.startsWith('Error: '));
  };
  const named = (file) => `Error: cylfuse cannot load the native library ${file}, which CYLFUSE_LIBRARY names: `;
  const missing = path.join(folder, 'none.so');
  const starts = (text, start) => assert.ok(text.startsWith(start), text);
  starts(message(missing), `${named(missing)}Failed to load shared library: cannot open`);
  assert.match(message(missing), /\. Set CYLFUSE_LIBRARY to the path of libcylfuse\.so$/);
  starts(message(__filename), `${named(__filename)}Failed to load shared library: `);

  const library = (code) => {
    const file = path.join(folder, 'libcylfuse.so');
    fs.writeFileSync(path.join(folder, 'library.c'), code);
    execFileSync('cc', ['-shared', '-fPIC', path.join(folder, 'library.c'), '-o', file]);
    return file;
  };
  const another = library('int cylfuse(void) { return 0; }');
  starts(message(another), `${named(another)}Cannot find function 'cylfuse_abi_version'`);
  // An older one lacks functions, too.
  const older = library(`int cylfuse_abi_version(void) { return 1; } int cylfuse_version_number(void) { return 9; }
    const char *cylfuse_version_string(void) { return "0.0.9"; }`);
  assert.equal(message(older), `Error: the native library ${older} is version 0.0.9 with version 1 of the binary ` +
    'interface, this package needs at least 0.2.0 with version 1: install the library that belongs to the package');
  fs.rmSync(folder, { recursive: true });
});

test('the library is found below a path with blanks and more letters than ASCII has', () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'cylfuse größer -'));
  fs.symlinkSync(process.env.CYLFUSE_LIBRARY, path.join(folder, 'libcylfuse.so'));
  const { stdout } = run('console.log(cylfuse.version)', { CYLFUSE_LIBRARY: path.join(folder, 'libcylfuse.so') });
  assert.equal(stdout, `${cylfuse.version}\n`);
  fs.rmSync(folder, { recursive: true });
});

'use strict';

const { isMainThread } = require('node:worker_threads');
const native = require('./native.js');
const convert = require('./convert.js');
const { numberOf, nameOf, kindOf, enumerations } = require('./names.js');
const { check, statusError } = require('./errors.js');
const { progressCallback, logCallback, addListener, removeListener } = require('./callbacks.js');
const { fitOnPool } = require('./pool.js');

const { koffi, functions, toFill } = native;
const { status: STATUS } = enumerations;

// What the open fitters of this thread hold.
const open = new Set();

function destroy(held) {
  open.delete(held);
  removeListener(held.key);
  functions.cylfuse_fitter_destroy(held.handle);
}

// Frees the fitters that were forgotten, and those that a worker leaves behind; the main thread leaves none.
const registry = new FinalizationRegistry(destroy);
if (!isMainThread) process.on('exit', () => open.forEach(destroy));

/** The callbacks of a fitter: apart from it, because the native side must not see its methods. */
class Listener {
  progress = null;
  log = null;
  // What a callback threw, boxed because anything can be thrown; the call goes on throwing it.
  thrown = null;

  get hears() {
    return Boolean(this.progress || this.log);
  }

  hearProgress(progress) {
    if (this.thrown || !this.progress) return this.thrown ? 1 : 0;
    try {
      return this.progress(convert.progressFromC(progress)) === false ? 1 : 0;
    } catch (error) {
      this.thrown = { error };
      return 1;
    }
  }

  hearLog(level, message) {
    if (this.thrown || !this.log) return;
    try {
      this.log(nameOf('logLevel', level), message);
    } catch (error) {
      this.thrown = { error };
    }
  }
}

class Fitter {
  #held;
  #listener = new Listener();
  #running = false;
  #width = 0;
  #height = 0;

  constructor() {
    const out = [null];
    check(functions.cylfuse_fitter_create(native.ABI_VERSION, out));
    this.#held = { handle: out[0], key: addListener(this.#listener) };
    open.add(this.#held);
    registry.register(this, this.#held, this);
  }

  close() {
    if (this.#running) throw statusError(STATUS.BUSY);
    if (this.#held === null) return;
    registry.unregister(this);
    destroy(this.#held);
    this.#held = null;
  }

  reserve(points, segments = 0) {
    convert.size('points', points);
    convert.size('segments', segments);
    this.#call((handle) => functions.cylfuse_fitter_reserve(handle, points, segments));
  }

  clear() {
    this.#call((handle) => functions.cylfuse_fitter_clear(handle));
  }

  cancel() {
    const status = functions.cylfuse_fitter_cancel(this.#open());
    if (status !== STATUS.OK) throw statusError(status);
  }

  setOptions(options) {
    const c = convert.optionsToC(options);
    this.#call((handle) => functions.cylfuse_fitter_set_options(handle, c));
  }

  getOptions() {
    const c = this.#filled(native.Options, functions.cylfuse_fitter_get_options);
    return convert.optionsFromC(c);
  }

  setIntrinsics(intrinsics) {
    const c = convert.intrinsicsToC(intrinsics);
    this.#call((handle) => functions.cylfuse_fitter_set_intrinsics(handle, c));
    [this.#width, this.#height] = [c.width, c.height];
  }

  setStartModel(model) {
    const c = convert.optionalCylinder(model);
    this.#call((handle) => functions.cylfuse_fitter_set_start_model(handle, c));
  }

  setProgress(callback) {
    checkCallback('progress', callback);
    const heard = callback && progressCallback;
    this.#call((handle) => functions.cylfuse_fitter_set_progress(handle, heard, this.#held.key));
    this.#listener.progress = callback;
  }

  setLog(maxLevel, callback) {
    const level = numberOf('logLevel', 'maxLevel', maxLevel);
    checkCallback('log', callback);
    const heard = callback && logCallback;
    this.#call((handle) => functions.cylfuse_fitter_set_log(handle, level, heard, this.#held.key));
    this.#listener.log = callback;
  }

  pushPoints(points, mask = null) {
    const { view } = convert.pointsToC(points);
    const selected = convert.maskToC(mask);
    this.#call((handle) => functions.cylfuse_fitter_push_points(handle, view, selected));
  }

  pushDepth(depth, mask = null) {
    const view = convert.depthToC(depth);
    const selected = convert.maskToC(mask);
    this.#call((handle) => functions.cylfuse_fitter_push_depth(handle, view, selected));
  }

  pushImage(image) {
    const view = convert.imageToC(image);
    this.#call((handle) => functions.cylfuse_fitter_push_image(handle, view));
  }

  pushEdges(edges) {
    const view = convert.segmentsToC(edges);
    this.#call((handle) => functions.cylfuse_fitter_push_edges(handle, view));
  }

  counts() {
    return convert.countsFromC(this.#filled(native.Counts, functions.cylfuse_fitter_counts));
  }

  async fit() {
    const handle = this.#start();
    try {
      const { status, result } = await fitOnPool(handle, this.#listener.hears);
      this.#check(status);
      return convert.resultFromC(result);
    } finally {
      this.#running = false;
    }
  }

  fitSync() {
    return convert.resultFromC(this.#filled(native.Result, functions.cylfuse_fitter_fit));
  }

  evaluate(model) {
    const c = convert.cylinderToC('model', model);
    const evaluate = (handle, result) => functions.cylfuse_fitter_evaluate(handle, c, result);
    return convert.resultFromC(this.#filled(native.Result, evaluate));
  }

  result() {
    return convert.resultFromC(this.#filled(native.Result, functions.cylfuse_fitter_get_result));
  }

  residuals(kind, model = null) {
    const number = numberOf('residualKind', 'kind', kind);
    const c = convert.optionalCylinder(model);
    const counts = this.counts();
    const capacity = kind === 'points' ? counts.pointsUsed : 2 * counts.segmentsGiven;
    const list = (handle, out, length, count) =>
      functions.cylfuse_fitter_residuals(handle, c, number, out, length, count);
    const { items, count } = this.#list(capacity, (length) => new Float64Array(length), list);
    return items.subarray(0, count);
  }

  limbSamples() {
    const size = koffi.sizeof(native.LimbSample);
    // Far more than an image gives: one of 640 x 480 pixels some 16.
    const make = (length) => Buffer.alloc(length * size);
    const { items, count } = this.#list(1024, make, functions.cylfuse_fitter_limb_samples);
    return Array.from({ length: count }, (_, index) =>
      convert.limbSampleFromC(koffi.decode(items, index * size, native.LimbSample)));
  }

  diagnose(model = null) {
    const c = convert.optionalCylinder(model);
    const diagnose = (handle, out) => functions.cylfuse_fitter_diagnose(handle, c, out);
    return convert.diagnosisFromC(this.#filled(native.Diagnosis, diagnose));
  }

  complete(options = {}) {
    convert.object('options', options, ['model', 'mask', 'layout', 'type']);
    const { model = null, mask = null, layout = 'packed', type = Float64Array } = options;
    const scalar = typeCode('type', type, convert.SCALARS);
    const c = convert.optionalCylinder(model);
    const selected = convert.maskToC(mask);
    const arrangement = numberOf('layout', 'layout', layout);
    const bound = [0];
    this.#call((handle) => functions.cylfuse_fitter_complete_bound(handle, selected, arrangement, bound));
    const points = new type(3 * Number(bound[0]));
    const out = native.initialised(functions.cylfuse_points_out_init, native.PointsOut);
    Object.assign(out, { scalar, data: points, capacity: bound[0], layout: arrangement });
    const completion = convert.completionFromC(
      this.#filled(native.Completion, (handle, c2) =>
        functions.cylfuse_fitter_complete(handle, c, selected, out, c2)),
    );
    return { points: layout === 'packed' ? points.subarray(0, 3 * completion.count) : points, completion };
  }

  completeDepth(options = {}) {
    convert.object('options', options, ['model', 'mask', 'scale', 'type']);
    const { model = null, mask = null, scale = 1, type = Float32Array } = options;
    const format = typeCode('type', type, convert.DEPTH_FORMATS);
    const c = convert.optionalCylinder(model);
    const selected = convert.maskToC(mask);
    convert.number('scale', scale);
    const [width, height] = [this.#width, this.#height];
    const data = new type(width * height);
    const out = native.initialised(functions.cylfuse_depth_out_init, native.DepthOut);
    Object.assign(out, { format, data, width, height, scale });
    const completion = convert.completionFromC(
      this.#filled(native.Completion, (handle, c2) =>
        functions.cylfuse_fitter_complete_depth(handle, c, selected, out, c2)),
    );
    return { depth: { data, width, height, scale }, completion };
  }

  extent(options = {}) {
    convert.object('options', options, ['model', 'mask']);
    const c = convert.optionalCylinder(options.model);
    const selected = convert.maskToC(options.mask);
    const extent = (handle, out) => functions.cylfuse_fitter_extent(handle, c, selected, out);
    return convert.extentFromC(this.#filled(native.Extent, extent));
  }

  selectEdges(edges, options = {}) {
    convert.object('options', options, ['model', 'reach']);
    const { model = null, reach = 0 } = options;
    const view = convert.segmentsToC(edges);
    const c = convert.optionalCylinder(model);
    convert.number('reach', reach);
    const limbs = new Uint8Array(view.count);
    this.#call((handle) => functions.cylfuse_fitter_select_edges(handle, c, view, reach, limbs, view.count));
    return limbs;
  }

  #open() {
    if (this.#held === null) throw new Error('the fitter is closed: make a new one');
    return this.#held.handle;
  }

  /**
   * Begins the one call that may run. The library would answer BUSY by itself, but its message belongs to the call that
   * runs, and this thread must not read it meanwhile.
   */
  #start() {
    const handle = this.#open();
    if (this.#running) throw statusError(STATUS.BUSY);
    this.#running = true;
    return handle;
  }

  #check(status) {
    const { thrown } = this.#listener;
    this.#listener.thrown = null;
    if (thrown) throw thrown.error;
    check(status, this.#held.handle);
  }

  #call(run) {
    const handle = this.#start();
    try {
      this.#check(run(handle));
    } finally {
      this.#running = false;
    }
  }

  /** Calls what fills a struct. */
  #filled(type, run) {
    const struct = toFill(type);
    this.#call((handle) => run(handle, struct));
    return struct;
  }

  /**
   * Lists into an array that is made for a number of items. A `capacity` that is large enough saves asking for that
   * number, which fails for the library, and so would reach the log.
   */
  #list(capacity, make, list) {
    const count = [0];
    let items = make(capacity);
    this.#call((handle) => {
      const status = list(handle, items, capacity, count);
      if (status !== STATUS.BUFFER_TOO_SMALL) return status;
      items = make(Number(count[0]));
      return list(handle, items, count[0], count);
    });
    return { items, count: Number(count[0]) };
  }
}

// `using fitter = new Fitter()` where the language has it.
if (Symbol.dispose) Fitter.prototype[Symbol.dispose] = Fitter.prototype.close;

function checkCallback(what, callback) {
  if (callback === null || typeof callback === 'function') return;
  throw new TypeError(`${what} must be a function or null, not ${kindOf(callback)}`);
}

function typeCode(what, type, types) {
  const code = types.get(type);
  if (code !== undefined) return code;
  throw new TypeError(`${what} must be ${[...types.keys()].map((known) => known.name).join(' or ')}`);
}

module.exports = { Fitter };

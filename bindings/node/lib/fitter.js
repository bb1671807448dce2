'use strict';

const { koffi, structs, functions, initialised } = require('./native.js');
const convert = require('./convert.js');
const { numberOf, nameOf, kindOf, enumerations } = require('./names.js');
const { check, checkElsewhere, statusError } = require('./errors.js');
const { progressCallback, logCallback, addListener, removeListener } = require('./callbacks.js');
const handles = require('./handles.js');
const { inside } = require('./frame.js');
const { fitOnPool } = require('./pool.js');

const { status: STATUS } = enumerations;

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
  #listener = new Listener();
  #key = addListener(this.#listener);
  #held = handles.create('fitter', this);
  #running = false;
  // Asks a fit on the pool to stop until it has.
  #cancelling = null;
  // The sizes of the cameras of the views.
  #cameras = [[0, 0]];
  #selected = 0;

  constructor() {
    const key = this.#key;
    this.#held.release = () => removeListener(key);
  }

  close() {
    if (this.#running) throw statusError(STATUS.BUSY);
    if (this.#held === null) return;
    handles.close(this.#held, this);
    this.#held = null;
  }

  reserve(points, segments = 0) {
    convert.size('points', points);
    convert.size('segments', segments);
    this.#call((handle) => functions.cylfuse_fitter_reserve(handle, points, segments));
  }

  clear() {
    this.#call((handle) => functions.cylfuse_fitter_clear(handle));
    this.#selected = 0;
    this.#cameras.length = 1;
  }

  clearInput(...inputs) {
    const bits = inputs.reduce((sum, name) => sum | numberOf('input', 'input', name), 0);
    this.#call((handle) => functions.cylfuse_fitter_clear_input(handle, bits));
  }

  cancel() {
    const handle = this.#open();
    const cancel = () => functions.cylfuse_fitter_cancel(handle);
    // A fit on the pool may not have begun, and only one that has can be cancelled.
    if (this.#running) this.#cancelling ??= setInterval(cancel, 1);
    const status = cancel();
    if (status !== STATUS.OK) throw statusError(status);
  }

  setOptions(options) {
    const c = convert.optionsToC(options);
    this.#call((handle) => functions.cylfuse_fitter_set_options(handle, c));
  }

  getOptions() {
    return convert.optionsFromC(this.#filled('options', functions.cylfuse_fitter_get_options));
  }

  selectView(index) {
    convert.size('index', index);
    this.#call((handle) => functions.cylfuse_fitter_select_view(handle, index));
    this.#selected = index;
    this.#cameras[index] ??= [0, 0];
  }

  viewCount() {
    const count = [0];
    this.#call((handle) => functions.cylfuse_fitter_view_count(handle, count));
    return Number(count[0]);
  }

  setPose(pose) {
    const [rotation, translation] = convert.poseToC('pose', pose);
    this.#call((handle) => functions.cylfuse_fitter_set_pose(handle, rotation, translation));
  }

  setIntrinsics(intrinsics) {
    const c = convert.intrinsicsToC(intrinsics);
    this.#call((handle) => functions.cylfuse_fitter_set_intrinsics(handle, c));
    this.#cameras[this.#selected] = [c.width, c.height];
  }

  setDepthCamera(camera) {
    const [c, rotation, translation] = convert.depthCameraToC(camera);
    this.#call((handle) => functions.cylfuse_fitter_set_depth_camera(handle, c, rotation, translation));
  }

  useFrame(frame, mask = null) {
    const { handle: used, size } = inside(frame);
    const selected = convert.maskToC(mask);
    this.#call((handle) => functions.cylfuse_fitter_use_frame(handle, used, selected));
    this.#cameras[this.#selected] = size;
  }

  setStartModel(model) {
    const c = convert.optionalCylinder(model);
    this.#call((handle) => functions.cylfuse_fitter_set_start_model(handle, c));
  }

  setProgress(callback) {
    checkCallback('progress', callback);
    const heard = callback && progressCallback;
    this.#call((handle) => functions.cylfuse_fitter_set_progress(handle, heard, this.#key));
    this.#listener.progress = callback;
  }

  setLog(maxLevel, callback) {
    const level = numberOf('logLevel', 'maxLevel', maxLevel);
    checkCallback('log', callback);
    const heard = callback && logCallback;
    this.#call((handle) => functions.cylfuse_fitter_set_log(handle, level, heard, this.#key));
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
    return convert.countsFromC(this.#filled('counts', functions.cylfuse_fitter_counts));
  }

  async fit() {
    const handle = this.#start();
    try {
      const { status, result, estimate } =
        await fitOnPool(handle, this.#listener.hears, () => this.#cancelling !== null);
      this.#throw();
      if (result === undefined) throw statusError(status);
      checkElsewhere(status, handle);
      return convert.resultFromC(result, estimate);
    } finally {
      this.#end();
    }
  }

  fitSync() {
    return this.#result(functions.cylfuse_fitter_fit);
  }

  evaluate(model) {
    const c = convert.cylinderToC('model', model);
    return this.#result((handle, ...out) => functions.cylfuse_fitter_evaluate(handle, c, ...out));
  }

  result() {
    return this.#result((handle, result, estimate) =>
      functions.cylfuse_fitter_get_result(handle, result) || functions.cylfuse_fitter_get_cylinder(handle, estimate));
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

  pointWeights() {
    const make = (length) => ({ weights: new Float64Array(length), inliers: new Uint8Array(length) });
    const list = (handle, { weights, inliers }, length, count) =>
      functions.cylfuse_fitter_point_weights(handle, weights, inliers, length, count);
    const { items: { weights, inliers }, count } = this.#list(this.counts().pointsUsed, make, list);
    return { weights: weights.subarray(0, count), inliers: inliers.subarray(0, count) };
  }

  limbs() {
    return this.#structs('limb', 2 * this.viewCount(), functions.cylfuse_fitter_limbs).map(convert.limbFromC);
  }

  limbSamples() {
    return this.#structs('limb_sample', MANY_SAMPLES, functions.cylfuse_fitter_limb_samples)
      .map(convert.limbSampleFromC);
  }

  endSamples(options = {}) {
    const { c, selected } = regionToC(options);
    const list = (handle, ...out) => functions.cylfuse_fitter_end_samples(handle, c, selected, ...out);
    return this.#structs('end_sample', MANY_SAMPLES, list).map(convert.endSampleFromC);
  }

  diagnose(model = null) {
    const c = convert.optionalCylinder(model);
    const diagnose = (handle, out) => functions.cylfuse_fitter_diagnose(handle, c, out);
    return convert.diagnosisFromC(this.#filled('cylinder_diagnosis', diagnose));
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
    const out = initialised('points_out');
    Object.assign(out, { scalar, data: points, capacity: bound[0] });
    const completion = convert.completionFromC(
      this.#filled('completion', (handle, c2) =>
        functions.cylfuse_fitter_complete(handle, c, selected, arrangement, out, c2)),
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
    const [width, height] = this.#cameras[this.#selected];
    const data = new type(width * height);
    const out = initialised('depth_out');
    Object.assign(out, { format, data, width, height, scale });
    const completion = convert.completionFromC(
      this.#filled('completion', (handle, c2) =>
        functions.cylfuse_fitter_complete_depth(handle, c, selected, out, c2)),
    );
    return { depth: { data, width, height, scale }, completion };
  }

  extent(options = {}) {
    const { c, selected } = regionToC(options);
    const extent = (handle, out) => functions.cylfuse_fitter_extent(handle, c, selected, out);
    return convert.extentFromC(this.#filled('extent', extent));
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
   * Begins the one call that may run. The library would answer BUSY by itself, but not before a fit on the pool has
   * begun.
   */
  #start() {
    const handle = this.#open();
    if (this.#running) throw statusError(STATUS.BUSY);
    this.#running = true;
    return handle;
  }

  #end() {
    this.#running = false;
    clearInterval(this.#cancelling);
    this.#cancelling = null;
  }

  /** Throws what a callback threw during the call. */
  #throw() {
    const { thrown } = this.#listener;
    this.#listener.thrown = null;
    if (thrown) throw thrown.error;
  }

  #call(run) {
    const handle = this.#start();
    try {
      const status = run(handle);
      this.#throw();
      check(status);
    } finally {
      this.#end();
    }
  }

  /** Calls what fills a struct. */
  #filled(name, run) {
    const struct = initialised(name);
    this.#call((handle) => run(handle, struct));
    return struct;
  }

  /** Calls what fills a result and an estimate. */
  #result(run) {
    const [result, estimate] = [initialised('result'), initialised('cylinder_estimate')];
    this.#call((handle) => run(handle, result, estimate));
    return convert.resultFromC(result, estimate);
  }

  /** Lists structs. */
  #structs(name, capacity, list) {
    const size = koffi.sizeof(structs[name]);
    const make = (length) => Buffer.alloc(length * size);
    const run = (handle, out, length, count) => list(handle, out, size, length, count);
    const { items, count } = this.#list(capacity, make, run);
    return Array.from({ length: count }, (_, index) => koffi.decode(items, index * size, structs[name]));
  }

  /**
   * Lists into what is made for a number of items. A `capacity` that is large enough saves asking for that number.
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

// Far more than an image gives: one of 640 x 480 pixels some 16.
const MANY_SAMPLES = 1024;

/** The model and the mask of what looks at a region. */
function regionToC(options) {
  convert.object('options', options, ['model', 'mask']);
  return { c: convert.optionalCylinder(options.model), selected: convert.maskToC(options.mask) };
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

'use strict';

const { functions, initialised } = require('./native.js');
const convert = require('./convert.js');
const { enumerations, kindOf, nameOf, numberOf } = require('./names.js');
const { progressCallback, logCallback } = require('./callbacks.js');
const { Calls, answered, checkCallback } = require('./calls.js');
const { inside } = require('./frame.js');
const { CylfuseError, statusError } = require('./errors.js');
const { fitOnPool, fitAllOnPool } = require('./pool.js');

const { status: STATUS } = enumerations;

// What `made` hands to the constructor.
let making = null;

class Fitter {
  #calls = new Calls('fitter', convert.progressFromC, making?.create);
  // The sizes of the cameras of the views.
  #cameras = [making?.size ?? [0, 0]];
  #selected = 0;

  /** Fits many fitters, several at once. */
  static async fitAll(fitters, options = {}) {
    convert.object('options', options, ['threads', 'progress']);
    const { threads = 0, progress = null } = options;
    convert.size('threads', threads);
    checkCallback('progress', progress);
    const every = Array.from(fitters);
    checkFitters(every);
    const all = every.map((fitter) => fitter.#calls);
    let thrown = null;
    let busy = [];
    const statusOf = (index, status) => (busy[index] ? STATUS.BUSY : status);
    const ended = progress && ((index, status) => {
      try {
        return answered('progress', progress(index, nameOf('status', statusOf(index, status)))) === false ? 1 : 0;
      } catch (error) {
        thrown = { error };
        return 1;
      }
    });
    const { status, statuses } = await Calls.onAll(all, (handles) => {
      busy = handles.map((handle) => handle === null);
      return fitAllOnPool(handles, threads, ended);
    });
    if (thrown) throw thrown.error;
    if (status !== STATUS.OK && status !== STATUS.CANCELLED) throw statusError(status);
    return all.map((calls, index) => calls.failure(statusOf(index, statuses[index])) ?? every[index].result());
  }

  /** A fitter that is created by another function, with the size of its camera. */
  static made(create, size) {
    making = { create, size };
    try {
      return new Fitter();
    } finally {
      making = null;
    }
  }

  close() {
    this.#calls.close();
  }

  clone() {
    let fitter;
    this.#calls.run((handle) => {
      fitter = made((_, out) => functions.cylfuse_fitter_clone(handle, out), [0, 0]);
      return 0;
    });
    fitter.#cameras = this.#cameras.slice();
    fitter.#selected = this.#selected;
    return fitter;
  }

  reserve(points, segments = 0) {
    convert.size('points', points);
    convert.size('segments', segments);
    this.#calls.run((handle) => functions.cylfuse_fitter_reserve(handle, points, segments));
  }

  clear() {
    this.#calls.run((handle) => functions.cylfuse_fitter_clear(handle));
    this.#selected = 0;
    this.#cameras.length = 1;
  }

  clearInput(...inputs) {
    const bits = inputs.reduce((sum, name) => sum | numberOf('input', 'input', name), 0);
    this.#calls.run((handle) => functions.cylfuse_fitter_clear_input(handle, bits));
  }

  cancel() {
    this.#calls.cancel();
  }

  setOptions(options) {
    const c = convert.optionsToC(options);
    this.#calls.run((handle) => functions.cylfuse_fitter_set_options(handle, c));
  }

  getOptions() {
    return convert.optionsFromC(this.#calls.filled('options', functions.cylfuse_fitter_get_options));
  }

  selectView(index) {
    convert.size('index', index);
    this.#calls.run((handle) => functions.cylfuse_fitter_select_view(handle, index));
    this.#selected = index;
    this.#cameras[index] ??= [0, 0];
  }

  viewCount() {
    const count = [0];
    this.#calls.run((handle) => functions.cylfuse_fitter_view_count(handle, count));
    return Number(count[0]);
  }

  setPose(pose) {
    const [rotation, translation] = convert.poseToC('pose', pose);
    this.#calls.run((handle) => functions.cylfuse_fitter_set_pose(handle, rotation, translation));
  }

  setIntrinsics(intrinsics) {
    const c = convert.intrinsicsToC(intrinsics);
    this.#calls.run((handle) => functions.cylfuse_fitter_set_intrinsics(handle, c));
    this.#cameras[this.#selected] = [c.width, c.height];
  }

  getIntrinsics() {
    return convert.intrinsicsFromC(this.#calls.filled('intrinsics', functions.cylfuse_fitter_get_intrinsics));
  }

  setDepthCamera(camera) {
    const [c, rotation, translation] = convert.depthCameraToC(camera);
    this.#calls.run((handle) => functions.cylfuse_fitter_set_depth_camera(handle, c, rotation, translation));
  }

  useFrame(frame, mask = null) {
    const { handle: used, size } = inside(frame);
    const selected = convert.maskToC(mask);
    this.#calls.run((handle) => functions.cylfuse_fitter_use_frame(handle, used, selected));
    this.#cameras[this.#selected] = size;
  }

  setStartModel(model) {
    const c = convert.optionalCylinder(model);
    this.#calls.run((handle) => functions.cylfuse_fitter_set_start_model(handle, c));
  }

  setProgress(callback) {
    checkCallback('progress', callback);
    const registered = callback && progressCallback;
    this.#calls.run((handle) => functions.cylfuse_fitter_set_progress(handle, registered, this.#calls.key));
    this.#calls.listener.progress = callback;
  }

  setLog(maxLevel, callback) {
    const level = numberOf('logLevel', 'maxLevel', maxLevel);
    checkCallback('log', callback);
    const registered = callback && logCallback;
    this.#calls.run((handle) => functions.cylfuse_fitter_set_log(handle, level, registered, this.#calls.key));
    this.#calls.listener.log = callback;
  }

  pushPoints(points, mask = null) {
    const { view } = convert.pointsToC(points);
    const selected = convert.maskToC(mask);
    this.#calls.run((handle) => functions.cylfuse_fitter_push_points(handle, view, selected));
  }

  pushDepth(depth, mask = null) {
    const view = convert.depthToC(depth);
    const selected = convert.maskToC(mask);
    this.#calls.run((handle) => functions.cylfuse_fitter_push_depth(handle, view, selected));
  }

  pushImage(image) {
    const view = convert.imageToC(image);
    this.#calls.run((handle) => functions.cylfuse_fitter_push_image(handle, view));
  }

  pushEdges(edges) {
    const view = convert.segmentsToC(edges);
    this.#calls.run((handle) => functions.cylfuse_fitter_push_edges(handle, view));
  }

  counts() {
    return convert.countsFromC(this.#calls.filled('counts', functions.cylfuse_fitter_counts));
  }

  fit() {
    return this.#calls.runOnPool(fitOnPool, (_, { result, estimate }) => convert.resultFromC(result, estimate));
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
    const { items, count } = this.#calls.list(capacity, (length) => new Float64Array(length), list);
    return items.subarray(0, count);
  }

  pointWeights() {
    const make = (length) => ({ weights: new Float64Array(length), inliers: new Uint8Array(length) });
    const list = (handle, { weights, inliers }, length, count) =>
      functions.cylfuse_fitter_point_weights(handle, weights, inliers, length, count);
    const { items: { weights, inliers }, count } = this.#calls.list(this.counts().pointsUsed, make, list);
    return { weights: weights.subarray(0, count), inliers: inliers.subarray(0, count) };
  }

  pointParts(model = null) {
    const c = convert.optionalCylinder(model);
    const list = (handle, out, length, count) => functions.cylfuse_fitter_point_parts(handle, c, out, length, count);
    const { items, count } = this.#calls.list(this.counts().pointsUsed, (length) => new Uint8Array(length), list);
    return Array.from(items.subarray(0, count), (part) => nameOf('part', part));
  }

  limbs() {
    return this.#calls.structs('limb', 2 * this.viewCount(), functions.cylfuse_fitter_limbs).map(convert.limbFromC);
  }

  limbSamples() {
    return this.#calls.structs('limb_sample', MANY_SAMPLES, functions.cylfuse_fitter_limb_samples)
      .map(convert.limbSampleFromC);
  }

  endSamples(options = {}) {
    const { c, selected } = regionToC(options);
    const list = (handle, ...out) => functions.cylfuse_fitter_end_samples(handle, c, selected, ...out);
    return this.#calls.structs('end_sample', MANY_SAMPLES, list).map(convert.endSampleFromC);
  }

  diagnose(model = null) {
    const c = convert.optionalCylinder(model);
    const diagnose = (handle, out) => functions.cylfuse_fitter_diagnose(handle, c, out);
    return convert.diagnosisFromC(this.#calls.filled('cylinder_diagnosis', diagnose));
  }

  complete(options = {}) {
    convert.object('options', options, ['model', 'mask', 'layout', 'type']);
    const { model = null, mask = null, layout = 'packed', type = Float64Array } = options;
    const scalar = typeCode('type', type, convert.SCALARS);
    const c = convert.optionalCylinder(model);
    const selected = convert.maskToC(mask);
    const arrangement = numberOf('layout', 'layout', layout);
    const bound = [0];
    this.#calls.run((handle) => functions.cylfuse_fitter_complete_bound(handle, selected, arrangement, bound));
    const points = new type(3 * Number(bound[0]));
    const out = initialised('points_out');
    Object.assign(out, { scalar, data: points, capacity: bound[0] });
    const completion = convert.completionFromC(
      this.#calls.filled('completion', (handle, c2) =>
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
      this.#calls.filled('completion', (handle, c2) =>
        functions.cylfuse_fitter_complete_depth(handle, c, selected, out, c2)),
    );
    return { depth: { data, width, height, scale }, completion };
  }

  extent(options = {}) {
    const { c, selected } = regionToC(options);
    const extent = (handle, out) => functions.cylfuse_fitter_extent(handle, c, selected, out);
    return convert.extentFromC(this.#calls.filled('extent', extent));
  }

  selectEdges(edges, options = {}) {
    convert.object('options', options, ['model', 'reach']);
    const { model = null, reach = 0 } = options;
    const view = convert.segmentsToC(edges);
    const c = convert.optionalCylinder(model);
    convert.number('reach', reach);
    const limbs = new Uint8Array(view.count);
    this.#calls.run((handle) => functions.cylfuse_fitter_select_edges(handle, c, view, reach, limbs, view.count));
    return limbs;
  }

  /** Calls what fills a result and an estimate. */
  #result(run) {
    const [result, estimate] = [initialised('result'), initialised('cylinder_estimate')];
    this.#calls.run((handle) => run(handle, result, estimate));
    return convert.resultFromC(result, estimate);
  }
}

/** Each must be a fitter, and there once: the library does not see those that are busy. */
function checkFitters(every) {
  const places = new Map();
  every.forEach((fitter, index) => {
    if (!(fitter instanceof Fitter)) throw new TypeError(`fitters[${index}] must be a Fitter, not ${kindOf(fitter)}`);
    if (places.has(fitter)) {
      const text = `fitters[${index}] is the same as fitters[${places.get(fitter)}]; it must be another fitter`;
      throw new CylfuseError(STATUS.INVALID_ARGUMENT, text);
    }
    places.set(fitter, index);
  });
}

// Far more than an image gives: one of 640 x 480 pixels some 16.
const MANY_SAMPLES = 1024;

/** The model and the mask of what looks at a region. */
function regionToC(options) {
  convert.object('options', options, ['model', 'mask']);
  return { c: convert.optionalCylinder(options.model), selected: convert.maskToC(options.mask) };
}

// For this package only.
const { made, fitAll } = Fitter;
delete Fitter.made;
delete Fitter.fitAll;

// `using fitter = new Fitter()` where the language has it.
if (Symbol.dispose) Fitter.prototype[Symbol.dispose] = Fitter.prototype.close;

function typeCode(what, type, types) {
  const code = types.get(type);
  if (code !== undefined) return code;
  throw new TypeError(`${what} must be ${[...types.keys()].map((known) => known.name).join(' or ')}`);
}

module.exports = { Fitter, made, fitAll };

'use strict';

const { koffi, structs, functions, initialised } = require('./native.js');
const convert = require('./convert.js');
const { enumerations } = require('./names.js');
const { detectionCallback } = require('./callbacks.js');
const { Calls, checkCallback } = require('./calls.js');
const { CylfuseError, check } = require('./errors.js');
const { made } = require('./fitter.js');
const { inside, during } = require('./frame.js');
const { detectOnPool, detectPointsOnPool } = require('./pool.js');

const { status: STATUS } = enumerations;

class Detector {
  #calls = new Calls('detector', convert.detectionProgressFromC);
  // Of the last scene: columns and rows of the labels, and the size of the camera.
  #size = [0, 0];
  #camera = [0, 0];

  close() {
    this.#calls.close();
  }

  cancel() {
    this.#calls.cancel();
  }

  setOptions(options) {
    const c = convert.detectorOptionsToC(options);
    this.#calls.run((handle) => functions.cylfuse_detector_set_options(handle, c));
  }

  getOptions() {
    return convert.detectorOptionsFromC(
      this.#calls.filled('detector_options', functions.cylfuse_detector_get_options),
    );
  }

  setFitOptions(options) {
    const c = convert.optionsToC(options);
    this.#calls.run((handle) => functions.cylfuse_detector_set_fit_options(handle, c));
  }

  getFitOptions() {
    return convert.optionsFromC(this.#calls.filled('options', functions.cylfuse_detector_get_fit_options));
  }

  setProgress(callback) {
    checkCallback('progress', callback);
    const registered = callback && detectionCallback;
    this.#calls.run((handle) => functions.cylfuse_detector_set_progress(handle, registered, this.#calls.key));
    this.#calls.listener.progress = callback;
  }

  async detect(frame) {
    const { handle: used, size } = inside(frame);
    const search = async (handle, ...rest) => ({ status: await detectOnPool(handle, used, ...rest) });
    return during(frame, () => this.#calls.runOnPool(search, (handle) => this.#found(handle, size, size)));
  }

  detectSync(frame) {
    const { handle: used, size } = inside(frame);
    return this.#search((handle) => functions.cylfuse_detector_detect(handle, used), size, size);
  }

  async detectPoints(points) {
    const { view, size } = convert.pointsToC(points);
    const search = async (handle, ...rest) => ({ status: await detectPointsOnPool(handle, view, ...rest) });
    return this.#calls.runOnPool(search, (handle) => this.#found(handle, size, [0, 0]));
  }

  detectPointsSync(points) {
    const { view, size } = convert.pointsToC(points);
    return this.#search((handle) => functions.cylfuse_detector_detect_points(handle, view), size, [0, 0]);
  }

  detections() {
    let found;
    this.#calls.run((handle) => {
      found = read(handle);
      return STATUS.OK;
    });
    return found;
  }

  isComplete() {
    const complete = [0];
    this.#calls.run((handle) => functions.cylfuse_detector_is_complete(handle, complete));
    return complete[0] !== 0;
  }

  depthMoved() {
    const [columns, rows] = [[0], [0]];
    this.#calls.run((handle) => functions.cylfuse_detector_depth_moved(handle, columns, rows));
    return [columns[0], rows[0]];
  }

  labels() {
    const { items: data } = this.#numbers(Uint16Array, functions.cylfuse_detector_labels);
    const [width, height] = this.#size;
    return { data, width, height };
  }

  indices(index) {
    convert.size('index', index);
    const list = (handle, ...out) => functions.cylfuse_detector_indices(handle, index, ...out);
    return this.#numbers(Uint32Array, list).items;
  }

  fitter(index) {
    convert.size('index', index);
    let fitter;
    this.#calls.run((handle) => {
      fitter = made((_, out) => functions.cylfuse_detector_make_fitter(handle, index, out), this.#camera);
      return STATUS.OK;
    });
    return fitter;
  }

  /** Lists numbers, whose count is asked first. */
  #numbers(type, list) {
    return this.#calls.list(0, (length) => new type(length), list);
  }

  #search(search, size, camera) {
    let found;
    this.#calls.run((handle) => {
      const status = search(handle);
      if (status === STATUS.OK) found = this.#found(handle, size, camera);
      return status;
    });
    return found;
  }

  /** The scene that a search has found. */
  #found(handle, size, camera) {
    [this.#size, this.#camera] = [size, camera];
    return read(handle);
  }
}

/** All cylinders of the scene of a handle. */
function read(handle) {
  const count = [0];
  check(functions.cylfuse_detector_count(handle, count));
  const [length, size] = [Number(count[0]), koffi.sizeof(structs.detection)];
  const items = Buffer.alloc(length * size);
  check(functions.cylfuse_detector_detections(handle, items, size, length, count));
  return Array.from({ length }, (_, index) => {
    const { score, pixels } = koffi.decode(items, index * size, structs.detection);
    const [result, estimate] = [initialised('result'), initialised('cylinder_estimate')];
    check(functions.cylfuse_detector_get_result(handle, index, result));
    check(functions.cylfuse_detector_get_cylinder(handle, index, estimate));
    const extent = initialised('extent');
    const seen = functions.cylfuse_detector_get_extent(handle, index, extent);
    return {
      score, pixels: Number(pixels), result: convert.resultFromC(result, estimate),
      extent: seen === STATUS.OK ? convert.extentFromC(extent) : null,
      extentError: seen === STATUS.OK ? null : new CylfuseError(seen, functions.cylfuse_detector_last_error(handle)),
    };
  });
}

if (Symbol.dispose) Detector.prototype[Symbol.dispose] = Detector.prototype.close;

module.exports = { Detector };

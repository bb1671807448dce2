'use strict';
// One native function for all callbacks of a kind of this thread. They find their fitter or detector by a number through
// a weak reference, so that a callback that refers to its owner does not keep it alive.

const native = require('./native.js');

const { koffi } = native;
const listeners = new Map();
let last = 0n;

const registered = (struct) => koffi.register(
  (progress, key) => listeners.get(BigInt(key))?.deref()?.onProgress(koffi.decode(progress, struct)) ?? 0,
  native.ProgressCallback,
);

const progressCallback = registered(native.structs.progress);
const detectionCallback = registered(native.structs.detection_progress);

const logCallback = koffi.register(
  (level, message, key) => listeners.get(BigInt(key))?.deref()?.onLog(level, message),
  native.LogCallback,
);

/** A key for the user_data of a listener with onProgress and onLog, which must never throw. */
function addListener(listener) {
  last += 1n;
  listeners.set(last, new WeakRef(listener));
  return last;
}

const removeListener = (key) => listeners.delete(key);

module.exports = { progressCallback, detectionCallback, logCallback, addListener, removeListener };

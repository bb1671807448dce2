'use strict';
// The enumerations of the C interface as strings.

const enumerations = {
  status: {
    OK: 0, INVALID_ARGUMENT: -1, NULL_POINTER: -2, STRUCT_SIZE: -3, ABI_MISMATCH: -4, BAD_STATE: -5, BUSY: -6,
    BUFFER_TOO_SMALL: -7, OUT_OF_MEMORY: -8, UNSUPPORTED: -9, SIZE_MISMATCH: -10, INVALID_INTRINSICS: -11,
    TOO_FEW_POINTS: -20, PLANAR_POINTS: -21, COLLINEAR_POINTS: -22, EMPTY_MASK: -23, NO_DEPTH: -24, NO_START: -25,
    EDGE_GEOMETRY: -26, NUMERICAL: -27, CANCELLED: -40, PANIC: -99,
  },
  method: { fused: 0, points: 1, ransac: 2, eberly: 3 },
  objective: { robust: 0, paper: 1 },
  start: { auto: 0, limbs: 1, moments: 2, ransac: 3, model: 4, last: 5 },
  nearWall: { auto: 0, on: 1, off: 2 },
  chart: { auto: 0, local: 1, orthonormal: 2 },
  edgeUse: { refine: 0, 'as-given': 1 },
  extentRule: { auto: 0, extremes: 1, located: 2 },
  distortionModel: { none: 0, 'brown-conrady': 1, 'kannala-brandt': 2 },
  termination: { none: 0, cost: 1, stalled: 2, 'max-iterations': 3, 'radius-ran-away': 4, gradient: 5, step: 6 },
  flag: {
    'edges-ignored': 1, 'segments-unusable': 2, 'edges-cross': 4, 'edges-coincide': 8, 'edges-behind': 16,
    'scale-held': 32, 'weak-radius': 64, 'resolution-lost': 128, 'not-converged': 256, 'hidden-wall': 512,
    'camera-inside': 1024, 'points-not-finite': 2048, 'points-and-limbs-disagree': 4096, 'radius-at-limit': 8192,
    'axis-at-limit': 16384, 'uncertainty-unknown': 32768, 'depth-shifted': 65536,
    'mask-ends-with-depth': 131072, 'poor-fit': 262144, 'body-tapers': 524288, 'mask-disagrees': 1048576,
  },
  residualKind: { points: 1, edges: 2 },
  layout: { packed: 0, organised: 1 },
  input: { points: 1, depth: 2, edges: 4, image: 8 },
  // Of bytes; grey stands for the format of the type.
  imageFormat: { grey: 1, rgb: 4, bgr: 5, rgba: 6, bgra: 7 },
  limbStatus: {
    located: 0, 'not-searched': 1, 'no-limbs': 2, 'too-short': 3, 'no-edge': 4, 'out-of-reach': 5, uncertain: 6,
    patchy: 7, 'same-line': 8,
  },
  conformity: { undecided: 0, conforming: 1, 'not-conforming': 2 },
  part: { body: 1, cap: 2, 'inner-wall': 3, other: 4, behind: 5 },
  endSource: { extreme: 0, mask: 1, image: 2, border: 3, points: 4 },
  endState: { unknown: 0, seen: 1, cut: 2, hidden: 3 },
  phase: { start: 1, solve: 2 },
  imageUse: { auto: 0, ignore: 1 },
  detectionPhase: { search: 1, fit: 2 },
  logLevel: { off: 0, error: 1, warning: 2, info: 3, debug: 4 },
};

const names = {};
for (const [kind, values] of Object.entries(enumerations)) {
  names[kind] = new Map(Object.entries(values).map(([name, value]) => [value, name]));
}

/** What a value is, for messages: 'null', 'string', 'Array', 'Int32Array'. */
function kindOf(value) {
  if (value === null || typeof value !== 'object') return value === null ? 'null' : typeof value;
  return Object.prototype.toString.call(value).slice('[object '.length, -1);
}

/** The number of a name; a TypeError that lists the names for anything else. */
function numberOf(kind, what, name) {
  const values = enumerations[kind];
  if (typeof name === 'string' && Object.hasOwn(values, name)) return values[name];
  const given = ['string', 'number'].includes(typeof name) ? JSON.stringify(name) : kindOf(name);
  throw new TypeError(`${what} is ${given}; it must be one of "${Object.keys(values).join('", "')}"`);
}

/** The name of a number; the number as text when a later library has made it up. */
const nameOf = (kind, number) => names[kind].get(number) ?? String(number);

/** The names of the bits that are set. */
const flagsOf = (bits) => Array.from({ length: 32 }, (_, i) => 2 ** i).filter((bit) => bits & bit)
  .map((bit) => nameOf('flag', bit));

module.exports = { enumerations, kindOf, numberOf, nameOf, flagsOf };

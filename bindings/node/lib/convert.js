'use strict';
// Between JavaScript values and the structs of the C interface. What has a wrong type or shape is refused here, before
// the library is called.

const native = require('./native.js');
const { kindOf, numberOf, nameOf, flagsOf } = require('./names.js');

const { functions, initialised } = native;

const SCALARS = new Map([[Float32Array, 1], [Float64Array, 2]]);
const DEPTH_FORMATS = new Map([[Uint16Array, 1], [Float32Array, 2]]);
const IMAGE_FORMATS = new Map([[Uint8Array, 1], [Uint8ClampedArray, 1], [Uint16Array, 2], [Float32Array, 3]]);
const MASKS = new Map([[Uint8Array, 0], [Uint8ClampedArray, 0]]);
const WEIGHTS = new Map([[Float64Array, 0]]);

/** The properties of an object, none but the known ones, each read once. */
function object(what, value, known, kind = 'an object') {
  if (typeof value !== 'object' || value === null || Array.isArray(value) || ArrayBuffer.isView(value)) {
    throw new TypeError(`${what} must be ${kind}, not ${kindOf(value)}`);
  }
  const unknown = Object.keys(value).find((key) => !known.includes(key));
  if (unknown !== undefined) throw new TypeError(`${what} has no ${unknown}; it has ${known.join(', ')}`);
  return Object.fromEntries(known.map((key) => [key, value[key]]));
}

/** The description of a typed array, which may stand for itself. */
function described(what, value, known) {
  if (ArrayBuffer.isView(value)) return { data: value };
  return object(what, value, known, 'a typed array or an object with one as data');
}

function number(what, value) {
  if (typeof value !== 'number') throw new TypeError(`${what} must be a number, not ${kindOf(value)}`);
  return value;
}

function integer(what, value, limit) {
  if (!Number.isInteger(number(what, value)) || value < 0 || value > limit) {
    throw new RangeError(`${what} is ${value}; it must be an integer from 0 to ${limit}`);
  }
  return value;
}

const uint32 = (what, value) => integer(what, value, 0xffffffff);
const size = (what, value) => integer(what, value, Number.MAX_SAFE_INTEGER);

function uint64(what, value) {
  if (typeof value !== 'bigint') return size(what, value);
  if (value < 0n || value > 0xffffffffffffffffn) throw new RangeError(`${what} is ${value}; it must be in [0, 2^64)`);
  return value;
}

/** From `least` to `most` numbers out of an array of any kind. */
function numbers(what, value, most, least = most) {
  const array = Array.isArray(value) || ArrayBuffer.isView(value);
  if (!(array && value.length >= least && value.length <= most)) {
    const count = least === most ? most : `${least} to ${most}`;
    const given = array ? `${kindOf(value)} of ${value.length}` : kindOf(value);
    throw new TypeError(`${what} must be an array of ${count} numbers, not ${given}`);
  }
  return Float64Array.from(value, (item, index) => number(`${what}[${index}]`, item));
}

const getter = (name) => Object.getOwnPropertyDescriptor(Object.getPrototypeOf(Uint8Array.prototype), name).get;
// A typed array may say anything of itself by properties of its own, and one of another realm (vm, Jest) has another
// class: these ask the array itself.
const [typeName, lengthOf] = [getter(Symbol.toStringTag), getter('length')];

/** Whether the memory of an array was transferred to another thread. */
function detached(array) {
  try {
    new Uint8Array(array.buffer);
    return false;
  } catch {
    return true;
  }
}

/** A typed array: the code of its type, how many numbers it has, and the bytes of each. */
function typed(what, data, types) {
  const name = typeName.call(data);
  for (const [type, code] of types) {
    if (type.name !== name) continue;
    const length = lengthOf.call(data);
    if (length === 0 && detached(data)) throw new TypeError(`${what} has no memory: its buffer was transferred`);
    return { code, length, bytes: type.BYTES_PER_ELEMENT };
  }
  const known = [...types.keys()].map((type) => type.name).join(' or ');
  throw new TypeError(`${what} must be a ${known}, not ${kindOf(data)}`);
}

/** How many items of `size` numbers an array holds from its first number to its last. */
function items(what, item, length, stride, size) {
  const over = length % stride;
  // The last item needs no more than its own numbers.
  if (stride < size || (over !== 0 && over !== size % stride)) {
    throw new RangeError(
      `${what} has ${length} numbers, which is no whole number of ${item}s of ${stride} numbers: a ${item} has ${size}`,
    );
  }
  return Math.ceil(length / stride);
}

/** Refuses an array that does not hold the grid which width, height and strides (in numbers) describe. */
function holds(what, length, width, height, stride, rowStride, item) {
  if (width === 0 || height === 0) return;
  const step = stride || item;
  const row = rowStride || width * step;
  // These products may round, but not below the length of an array. Numbers that items share (strides that are too
  // small) do not count twice, or an output could be of any size.
  const need = Math.max((height - 1) * row + (width - 1) * step, (width * height - 1) * item) + item;
  if (need > length) {
    throw new RangeError(
      `${what} has ${length} numbers, too few for ${width} x ${height} with strides of ${step} and ${row} numbers`,
    );
  }
}

const OPTION_FIELDS = {
  method: ['method', 'method'], objective: ['objective', 'objective'], start: ['start', 'start'],
  nearWall: ['near_wall', 'nearWall'], chart: ['chart', 'chart'], edgeUse: ['edge_use', 'edgeUse'],
  extentRule: ['extent_rule', 'extentRule'], maxIterations: ['max_iterations', uint32],
  maxThreads: ['max_threads', uint32], edgeWeight: ['edge_weight', number], initialLambda: ['initial_lambda', number],
  lambdaFactor: ['lambda_factor', number], maxLambda: ['max_lambda', number], costTolerance: ['cost_tolerance', number],
  ransacThreshold: ['ransac_threshold', number], seed: ['seed', uint64],
  ransacMaxIterations: ['ransac_max_iterations', uint32], radiusMin: ['radius_min', number],
  radiusMax: ['radius_max', number], axis: ['axis', (what, value) => numbers(what, value, 3)],
  axisMaxAngle: ['axis_max_angle', number],
};

/** The defaults with the given fields in place of them. */
function optionsToC(options) {
  const given = object('options', options, Object.keys(OPTION_FIELDS));
  const c = initialised(functions.cylfuse_options_init, native.Options);
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined) continue;
    const [field, kind] = OPTION_FIELDS[name];
    c[field] = typeof kind === 'string' ? numberOf(kind, name, value) : kind(name, value);
  }
  return c;
}

function optionsFromC(c) {
  const options = {};
  for (const [name, [field, kind]] of Object.entries(OPTION_FIELDS)) {
    options[name] = typeof kind === 'string' ? nameOf(kind, c[field]) : c[field];
  }
  options.axis = Array.from(c.axis);
  return options;
}

const INTRINSICS = ['width', 'height', 'fx', 'fy', 'cx', 'cy', 'distortionModel', 'distortion'];

function intrinsicsToC(intrinsics) {
  const given = object('intrinsics', intrinsics, INTRINSICS);
  const c = initialised(functions.cylfuse_intrinsics_init, native.Intrinsics);
  c.width = uint32('width', given.width);
  c.height = uint32('height', given.height);
  for (const field of ['fx', 'fy', 'cx', 'cy']) c[field] = number(field, given[field]);
  c.distortion_model = numberOf('distortionModel', 'distortionModel', given.distortionModel ?? 'none');
  c.distortion = new Float64Array(8);
  c.distortion.set(numbers('distortion', given.distortion ?? [], 8, 0));
  return c;
}

/** A cylinder for C; null for that of the last fit. */
function cylinderToC(what, cylinder) {
  const given = object(what, cylinder, ['point', 'direction', 'radius']);
  return {
    point: numbers(`${what}.point`, given.point, 3),
    direction: numbers(`${what}.direction`, given.direction, 3),
    radius: number(`${what}.radius`, given.radius),
  };
}

const optionalCylinder = (cylinder) => (cylinder == null ? null : cylinderToC('model', cylinder));

const cylinderFromC = (c) => ({
  point: Array.from(c.point), direction: Array.from(c.direction), radius: c.radius,
});

const POINTS = [
  'data', 'width', 'height', 'pointStride', 'rowStride', 'weights', 'weightStride', 'weightRowStride', 'normals',
  'normalStride', 'normalRowStride',
];

/** The view of a cloud, and how many points it has. */
function pointsToC(points) {
  const given = described('points', points, POINTS);
  const { data } = given;
  const strides = {};
  for (const name of POINTS) if (name.endsWith('Stride')) strides[name] = size(`points.${name}`, given[name] ?? 0);
  const { code: scalar, length, bytes } = typed('points.data', data, SCALARS);
  const height = size('points.height', given.height ?? 1);
  if (given.width === undefined && given.height !== undefined) throw new TypeError('points have a height but no width');
  const width = size('points.width', given.width ?? items('points.data', 'point', length, strides.pointStride || 3, 3));
  holds('points.data', length, width, height, strides.pointStride, strides.rowStride, 3);
  const view = initialised(functions.cylfuse_points_view_init, native.PointsView);
  Object.assign(view, {
    scalar, data, width, height, point_stride: strides.pointStride * bytes, row_stride: strides.rowStride * bytes,
  });
  for (const [name, field, item] of [['weights', 'weight', 1], ['normals', 'normal', 3]]) {
    const values = given[name];
    if (values == null) continue;
    const array = typed(`points.${name}`, values, SCALARS);
    if (array.code !== scalar) {
      throw new TypeError(`points.${name} must be a ${kindOf(data)} like points.data, not ${kindOf(values)}`);
    }
    const [stride, rowStride] = [strides[`${field}Stride`], strides[`${field}RowStride`]];
    holds(`points.${name}`, array.length, width, height, stride, rowStride, item);
    view[name] = values;
    view[`${field}_stride`] = stride * bytes;
    view[`${field}_row_stride`] = rowStride * bytes;
  }
  return { view, count: width * height };
}

const PIXELS = ['data', 'width', 'height', 'rowStride', 'pixelStride'];

/** The fields that all images share, and the rest of the description. */
function pixels(what, image, types, more = []) {
  const { data, width, height, rowStride = 0, pixelStride = 0, ...rest } = object(what, image, [...PIXELS, ...more]);
  const { code: format, length, bytes } = typed(`${what}.data`, data, types);
  uint32(`${what}.width`, width);
  uint32(`${what}.height`, height);
  size(`${what}.rowStride`, rowStride);
  size(`${what}.pixelStride`, pixelStride);
  holds(`${what}.data`, length, width, height, pixelStride, rowStride, 1);
  const strides = { row_stride: rowStride * bytes, pixel_stride: pixelStride * bytes };
  return { format, fields: { data, width, height, ...strides }, rest };
}

function depthToC(depth) {
  const { format, fields, rest } = pixels('depth', depth, DEPTH_FORMATS, ['scale', 'minDepth', 'maxDepth']);
  return {
    ...initialised(functions.cylfuse_depth_view_init, native.DepthView), ...fields, format,
    scale: number('depth.scale', rest.scale ?? 1), min_depth: number('depth.minDepth', rest.minDepth ?? 0),
    max_depth: number('depth.maxDepth', rest.maxDepth ?? 0),
  };
}

function imageToC(image) {
  const { format, fields, rest } = pixels('image', image, IMAGE_FORMATS, ['gamma']);
  return {
    ...initialised(functions.cylfuse_image_view_init, native.ImageView), ...fields, format,
    gamma: number('image.gamma', rest.gamma ?? 1),
  };
}

/** A mask for C; null for none. */
function maskToC(mask) {
  if (mask == null) return null;
  return { ...initialised(functions.cylfuse_mask_view_init, native.MaskView), ...pixels('mask', mask, MASKS).fields };
}

function segmentsToC(edges) {
  const { data, stride, weights } = described('edges', edges, ['data', 'stride', 'weights']);
  const step = size('edges.stride', stride ?? 0) || 4;
  const { code: scalar, length, bytes } = typed('edges.data', data, SCALARS);
  const count = items('edges.data', 'segment', length, step, 4);
  if (weights != null && typed('edges.weights', weights, WEIGHTS).length !== count) {
    throw new RangeError(`edges.weights has ${weights.length} numbers for ${count} segments: give one for each`);
  }
  return {
    ...initialised(functions.cylfuse_segments_view_init, native.SegmentsView), scalar, data, count,
    segment_stride: step * bytes, weights: weights ?? null,
  };
}

const resultFromC = (c) => ({
  cylinder: cylinderFromC(c.model),
  startCylinder: cylinderFromC(c.start_model),
  termination: nameOf('termination', c.termination),
  startKind: nameOf('start', c.start_kind),
  flags: flagsOf(c.flags),
  iterations: c.iterations,
  rejectedSteps: c.rejected_steps,
  segmentsUsed: c.segments_used,
  segmentsGiven: c.segments_given,
  pointsUsed: c.points_used,
  pointsGiven: c.points_given,
  initialCost: c.initial_cost,
  cost: c.cost,
  energyPoints: c.energy_points,
  energyEdges: c.energy_edges,
  edgeWeight: c.edge_weight,
  pointRms: c.point_rms,
  edgeRmsPixels: c.edge_rms_pixels,
  nearWallFraction: c.near_wall_fraction,
  condition: c.condition,
  lambda: c.lambda,
  gradientNorm: c.gradient_norm,
  stepNorm: c.step_norm,
  secondsStart: c.seconds_start,
  secondsSolve: c.seconds_solve,
  secondsTotal: c.seconds_total,
  radiusDeviation: c.radius_deviation,
  directionDeviation: c.direction_deviation,
  positionDeviation: c.position_deviation,
  radiusFromPoints: c.radius_from_points,
  radiusFromPointsDeviation: c.radius_from_points_deviation,
  radiusFromLimbs: c.radius_from_limbs,
  radiusFromLimbsDeviation: c.radius_from_limbs_deviation,
  radiusZScore: c.radius_z_score,
  covariance: Float64Array.from(c.covariance),
  limbsLocated: c.limbs_located,
});

const countsFromC = (c) => ({
  pointsGiven: c.points_given,
  pointsUsed: c.points_used,
  droppedNotFinite: c.dropped_not_finite,
  droppedZeroWeight: c.dropped_zero_weight,
  droppedOutsideMask: c.dropped_outside_mask,
  droppedNoDepth: c.dropped_no_depth,
  droppedOutOfRange: c.dropped_out_of_range,
  droppedOutsideCamera: c.dropped_outside_camera,
  segmentsGiven: c.segments_given,
});

const diagnosisFromC = (c) => ({
  rank: c.rank,
  singularValues: Array.from(c.singular_values),
  condition: c.condition,
  weakestShift: Array.from(c.weakest_shift),
  weakestTilt: Array.from(c.weakest_tilt),
  weakestRadius: c.weakest_radius,
});

const completionFromC = (c) => ({
  count: c.count, hits: c.hits, misses: c.misses, outsideCamera: c.outside_camera, outOfRange: c.out_of_range,
});

const extentFromC = (c) => ({
  startState: nameOf('endState', c.start_state),
  endState: nameOf('endState', c.end_state),
  start: Array.from(c.start),
  end: Array.from(c.end),
  center: Array.from(c.center),
  length: c.length,
  startDeviation: c.start_deviation,
  endDeviation: c.end_deviation,
  lengthDeviation: c.length_deviation,
  startCovariance: Float64Array.from(c.start_covariance),
  endCovariance: Float64Array.from(c.end_covariance),
  centerCovariance: Float64Array.from(c.center_covariance),
});

const progressFromC = (c) => ({
  phase: nameOf('phase', c.phase),
  iteration: c.iteration,
  maxIterations: c.max_iterations,
  cost: c.cost,
  lambda: c.lambda,
  cylinder: cylinderFromC(c.model),
});

const limbSampleFromC = (c) => ({ pixel: Array.from(c.pixel), sigma: c.sigma, weight: c.weight, limb: c.limb });

module.exports = {
  SCALARS, DEPTH_FORMATS, object, number, size, optionsToC, optionsFromC, intrinsicsToC, cylinderToC, optionalCylinder,
  cylinderFromC, pointsToC, depthToC, imageToC, maskToC, segmentsToC, resultFromC, countsFromC, diagnosisFromC,
  completionFromC, extentFromC, progressFromC, limbSampleFromC,
};

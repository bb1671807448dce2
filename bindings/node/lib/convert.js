'use strict';
// Between JavaScript values and the structs of the C interface. What has a wrong type or shape is refused here, before
// the library is called.

const { koffi, structs, initialised } = require('./native.js');
const { kindOf, numberOf, nameOf, flagsOf } = require('./names.js');

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
  extentRule: ['extent_rule', 'extentRule'], maxThreads: ['max_threads', uint32],
  maxIterations: ['max_iterations', uint32], costTolerance: ['cost_tolerance', number],
  gradientTolerance: ['gradient_tolerance', number], stepTolerance: ['step_tolerance', number],
  initialLambda: ['initial_lambda', number], lambdaFactor: ['lambda_factor', number],
  maxLambda: ['max_lambda', number], edgeWeight: ['edge_weight', number], seed: ['seed', uint64],
  ransacMaxIterations: ['ransac_max_iterations', uint64], ransacThreshold: ['ransac_threshold', number],
  independentPoints: ['independent_points', number], depthNoise: ['depth_noise', number],
  imageNoise: ['image_noise', number], edgeNoise: ['edge_noise', number], maskNoise: ['mask_noise', number],
  imageBlur: ['image_blur', number], drawnPixel: ['drawn_pixel', number], radiusMin: ['radius_min', number],
  radiusMax: ['radius_max', number], axis: ['axis', (what, value) => numbers(what, value, 3)],
  axisMaxAngle: ['axis_max_angle', number], depthShared: ['depth_shared', number],
};

const DETECTOR_OPTION_FIELDS = {
  imageUse: ['image_use', 'imageUse'], maxThreads: ['max_threads', uint32], maxCount: ['max_count', uint32],
  minPixels: ['min_pixels', uint64], minScore: ['min_score', number], radiusMin: ['radius_min', number],
  radiusMax: ['radius_max', number], axis: ['axis', (what, value) => numbers(what, value, 3)],
  axisMaxAngle: ['axis_max_angle', number],
};

/** What makes a struct of the defaults with the given fields in place of them. */
const toC = (struct, fields) => (options) => {
  const given = object('options', options, Object.keys(fields));
  const c = initialised(struct);
  for (const [name, value] of Object.entries(given)) {
    if (value === undefined) continue;
    const [field, kind] = fields[name];
    c[field] = typeof kind === 'string' ? numberOf(kind, name, value) : kind(name, value);
  }
  return c;
};

const fromC = (fields) => (c) => {
  const options = {};
  for (const [name, [field, kind]] of Object.entries(fields)) {
    options[name] = typeof kind === 'string' ? nameOf(kind, c[field]) : c[field];
  }
  options.axis = Array.from(c.axis);
  return options;
};

const [optionsToC, optionsFromC] = [toC('options', OPTION_FIELDS), fromC(OPTION_FIELDS)];
const detectorOptionsToC = toC('detector_options', DETECTOR_OPTION_FIELDS);
const detectorOptionsFromC = fromC(DETECTOR_OPTION_FIELDS);

const INTRINSICS = ['width', 'height', 'fx', 'fy', 'cx', 'cy', 'distortionModel', 'distortion'];

function intrinsicsToC(intrinsics) {
  const given = object('intrinsics', intrinsics, INTRINSICS);
  const c = initialised('intrinsics');
  c.width = uint32('width', given.width);
  c.height = uint32('height', given.height);
  for (const field of ['fx', 'fy', 'cx', 'cy']) c[field] = number(field, given[field]);
  c.distortion_model = numberOf('distortionModel', 'distortionModel', given.distortionModel ?? 'none');
  c.distortion = new Float64Array(8);
  c.distortion.set(numbers('distortion', given.distortion ?? [], 8, 0));
  return c;
}

const intrinsicsFromC = (c) => ({
  width: c.width, height: c.height, fx: c.fx, fy: c.fy, cx: c.cx, cy: c.cy,
  distortionModel: nameOf('distortionModel', c.distortion_model), distortion: Array.from(c.distortion),
});

/** A pose for C: its rotation, row by row, and its translation. */
function poseToC(what, pose) {
  const given = object(what, pose, ['rotation', 'translation']);
  return [numbers(`${what}.rotation`, given.rotation, 9), numbers(`${what}.translation`, given.translation, 3)];
}

/** A depth camera for C: its intrinsics, and the rotation and translation to the colour camera; nulls for none. */
function depthCameraToC(camera) {
  if (camera === null) return [null, null, null];
  const given = object('camera', camera, ['intrinsics', 'toColour']);
  return [intrinsicsToC(given.intrinsics), ...poseToC('camera.toColour', given.toColour)];
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

/** The view of a cloud, how many points it has, and its columns and rows. */
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
  const view = initialised('points_view');
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
  return { view, count: width * height, size: [width, height] };
}

const PIXELS = ['data', 'width', 'height', 'rowStride', 'pixelStride'];

/** The fields that all images share, and the rest of the description, which says how many `channels` a pixel has. */
function pixels(what, image, types, more = [], channels = () => 1) {
  const { data, width, height, rowStride = 0, pixelStride = 0, ...rest } = object(what, image, [...PIXELS, ...more]);
  const { code: format, length, bytes } = typed(`${what}.data`, data, types);
  uint32(`${what}.width`, width);
  uint32(`${what}.height`, height);
  size(`${what}.rowStride`, rowStride);
  size(`${what}.pixelStride`, pixelStride);
  holds(`${what}.data`, length, width, height, pixelStride, rowStride, channels(rest, format));
  const strides = { row_stride: rowStride * bytes, pixel_stride: pixelStride * bytes };
  return { format, fields: { data, width, height, ...strides }, rest };
}

function depthToC(depth) {
  const { format, fields, rest } = pixels('depth', depth, DEPTH_FORMATS, ['scale', 'minDepth', 'maxDepth']);
  if (rest.scale == null && depth.data instanceof Uint16Array) {
    throw new TypeError('depth.scale is missing, which a Uint16Array needs; give the length of one unit of depth: 0.001 for '
      + 'millimetres where lengths are to be metres, 1 where they are to be in the unit of the depth');
  }
  return {
    ...initialised('depth_view'), ...fields, format,
    scale: number('depth.scale', rest.scale ?? 1), min_depth: number('depth.minDepth', rest.minDepth ?? 0),
    max_depth: number('depth.maxDepth', rest.maxDepth ?? 0),
  };
}

/** How many bytes a pixel of an image has, grey ones numbers: colours come as bytes only. */
function channelsOf({ format = 'grey' }, type) {
  const number = numberOf('imageFormat', 'image.format', format);
  if (format === 'grey') return 1;
  if (type !== 1) throw new TypeError(`image.data of the format ${format} must be a Uint8Array or Uint8ClampedArray`);
  return number < 6 ? 3 : 4;
}

function imageToC(image) {
  const { format, fields, rest } = pixels('image', image, IMAGE_FORMATS, ['format', 'gamma'], channelsOf);
  const { format: colours = 'grey' } = rest;
  return {
    ...initialised('image_view'), ...fields, gamma: number('image.gamma', rest.gamma ?? 1),
    format: colours === 'grey' ? format : numberOf('imageFormat', 'image.format', colours),
  };
}

/** A mask for C; null for none. */
function maskToC(mask) {
  if (mask == null) return null;
  const { fields, rest } = pixels('mask', mask, MASKS, ['label']);
  return { ...initialised('mask_view'), ...fields, label: uint32('mask.label', rest.label ?? 0) };
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
    ...initialised('segments_view'), scalar, data, count,
    segment_stride: step * bytes, weights: weights ?? null,
  };
}

/** Pixels as pairs of numbers, and how many there are. */
function pixelsToC(pixels) {
  const { length } = typed('pixels', pixels, WEIGHTS);
  if (length % 2 !== 0) throw new RangeError(`pixels has ${length} numbers, which is no whole number of pixels of 2`);
  return { pixels, count: length / 2 };
}

const resultFromC = (result, estimate) => ({
  cylinder: cylinderFromC(estimate.model),
  startCylinder: cylinderFromC(estimate.start_model),
  startKind: nameOf('start', estimate.start_kind),
  radiusDeviation: estimate.radius_deviation,
  directionDeviation: estimate.direction_deviation,
  positionDeviation: estimate.position_deviation,
  radiusFromPoints: estimate.radius_from_points,
  radiusFromPointsDeviation: estimate.radius_from_points_deviation,
  radiusFromLimbs: estimate.radius_from_limbs,
  radiusFromLimbsDeviation: estimate.radius_from_limbs_deviation,
  radiusZScore: estimate.radius_z_score,
  covariance: Float64Array.from(estimate.covariance),
  flags: flagsOf(result.flags),
  termination: nameOf('termination', result.termination),
  iterations: result.iterations,
  rejectedSteps: result.rejected_steps,
  limbsLocated: result.limbs_located,
  segmentsGiven: result.segments_given,
  segmentsUsed: result.segments_used,
  pointsGiven: result.points_given,
  pointsUsed: result.points_used,
  independentPoints: result.independent_points,
  pointDeviation: result.point_deviation,
  pointRms: result.point_rms,
  edgeRmsPixels: result.edge_rms_pixels,
  nearWallFraction: result.near_wall_fraction,
  initialCost: result.initial_cost,
  cost: result.cost,
  energyPoints: result.energy_points,
  energyEdges: result.energy_edges,
  edgeWeight: result.edge_weight,
  condition: result.condition,
  gradientNorm: result.gradient_norm,
  stepNorm: result.step_norm,
  lambda: result.lambda,
  secondsStart: result.seconds_start,
  secondsSolve: result.seconds_solve,
  secondsTotal: result.seconds_total,
});

const countsFromC = (c) => ({
  view: c.view,
  pointsGiven: c.points_given,
  pointsUsed: c.points_used,
  droppedNotFinite: c.dropped_not_finite,
  droppedZeroWeight: c.dropped_zero_weight,
  droppedOutsideMask: c.dropped_outside_mask,
  droppedNoDepth: c.dropped_no_depth,
  droppedOutOfRange: c.dropped_out_of_range,
  droppedOutsideCamera: c.dropped_outside_camera,
  droppedHidden: c.dropped_hidden,
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
  view: c.view, count: c.count, hits: c.hits, misses: c.misses, outsideCamera: c.outside_camera,
  outOfRange: c.out_of_range,
});

const extentFromC = (c) => ({
  startState: nameOf('endState', c.start_state),
  endState: nameOf('endState', c.end_state),
  startSource: nameOf('endSource', c.start_source),
  endSource: nameOf('endSource', c.end_source),
  startView: c.start_view,
  endView: c.end_view,
  limbsKnown: c.limbs_known !== 0,
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
  cylinder: c.cylinder === null ? null : cylinderFromC(koffi.decode(c.cylinder, structs.cylinder)),
});

const detectionProgressFromC = (c) => ({
  phase: nameOf('detectionPhase', c.phase), fitsDone: c.fits_done, fits: c.fits,
});

const limbFromC = (c) => ({
  view: c.view, limb: c.limb, status: nameOf('limbStatus', c.status), samples: c.samples, line: Array.from(c.line),
  deviation: c.deviation,
});

const limbSampleFromC = (c) => ({
  view: c.view, limb: c.limb, pixel: Array.from(c.pixel), deviation: c.deviation, weight: c.weight,
});

const endSampleFromC = (c) => ({
  view: c.view, end: c.end, pixel: Array.from(c.pixel), normal: Array.from(c.normal), deviation: c.deviation,
});

module.exports = {
  SCALARS, DEPTH_FORMATS, object, number, size, optionsToC, optionsFromC, detectorOptionsToC, detectorOptionsFromC,
  intrinsicsToC, intrinsicsFromC, poseToC, depthCameraToC, cylinderToC, optionalCylinder, pointsToC, depthToC, imageToC, maskToC,
  segmentsToC, pixelsToC,
  resultFromC, countsFromC, diagnosisFromC, completionFromC, extentFromC, progressFromC,
  detectionProgressFromC, limbFromC, limbSampleFromC, endSampleFromC,
};

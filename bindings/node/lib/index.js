'use strict';

const { functions } = require('./native.js');
const convert = require('./convert.js');
const { enumerations, numberOf, nameOf } = require('./names.js');
const { CylfuseError, check } = require('./errors.js');
const { Detector } = require('./detector.js');
const { Fitter, fitAll } = require('./fitter.js');
const { Frame } = require('./frame.js');

async function fitPoints(points) {
  const fitter = new Fitter();
  try {
    fitter.pushPoints(points);
    return await fitter.fit();
  } finally {
    fitter.close();
  }
}

function distances(cylinder, points) {
  const c = convert.cylinderToC('cylinder', cylinder);
  const { view, count } = convert.pointsToC(points);
  const out = new Float64Array(count);
  check(functions.cylfuse_cylinder_distances(c, view, out, count));
  return out;
}

function project(cylinder, intrinsics) {
  const lines = new Float64Array(6);
  const c = convert.cylinderToC('cylinder', cylinder);
  check(functions.cylfuse_cylinder_project(c, convert.intrinsicsToC(intrinsics), lines));
  return [Array.from(lines.subarray(0, 3)), Array.from(lines.subarray(3))];
}

function compare(a, b) {
  const [angle, axisDistance, radiusRelative] = [[0], [0], [0]];
  const [first, second] = [convert.cylinderToC('a', a), convert.cylinderToC('b', b)];
  check(functions.cylfuse_cylinder_compare(first, second, angle, axisDistance, radiusRelative));
  return { angle: angle[0], axisDistance: axisDistance[0], radiusRelative: radiusRelative[0] };
}

function decideConformity(value, deviation, tolerance, flags = []) {
  const { lower = -Infinity, upper = Infinity, coverage = 2 } =
    convert.object('tolerance', tolerance, ['lower', 'upper', 'coverage']);
  const numbers = { value, deviation, lower, upper, coverage };
  for (const [name, number] of Object.entries(numbers)) convert.number(name, number);
  if (coverage === 0) throw new RangeError('coverage is 0; it must be finite and greater than 0');
  const bits = flags.reduce((sum, name) => sum | numberOf('flag', 'flags', name), 0);
  const out = [0];
  check(functions.cylfuse_decide_conformity(value, deviation, bits, lower, upper, coverage, out));
  return nameOf('conformity', out[0]);
}

function radiusConforms(result, tolerance) {
  return decideConformity(result.cylinder.radius, result.radiusDeviation, tolerance, result.flags);
}

function diameterConforms(result, tolerance) {
  return decideConformity(2 * result.cylinder.radius, 2 * result.radiusDeviation, tolerance, result.flags);
}

/** What makes the text of a name of a kind; a number, as of what a later library has made up, may stand for it. */
const describing = (kind, text) => (name) => text(/^\d+$/.test(name) ? Number(name) : numberOf(kind, kind, name));

const describeFlag = describing('flag', functions.cylfuse_flag_string);
const describeFlags = (flags) => Array.from(flags, describeFlag);
const describeTermination = describing('termination', functions.cylfuse_termination_string);
const describeStart = describing('start', functions.cylfuse_start_string);
const describeEndState = describing('endState', functions.cylfuse_end_state_string);
const describeEndSource = describing('endSource', functions.cylfuse_end_source_string);
const describeLimbStatus = describing('limbStatus', functions.cylfuse_limb_status_string);
const describePart = describing('part', functions.cylfuse_part_string);
const describeConformity = describing('conformity', functions.cylfuse_conformity_string);

function plan(intrinsics, cylinder, noise) {
  const { distance, radius, length, tilt = 0, turn = 0 } = cylinder;
  const camera = convert.intrinsicsToC(intrinsics);
  const numbers = Float64Array.of(distance, radius, length, tilt, turn);
  if (noise !== undefined && noise.length !== 6) throw new RangeError(`noise has ${noise.length} numbers; it must have 6`);
  const [scatter, total] = [new Float64Array(4), new Float64Array(4)];
  check(functions.cylfuse_plan(camera, numbers, noise === undefined ? null : Float64Array.from(noise), scatter, total));
  const named = ([ofRadius, direction, position, ofLength]) => ({ radius: ofRadius, direction, position, length: ofLength });
  return { scatter: named(scatter), total: named(total) };
}

function projectPoints(intrinsics, points) {
  const c = convert.intrinsicsToC(intrinsics);
  const { view, count } = convert.pointsToC(points);
  const pixels = new Float64Array(2 * count);
  check(functions.cylfuse_intrinsics_project(c, view, pixels, count));
  return pixels;
}

function unprojectPixels(intrinsics, pixels) {
  const c = convert.intrinsicsToC(intrinsics);
  const { pixels: given, count } = convert.pixelsToC(pixels);
  const rays = new Float64Array(3 * count);
  check(functions.cylfuse_intrinsics_unproject(c, given, count, rays));
  return rays;
}

exports.Fitter = Fitter;
exports.Frame = Frame;
exports.Detector = Detector;
exports.CylfuseError = CylfuseError;
exports.fitPoints = fitPoints;
exports.fitAll = fitAll;
exports.distances = distances;
exports.project = project;
exports.compare = compare;
exports.decideConformity = decideConformity;
exports.radiusConforms = radiusConforms;
exports.diameterConforms = diameterConforms;
exports.describeFlags = describeFlags;
exports.describeTermination = describeTermination;
exports.describeStart = describeStart;
exports.describeEndState = describeEndState;
exports.describeEndSource = describeEndSource;
exports.describeLimbStatus = describeLimbStatus;
exports.describePart = describePart;
exports.describeConformity = describeConformity;
exports.plan = plan;
exports.projectPoints = projectPoints;
exports.unprojectPixels = unprojectPixels;
exports.version = functions.cylfuse_version_string();
exports.buildInfo = functions.cylfuse_build_info();

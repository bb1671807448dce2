'use strict';
// Runs the golden cases of bindings/conformance, whose README describes the format, and prints the results.

const fs = require('node:fs');
const path = require('node:path');
const cylfuse = require('..');
const { enumerations } = require('../lib/names.js');

const file = JSON.parse(fs.readFileSync(path.join(__dirname, '..', '..', 'conformance', 'cases.json'), 'utf8'));

const TYPES = { u8: Uint8Array, u16: Uint16Array, f32: Float32Array, f64: Float64Array };
const ENUMERATED = ['method', 'objective', 'start', 'near_wall', 'chart', 'edge_use', 'extent_rule', 'distortion_model',
  'image_use'];

const camel = (name) => name.replace(/_(.)/g, (_, letter) => letter.toUpperCase());
const snake = (name) => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
const word = (name) => name.toLowerCase().replaceAll('_', '-');
const number = (value) => (value === null ? NaN : value);

function array(name) {
  const { type, shape, data } = file.arrays[name];
  const bytes = Buffer.from(data, 'base64');
  const elements = new TYPES[type](Uint8Array.from(bytes).buffer);
  return { elements, shape };
}

/** Fields by their names here, enumerations by their words. */
function fields(given) {
  return Object.fromEntries(Object.entries(given).map(([name, value]) => [
    camel(name),
    ENUMERATED.includes(name) ? word(value) : Array.isArray(value) ? value.map(number) : number(value),
  ]));
}

const model = (given) => (given ? {
  point: given.point.map(number), direction: given.direction.map(number), radius: number(given.radius),
} : null);

function columns(given) {
  const { elements, shape } = array(given.array);
  const [height, width, channels] = shape.length === 3 ? shape : [1, ...shape];
  return { data: elements.subarray(given.column ?? 0), width, height, stride: channels, rowStride: width * channels };
}

function points(given) {
  const { data, width, height, stride, rowStride } = columns(given);
  const view = { data, width, height, pointStride: stride, rowStride };
  if (given.weights) {
    const weights = columns(given.weights);
    Object.assign(view, { weights: weights.data, weightStride: weights.stride, weightRowStride: weights.rowStride });
  }
  if (given.normals) {
    const normals = columns(given.normals);
    Object.assign(view, { normals: normals.data, normalStride: normals.stride, normalRowStride: normals.rowStride });
  }
  return view;
}

/** An array of pixels, which may have several numbers each; null without a name. */
function image(name) {
  if (name === undefined) return null;
  const { elements, shape } = array(name);
  return { data: elements, width: shape[1], height: shape[0] };
}

const mask = ({ mask: name, label }) => name === undefined ? null : { ...image(name), label };

const depth = (step) => ({
  ...image(step.depth), scale: step.scale, minDepth: step.min_depth, maxDepth: step.max_depth,
});

function picture(step) {
  const channels = array(step.image).shape[2];
  const format = channels && (step.format?.toLowerCase().replace('8', '') ?? { 3: 'rgb', 4: 'rgba' }[channels]);
  return { ...image(step.image), gamma: step.gamma, ...(format && { format }) };
}

const camera = (step) => fields(file.cameras[step.camera]);

const pose = ({ pose: { rotation, translation } }) => ({
  rotation: rotation.map(number), translation: translation.map(number),
});

const depthCamera = (step) => step.camera === null ? null : { intrinsics: camera(step), toColour: pose(step) };

const segments = (step) => ({
  data: Float64Array.from(step.segments.flat(), number),
  weights: step.weights && Float64Array.from(step.weights, number),
});

// The enumerations of the outputs that are not named after them.
const KINDS = {
  startKind: 'start', startState: 'endState', startSource: 'endSource', status: 'limbStatus',
};
// The outputs that C has in cylfuse_cylinder_estimate.
const OF_ESTIMATE = /^(cylinder|start|radius|direction|position|covariance)/;

/** The outputs by the names of the C interface, as lists of numbers. */
function outputs(value) {
  const out = {};
  for (const [name, item] of Object.entries(value)) {
    if (name.startsWith('seconds')) continue;
    const field = snake(name).replace('cylinder', 'model');
    if (item?.point) {
      for (const part of ['point', 'direction', 'radius']) out[`${field}.${part}`] = [item[part]].flat();
    } else if (name === 'flags') {
      out.flags = [item.reduce((bits, flag) => bits | enumerations.flag[flag], 0)];
    } else if (typeof item === 'string') {
      out[field] = [enumerations[KINDS[name] ?? name][item]];
    } else {
      out[field] = typeof item === 'object' ? Array.from(item) : [Number(item)];
    }
  }
  return out;
}

/** Each field of a list of objects. */
const columnsOf = (items, names) => Object.fromEntries(names.map((name) => [
  name, items.flatMap((item) => (name === 'status' ? enumerations.limbStatus[item[name]] : item[name])),
]));

/** One detection; the list knows no such error as the library. */
function detected(detector, { index }) {
  detector.indices(index);
  return detector.detections()[index];
}

/** What a search has found. */
const found = (detections) => ({
  score: detections.map(({ score }) => score),
  pixels: detections.map(({ pixels }) => pixels),
  ...Object.fromEntries(['point', 'direction', 'radius'].map((part) => [
    `model.${part}`, detections.flatMap(({ result }) => result.cylinder[part]),
  ])),
});

/** Some fields of a result. */
const partOf = (result, wanted) => Object.fromEntries(Object.entries(result).filter(([name]) => wanted(name)));

const region = (step) => ({ model: model(step.model), mask: mask(step) });

const calls = {
  new_fitter(fitter, step, held) {
    fitter.close();
    held.fitter = new cylfuse.Fitter();
  },
  new_frame(fitter, step, held) {
    held.frame.close();
    held.frame = new cylfuse.Frame();
  },
  set_options: (fitter, step) => fitter.setOptions(fields(step.options)),
  get_options: (fitter) => fitter.getOptions(),
  select_view: (fitter, step) => fitter.selectView(step.index),
  view_count: (fitter) => ({ count: fitter.viewCount() }),
  set_pose: (fitter, step) => fitter.setPose(pose(step)),
  frame_set_pose: (fitter, step, { frame }) => frame.setPose(pose(step)),
  set_intrinsics: (fitter, step) => fitter.setIntrinsics(camera(step)),
  frame_set_intrinsics: (fitter, step, { frame }) => frame.setIntrinsics(camera(step)),
  set_depth_camera: (fitter, step) => fitter.setDepthCamera(depthCamera(step)),
  frame_set_depth_camera: (fitter, step, { frame }) => frame.setDepthCamera(depthCamera(step)),
  set_start_model: (fitter, step) => fitter.setStartModel(model(step.model)),
  reserve: (fitter, step) => fitter.reserve(step.points, step.segments),
  clear: (fitter) => fitter.clear(),
  clear_input: (fitter, step) => fitter.clearInput(...step.inputs.map(word)),
  cancel: (fitter) => fitter.cancel(),
  push_points: (fitter, step) => fitter.pushPoints(points(step.points), mask(step)),
  push_depth: (fitter, step) => fitter.pushDepth(depth(step), mask(step)),
  frame_set_depth: (fitter, step, { frame }) => frame.setDepth(depth(step)),
  push_image: (fitter, step) => fitter.pushImage(picture(step)),
  frame_set_image: (fitter, step, { frame }) => frame.setImage(picture(step)),
  push_edges: (fitter, step) => fitter.pushEdges(segments(step)),
  use_frame: (fitter, step, { frame }) => fitter.useFrame(frame, mask(step)),
  select_edges: (fitter, step) => ({
    selected: [...fitter.selectEdges(segments(step), { model: model(step.model), reach: step.reach })],
  }),
  counts: (fitter) => fitter.counts(),
  fit: (fitter) => fitter.fit(),
  get_result: (fitter) => partOf(fitter.result(), (name) => !OF_ESTIMATE.test(name)),
  get_cylinder: (fitter) => partOf(fitter.result(), (name) => OF_ESTIMATE.test(name)),
  detector_set_options: (_, step, { detector }) => detector.setOptions(fields(step.options)),
  detector_get_options: (_, step, { detector }) => detector.getOptions(),
  detector_set_fit_options: (_, step, { detector }) => detector.setFitOptions(fields(step.options)),
  detector_get_fit_options: (_, step, { detector }) => detector.getFitOptions(),
  detector_cancel: (_, step, { detector }) => detector.cancel(),
  async detect(_, step, { detector, frame }) {
    await detector.detect(frame);
  },
  async detect_points(_, step, { detector }) {
    await detector.detectPoints(points(step.points));
  },
  new_detector(_, step, held) {
    held.detector.close();
    held.detector = new cylfuse.Detector();
  },
  detector_count: (_, step, { detector }) => ({ count: detector.detections().length }),
  detector_detections: (_, step, { detector }) => found(detector.detections()),
  detector_get_result: (_, step, { detector }) =>
    partOf(detected(detector, step).result, (name) => !OF_ESTIMATE.test(name)),
  detector_get_cylinder: (_, step, { detector }) =>
    partOf(detected(detector, step).result, (name) => OF_ESTIMATE.test(name)),
  // The fitter says why there is none.
  detector_get_extent: (_, step, { detector }) =>
    detected(detector, step).extent ?? detector.fitter(step.index).extent(),
  detector_labels: (_, step, { detector }) => ({ labels: detector.labels().data }),
  detector_indices: (_, step, { detector }) => ({ indices: detector.indices(step.index) }),
  detector_make_fitter(fitter, step, held) {
    held.fitter = held.detector.fitter(step.index);
    fitter.close();
  },
  evaluate: (fitter, step) => fitter.evaluate(model(step.model)),
  residuals: (fitter, step) => ({ residuals: fitter.residuals(word(step.kind), model(step.model)) }),
  point_weights: (fitter) => fitter.pointWeights(),
  point_parts: (fitter, step) => ({
    parts: fitter.pointParts(model(step.model)).map((part) => enumerations.part[part]),
  }),
  limbs: (fitter) => columnsOf(fitter.limbs(), ['view', 'limb', 'status', 'samples', 'line', 'deviation']),
  limb_samples: (fitter) => columnsOf(fitter.limbSamples(), ['view', 'limb', 'pixel', 'deviation', 'weight']),
  end_samples: (fitter, step) => columnsOf(
    fitter.endSamples(region(step)), ['view', 'end', 'pixel', 'normal', 'deviation'],
  ),
  diagnose: (fitter, step) => fitter.diagnose(model(step.model)),
  complete(fitter, step) {
    const type = TYPES[step.scalar.toLowerCase()];
    const out = fitter.complete({ ...region(step), layout: word(step.layout), type });
    return { points: out.points, ...out.completion };
  },
  complete_depth(fitter, step) {
    const type = TYPES[step.format.toLowerCase()];
    const out = fitter.completeDepth({ ...region(step), scale: step.scale, type });
    return { depth: out.depth.data, ...out.completion };
  },
  extent: (fitter, step) => fitter.extent(region(step)),
  distances: (_, step) => ({ distances: cylfuse.distances(model(step.model), points(step.points)) }),
  project: (_, step) => ({ lines: cylfuse.project(model(step.model), camera(step)).flat() }),
  compare: (_, step) => cylfuse.compare(model(step.a), model(step.b)),
  intrinsics_project: (_, step) => ({ pixels: cylfuse.projectPoints(camera(step), points(step.points)) }),
  intrinsics_unproject: (_, step) => ({
    rays: cylfuse.unprojectPixels(camera(step), Float64Array.from(step.pixels.flat(), number)),
  }),
};

function bits(value) {
  if (Number.isNaN(value)) return 'nan';
  const buffer = Buffer.alloc(8);
  buffer.writeDoubleBE(value);
  return buffer.toString('hex');
}

async function main() {
  for (const { name, steps } of file.cases) {
    const held = { fitter: new cylfuse.Fitter(), frame: new cylfuse.Frame(), detector: new cylfuse.Detector() };
    for (const [index, step] of steps.entries()) {
      const line = (...parts) => console.log([name, index, ...parts].join('\t'));
      try {
        const value = await calls[step.call](held.fitter, step, held);
        line('ok');
        for (const [field, list] of Object.entries(outputs(value ?? {}))) line(field, Array.from(list, bits).join(' '));
      } catch (error) {
        if (!(error instanceof cylfuse.CylfuseError)) throw error;
        line('error', error.code, error.message);
      }
    }
    held.fitter.close();
    held.frame.close();
    held.detector.close();
  }
}

main();

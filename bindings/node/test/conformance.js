'use strict';
// Runs the golden cases of bindings/conformance, whose README describes the format, and prints the results.

const fs = require('node:fs');
const path = require('node:path');
const cylfuse = require('..');
const { enumerations } = require('../lib/names.js');

const file = JSON.parse(fs.readFileSync(path.join(__dirname, '..', '..', 'conformance', 'cases.json'), 'utf8'));

const TYPES = { u8: Uint8Array, u16: Uint16Array, f32: Float32Array, f64: Float64Array };
const ENUMERATED = ['method', 'objective', 'start', 'near_wall', 'chart', 'edge_use', 'extent_rule', 'distortion_model'];

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

function image(name) {
  if (name === undefined) return null;
  const { elements, shape } = array(name);
  return { data: elements, width: shape[1], height: shape[0] };
}

const segments = (step) => ({
  data: Float64Array.from(step.segments.flat(), number),
  weights: step.weights && Float64Array.from(step.weights, number),
});

/** The outputs by the names of the C interface, as lists of numbers. */
function outputs(value) {
  const kinds = { termination: 'termination', startKind: 'start', startState: 'endState', endState: 'endState' };
  const out = {};
  for (const [name, item] of Object.entries(value)) {
    if (name.startsWith('seconds')) continue;
    const field = snake(name).replace('cylinder', 'model');
    if (item?.point) {
      for (const part of ['point', 'direction', 'radius']) out[`${field}.${part}`] = [item[part]].flat();
    } else if (name === 'flags') {
      out.flags = [item.reduce((bits, flag) => bits | enumerations.flag[flag], 0)];
    } else if (typeof item === 'string') {
      out[field] = [enumerations[kinds[name] ?? name][item]];
    } else {
      out[field] = typeof item === 'object' ? Array.from(item) : [Number(item)];
    }
  }
  return out;
}

const region = (step) => ({ model: model(step.model), mask: image(step.mask) });

const calls = {
  set_options: (fitter, step) => fitter.setOptions(fields(step.options)),
  get_options: (fitter) => fitter.getOptions(),
  set_intrinsics: (fitter, step) => fitter.setIntrinsics(fields(file.cameras[step.camera])),
  set_start_model: (fitter, step) => fitter.setStartModel(model(step.model)),
  reserve: (fitter, step) => fitter.reserve(step.points, step.segments),
  clear: (fitter) => fitter.clear(),
  cancel: (fitter) => fitter.cancel(),
  push_points: (fitter, step) => fitter.pushPoints(points(step.points), image(step.mask)),
  push_depth: (fitter, step) => fitter.pushDepth(
    { ...image(step.depth), scale: step.scale, minDepth: step.min_depth, maxDepth: step.max_depth }, image(step.mask),
  ),
  push_image: (fitter, step) => fitter.pushImage(image(step.image)),
  push_edges: (fitter, step) => fitter.pushEdges(segments(step)),
  select_edges: (fitter, step) => ({
    selected: [...fitter.selectEdges(segments(step), { model: model(step.model), reach: step.reach })],
  }),
  counts: (fitter) => fitter.counts(),
  fit: (fitter) => fitter.fit(),
  get_result: (fitter) => fitter.result(),
  evaluate: (fitter, step) => fitter.evaluate(model(step.model)),
  residuals: (fitter, step) => ({ residuals: fitter.residuals(word(step.kind), model(step.model)) }),
  limb_samples(fitter) {
    const samples = fitter.limbSamples();
    const all = (name) => samples.flatMap((sample) => sample[name]);
    return { pixel: all('pixel'), sigma: all('sigma'), weight: all('weight'), limb: all('limb') };
  },
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
  project: (_, step) => ({
    lines: cylfuse.project(model(step.model), fields(file.cameras[step.camera])).flat(),
  }),
  compare: (_, step) => cylfuse.compare(model(step.a), model(step.b)),
};

function bits(value) {
  if (Number.isNaN(value)) return 'nan';
  const buffer = Buffer.alloc(8);
  buffer.writeDoubleBE(value);
  return buffer.toString('hex');
}

async function main() {
  for (const { name, steps } of file.cases) {
    const fitter = new cylfuse.Fitter();
    for (const [index, step] of steps.entries()) {
      const line = (...parts) => console.log([name, index, ...parts].join('\t'));
      try {
        const value = await calls[step.call](fitter, step);
        line('ok');
        for (const [field, list] of Object.entries(outputs(value ?? {}))) line(field, Array.from(list, bits).join(' '));
      } catch (error) {
        if (!(error instanceof cylfuse.CylfuseError)) throw error;
        line('error', error.code, error.message);
      }
    }
    fitter.close();
  }
}

main();

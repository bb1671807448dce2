'use strict';

const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const zlib = require('node:zlib');

/** The pixels of a grey PNG without interlacing, 8 or 16 bits each. */
function readPng(file) {
  const bytes = fs.readFileSync(file);
  const [width, height, bits] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20), bytes[24]];
  if (bytes[25] !== 0 || bytes[28] !== 0) throw new Error(`${file} is no plain grey image`);
  const packed = [];
  for (let at = 8; at < bytes.length; at += 12 + bytes.readUInt32BE(at)) {
    if (bytes.toString('latin1', at + 4, at + 8) === 'IDAT') {
      packed.push(bytes.subarray(at + 8, at + 8 + bytes.readUInt32BE(at)));
    }
  }
  const rows = zlib.inflateSync(Buffer.concat(packed));
  const step = bits / 8;
  const stride = width * step;
  const plain = Buffer.alloc(height * stride);
  for (let y = 0; y < height; y += 1) {
    const filter = rows[y * (stride + 1)];
    for (let x = 0; x < stride; x += 1) {
      const left = x < step ? 0 : plain[y * stride + x - step];
      const up = y === 0 ? 0 : plain[(y - 1) * stride + x];
      const corner = x < step || y === 0 ? 0 : plain[(y - 1) * stride + x - step];
      const nearest = [left, up, corner].map((value) => Math.abs(left + up - corner - value));
      const paeth = [left, up, corner][nearest.indexOf(Math.min(...nearest))];
      const guess = [0, left, up, (left + up) >> 1, paeth][filter];
      plain[y * stride + x] = rows[y * (stride + 1) + 1 + x] + guess;
    }
  }
  const data = bits === 8 ? new Uint8Array(plain) : Uint16Array.from({ length: width * height }, (_, i) => plain.readUInt16BE(2 * i));
  return { data, width, height };
}

/** A sample frame of the repository. */
function frame() {
  const folder = path.join(__dirname, '..', '..', '..', 'tests', 'data', 'frames', 'w004');
  const description = JSON.parse(fs.readFileSync(path.join(folder, 'frame.json'), 'utf8'));
  return {
    intrinsics: { ...description.camera, distortionModel: 'brown-conrady' },
    depth: { ...readPng(path.join(folder, 'depth.png')), scale: description.depth_scale },
    mask: readPng(path.join(folder, 'mask.png')),
    image: readPng(path.join(folder, 'image.png')),
    edges: Float64Array.from(description.edges.flat(2)),
  };
}

/** A quarter of a pipe of radius 0.5 along y, 200 points. */
function pipe() {
  const xyz = new Float64Array(600);
  for (let k = 0; k < 200; k += 1) {
    xyz.set([0.5 * Math.cos(0.008 * k), 0.1 * (k % 7), 2 - 0.5 * Math.sin(0.008 * k)], 3 * k);
  }
  return xyz;
}

const camera = { width: 160, height: 120, fx: 140, fy: 140, cx: 79.5, cy: 59.5 };

/** What the camera sees of an upright can of radius 40 mm and length 100 mm, its axis 0.5 m away, with its limbs. */
function can() {
  const { width, height } = camera;
  const depth = new Float32Array(width * height);
  const mask = new Uint8Array(width * height);
  for (let i = 0; i < depth.length; i += 1) {
    const x = ((i % width) - camera.cx) / camera.fx;
    const y = (Math.floor(i / width) - camera.cy) / camera.fy;
    // The ray z (x, y, 1) meets x² z² + (z - 0.5)² = 0.04².
    const z = (0.5 - Math.sqrt(0.25 - (1 + x * x) * (0.25 - 0.04 * 0.04))) / (1 + x * x);
    if (Math.abs(y * z) < 0.05) [depth[i], mask[i]] = [z, 1];
  }
  const limb = camera.fx * Math.tan(Math.asin(0.04 / 0.5));
  const edges = new Float64Array([-limb, limb].flatMap((u) => [camera.cx + u, 50, camera.cx + u, 70]));
  return { depth: { data: depth, width, height }, mask: { data: mask, width, height }, edges };
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Two cylinders before a wall: what a camera sees of them, the same as a cloud, and who is seen where (0 the wall). */
function pair() {
  const intrinsics = { width: 160, height: 120, fx: 170, fy: 170, cx: 79.5, cy: 59.5 };
  const { width, height } = intrinsics;
  const truths = [
    { point: [-0.12, 0, 0.7], direction: [0.1, 0.99, 0.1], radius: 0.05 },
    { point: [0.13, 0.05, 0.8], direction: [0.9, 0.3, 0.2], radius: 0.035 },
  ];
  const lengths = [0.24, 0.2];
  const seen = (column, row) => {
    const ray = [(column - intrinsics.cx) / intrinsics.fx, (row - intrinsics.cy) / intrinsics.fy, 1];
    let [depth, owner] = [1.2 / (1 + 0.1 * ray[0] - 0.2 * ray[1]), 0];
    for (const [number, { point, direction, radius }] of truths.entries()) {
      const norm = Math.sqrt(dot(direction, direction));
      const [along, middle] = [dot(ray, direction) / norm, dot(point, direction) / norm];
      const across = ray.map((x, k) => x - along * direction[k] / norm);
      const offset = point.map((x, k) => x - middle * direction[k] / norm);
      const [a, b] = [dot(across, across), dot(across, offset)];
      const z = (b - Math.sqrt(b * b - a * (dot(offset, offset) - radius * radius))) / a;
      if (Math.abs(z * along - middle) <= lengths[number] / 2 && z < depth) [depth, owner] = [z, number + 1];
    }
    return { depth, owner };
  };
  const depth = new Float32Array(width * height);
  const image = new Uint8Array(width * height);
  const points = new Float64Array(3 * width * height);
  const owners = new Uint8Array(width * height);
  let state = 1;
  for (let k = 0; k < depth.length; k += 1) {
    const [column, row] = [k % width, Math.floor(k / width)];
    const here = seen(column, row);
    owners[k] = here.owner;
    image[k] = 40;
    for (let ray = 0; ray < 16; ray += 1) {
      if (seen(column + ((ray % 4) - 1.5) / 4, row + (Math.floor(ray / 4) - 1.5) / 4).owner) image[k] += 10;
    }
    // Errors of up to 1 mm, evenly spread.
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    const z = here.depth + 0.001 * (state / 2147483648 - 1);
    depth[k] = z;
    points.set([z * (column - intrinsics.cx) / intrinsics.fx, z * (row - intrinsics.cy) / intrinsics.fy, z], 3 * k);
  }
  return {
    intrinsics, truths, lengths, owners, depth: { data: depth, width, height }, image: { data: image, width, height },
    points: { data: points, width, height },
  };
}

/** Takes out of the memory what nobody refers to, and lets the finalizers run. */
async function collect() {
  for (let round = 0; round < 3; round += 1) {
    global.gc();
    await new Promise((resolve) => { setImmediate(resolve); });
  }
}

/** Runs something that shall keep less than so much memory. A leak shows every time, what a collector is late with does not. */
async function memoryStaysFlat(megabytes, use) {
  const resident = () => process.memoryUsage().rss / 2 ** 20;
  let growth;
  for (let round = 0; round < 3; round += 1) {
    const before = resident();
    await use();
    growth = resident() - before;
    if (growth < megabytes) return;
  }
  assert.fail(`${growth.toFixed(1)} MB more`);
}

module.exports = { frame, pipe, pair, camera, can, collect, memoryStaysFlat };

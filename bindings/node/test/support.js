'use strict';

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

/** Takes out of the memory what nobody refers to, and lets the finalizers run. */
async function collect() {
  for (let round = 0; round < 3; round += 1) {
    global.gc();
    await new Promise((resolve) => { setImmediate(resolve); });
  }
}

module.exports = { frame, pipe, camera, can, collect };

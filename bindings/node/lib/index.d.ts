/**
 * Measures a cylinder (a pipe, a can, a shaft, a trunk) from RGB-D views.
 *
 * Lengths are in one unit, which is the caller's. Angles are in radians. The camera frame is x to the right, y down, z
 * forward, with its origin in the centre of projection. Poses lead from camera frames to the reference frame; with one
 * view at the identity, as at first, the two are the same. Pixel centres are at integer coordinates. NaN stands for
 * what does not apply. All strides count in numbers of the typed array, not bytes; 0 or none = packed.
 *
 * What the library refuses is a {@link CylfuseError}; a wrong type is a TypeError and an array that does not hold what
 * its description says a RangeError, both before the library is called. A call that fails changes nothing.
 */

import type {
  Cylinder, Depth, DepthCamera, Image, Input, Intrinsics, Mask, Options, Points, Pose, Region, Scalars, Segments, Start,
  Vector,
} from './data.js';
import type {
  Completion, Conformity, Counts, Diagnosis, EndSample, EndSource, EndState, Extent, Flag, Limb, LimbSample, LimbStatus,
  LogLevel, Part, Progress, Result, Termination,
} from './results.js';

export * from './data.js';
export * from './detector.js';
export * from './results.js';

/** The name of a status of the C interface. */
export type StatusName =
  | 'INVALID_ARGUMENT' | 'NULL_POINTER' | 'STRUCT_SIZE' | 'ABI_MISMATCH' | 'BAD_STATE' | 'BUSY' | 'BUFFER_TOO_SMALL'
  | 'OUT_OF_MEMORY' | 'UNSUPPORTED' | 'SIZE_MISMATCH' | 'INVALID_INTRINSICS' | 'TOO_FEW_POINTS' | 'PLANAR_POINTS'
  | 'COLLINEAR_POINTS' | 'EMPTY_MASK' | 'NO_DEPTH' | 'NO_START' | 'EDGE_GEOMETRY' | 'NUMERICAL' | 'CANCELLED' | 'PANIC';

declare global {
  interface SymbolConstructor {
    readonly dispose: unique symbol;
  }
}

/** What the library refused: the message says what was wrong, the value, the limit and the remedy. */
export class CylfuseError extends Error {
  /** The kind of the failure. */
  readonly code: StatusName;
  /** The number of the status in the C interface, negative. */
  readonly status: number;
}

/**
 * What one camera delivered at one time: any number of fitters use one frame without a copy, such as one for each
 * cylinder of a scene. A fitter takes what the frame holds at that time: what is set later, and `close`, change nothing
 * in fitters.
 */
export class Frame {
  constructor();
  /** Frees the frame; a second time does nothing. A forgotten one is freed by the garbage collector. */
  close(): void;
  /** The same, for `using frame = new Frame()`. */
  [Symbol.dispose](): void;
  /** Sets the colour camera; it comes before depth and image. */
  setIntrinsics(intrinsics: Intrinsics): void;
  /** Sets where the camera is in the reference frame; the identity at first. */
  setPose(pose: Pose): void;
  /** Gives the depth a camera of its own; null takes it away. */
  setDepthCamera(camera: DepthCamera | null): void;
  /** Sets the depth image, in place of an earlier one. */
  setDepth(depth: Depth): void;
  /** Sets the image, in place of an earlier one. */
  setImage(image: Image): void;
}

/**
 * Estimates one cylinder: holds options, views with their data, and the last result.
 *
 * It runs one call at a time: while an asynchronous fit is running, and from callbacks, every method but `cancel`
 * throws BUSY. Other fitters run in parallel. A fitter belongs to its thread: it cannot be handed to a worker. What is
 * called after `close` throws an Error.
 */
export class Fitter {
  constructor();
  /** Frees the fitter; a second time does nothing. A forgotten one is freed by the garbage collector. */
  close(): void;
  /** The same, for `using fitter = new Fitter()`. */
  [Symbol.dispose](): void;
  /** Makes room for the coordinates of that many more points and for that many more segments in the selected view. */
  reserve(points: number, segments?: number): void;
  /**
   * Forgets the data, all views but the first, its pose and the result; keeps options, the cameras of the first view, start
   * model, what the start `last` goes on from, callbacks and memory: the way from one frame to the next.
   */
  clear(): void;
  /** Forgets some of the data of the selected view, and keeps the rest and the last result. */
  clearInput(...inputs: Input[]): void;
  /**
   * Asks the running fit to stop, which then throws CANCELLED, unless it ends first. When none is running it does
   * nothing.
   */
  cancel(): void;
  /**
   * Another fitter with all that this one holds, settings, data and result, but no callbacks. Images are shared, points are
   * copied.
   */
  clone(): Fitter;
  /** Replaces the options: what is not given takes its default. */
  setOptions(options: Options): void;
  /** The options as they are. */
  getOptions(): Required<Options>;
  /**
   * Selects a view, so that the methods that set or push something, and those whose text says so, concern it. There is
   * one view at first, number 0, and it is selected; the number of views adds one, at the identity and without a
   * camera. A fit uses the data of all views, which see the same cylinder.
   */
  selectView(index: number): void;
  /** How many views there are, at least 1. */
  viewCount(): number;
  /** Sets where the camera of the selected view is in the reference frame; the identity at first. */
  setPose(pose: Pose): void;
  /** Sets the colour camera of the selected view, which depth images, images and edges need. */
  setIntrinsics(intrinsics: Intrinsics): void;
  /** The colour camera of the selected view, which was set or came with a frame; fails where it has none. */
  getIntrinsics(): Required<Intrinsics>;
  /**
   * Gives the depth of the selected view a camera of its own, for depth that is not registered to the colour image:
   * depth images that are pushed later are in its pixels. null takes it away.
   */
  setDepthCamera(camera: DepthCamera | null): void;
  /**
   * Lets the selected view take cameras, pose and images from a frame, in place of its own, and adds the points of the
   * depth image inside the mask. Points and segments that were pushed stay.
   */
  useFrame(frame: Frame, mask?: Mask | null): void;
  /** Sets a candidate in the reference frame for the start auto, the start of model; null takes it away. */
  setStartModel(model: Cylinder | null): void;
  /**
   * Sets what is called before every iteration; false stops the fit. What it throws, the fit throws, and a
   * TypeError where it returns a promise: it must not be async. A `fit` waits for the event loop to get to it.
   */
  setProgress(callback: ((progress: Progress) => boolean | void) | null): void;
  /** Sets what takes log lines up to a level. The rules of `setProgress` hold here too. */
  setLog(maxLevel: LogLevel, callback: ((level: LogLevel, message: string) => void) | null): void;
  /**
   * Adds points to the selected view: a typed array of x, y, z, or a description. The mask selects points of an
   * organised cloud.
   */
  pushPoints(points: Scalars | Points, mask?: Mask | null): void;
  /** Adds the points of a depth image of the selected view. Image and mask are kept for what follows a fit. */
  pushDepth(depth: Depth, mask?: Mask | null): void;
  /** Takes the image of the selected view, in which limbs and ends are located. */
  pushImage(image: Image): void;
  /** Adds edge segments to the selected view: a typed array of x1, y1, x2, y2, or a description. */
  pushEdges(edges: Scalars | Segments): void;
  /** What was pushed into the selected view since the fitter was made or cleared. */
  counts(): Counts;
  /** Estimates the cylinder on a thread of the pool of Node, which has 4, or UV_THREADPOOL_SIZE. */
  fit(): Promise<Result>;
  /** Estimates the cylinder on this thread. */
  fitSync(): Result;
  /** What a fit would report for a given model, without iterating. */
  evaluate(model: Cylinder): Result;
  /** The result of the last fit that succeeded. */
  result(): Result;
  /**
   * Signed distances in the selected view: of every used point from the surface, or of both endpoints of every used
   * segment in pixels.
   */
  residuals(kind: 'points' | 'edges', model?: Cylinder | null): Float64Array;
  /**
   * How much each point of the selected view counts at the cylinder of the last fit, from 1 down to 0 for an outlier,
   * in the order of the residuals; an inlier (1, else 0) is a point whose weight is above 0.
   */
  pointWeights(): { weights: Float64Array; inliers: Uint8Array };
  /**
   * What each point of the selected view belongs to, in the order of the residuals; without a model at the cylinder of the
   * last fit.
   */
  pointParts(model?: Cylinder | null): Part[];
  /** The two limbs of the last fit in each view, view after view; not searched once data or options have changed. */
  limbs(): Limb[];
  /** What the last fit saw of the limbs in the image of the selected view, used and refused. */
  limbSamples(): LimbSample[];
  /** The samples on the arcs of both ends that `extent` finds in the images, view after view. */
  endSamples(options?: Region): EndSample[];
  /** What the data determine at a model, by an orthogonal factorisation: more precise than `condition`, and slower. */
  diagnose(model?: Cylinder | null): Diagnosis;
  /**
   * Casts the ray of every pixel of the mask: x, y, z of point after point in the reference frame; organised: NaN for a
   * pixel without one.
   */
  complete<T extends Scalars = Float64Array>(
    options?: Region & { layout?: 'packed' | 'organised'; type?: new (length: number) => T },
  ): { points: T; completion: Completion };
  /** Writes the z of every completed point, in the camera frame of the selected view, into a depth image. */
  completeDepth<T extends Uint16Array | Float32Array = Float32Array>(
    options?: Region & { scale?: number; type?: new (length: number) => T },
  ): { depth: Depth<T>; completion: Completion };
  /**
   * The visible piece of the cylinder, and what its ends are: in views with a camera and a mask by the mask, in others by the
   * points on the surface.
   */
  extent(options?: Region): Extent;
  /**
   * Selects, of straight edges that a line detector found, those on the two limbs of a rough cylinder (none = that of
   * the last fit) beside the points that were pushed: 1 or 2 for the limb that a segment lies on, in the order of
   * {@link project}, 0 for none. A limb may be `reach` pixels from that of the model; 0 = 15 % of the distance of the
   * limbs, at least 4. Nothing is pushed, and weights are ignored.
   */
  selectEdges(edges: Scalars | Segments, options?: { model?: Cylinder | null; reach?: number }): Uint8Array;
}

/**
 * Fits many fitters, several at once and off the main thread, each as `fit` does, and gives their outcomes in order. Their
 * callbacks are not called. One that is busy has the error BUSY, and the others are fitted all the same; one that is there
 * twice is INVALID_ARGUMENT, and nothing is done.
 */
export function fitAll(
  fitters: Iterable<Fitter>,
  options?: {
    /** How many fits run at the same time. Default 0 = as many as the machine has processors. */
    threads?: number;
    /**
     * Is called after each fit with the index of its fitter and 'OK' or the code of its error; false stops the rest: each
     * that had not ended has the error CANCELLED.
     */
    progress?: ((index: number, status: 'OK' | StatusName) => unknown) | null;
  },
): Promise<(Result | CylfuseError)[]>;

/** Fits a cylinder to a cloud by the default options. For anything else there is {@link Fitter}. */
export function fitPoints(points: Scalars | Points): Promise<Result>;

/** Signed distances of points from the surface, negative inside; NaN for a point that is not finite. */
export function distances(cylinder: Cylinder, points: Scalars | Points): Float64Array;

/** The two limb lines in the image: a u + b v + c = 0 with a² + b² = 1, in ideal pixels. */
export function project(cylinder: Cylinder, intrinsics: Intrinsics): [Vector, Vector];

/**
 * The pixels of the (distorted) image at which a camera sees points of its frame, x and y of each; NaN for a point
 * that it cannot see.
 */
export function projectPoints(intrinsics: Intrinsics, points: Scalars | Points): Float64Array;

/**
 * The rays along which a camera sees pixels (x and y of each), as x, y and z = 1 of its frame; NaN where there is none.
 */
export function unprojectPixels(intrinsics: Intrinsics, pixels: Float64Array): Float64Array;

/** Limits, which conform themselves; one that is left out is none. `coverage` is the factor k, 2 where it is left out. */
export interface Tolerance { lower?: number; upper?: number; coverage?: number }

/**
 * Decides by the rule of ISO 14253-1 whether a length conforms to a tolerance: only where the value with `coverage` standard
 * deviations on either side lies within the limits, and not only where it lies outside. A deviation that is NaN, or 0 as of
 * a radius that the limits of the fit fix, decides nothing, nor do flags with a warning of which a deviation says nothing,
 * such as 'poor-fit' or 'radius-at-limit'. A wrong scale of the depth and wrong intrinsics are in no deviation.
 */
export function decideConformity(value: number, deviation: number, tolerance: Tolerance, flags?: Flag[]): Conformity;

/** Whether the radius of a result conforms to a tolerance, by its deviation and its warnings. */
export function radiusConforms(result: Result, tolerance: Tolerance): Conformity;

/** The same for the diameter, with limits of the diameter. */
export function diameterConforms(result: Result, tolerance: Tolerance): Conformity;

/** What each warning means: for every flag its name in C, a colon, and a few words. */
export function describeFlags(flags: Flag[]): string[];

/** What it means that an iteration ended so: the name in C, a colon, and a few words. */
export function describeTermination(termination: Termination): string;

/** What it means that an iteration starts or started so: the name in C, a colon, and a few words. */
export function describeStart(start: Start): string;

/** What the state of an end means: the name in C, a colon, and a few words. */
export function describeEndState(state: EndState): string;

/** What the source of the position of an end means: the name in C, a colon, and a few words. */
export function describeEndSource(source: EndSource): string;

/** What it means that a limb was located, or was not: the name in C, a colon, and a few words. */
export function describeLimbStatus(status: LimbStatus): string;

/** What it means that a point belongs to this: the name in C, a colon, and a few words. */
export function describePart(part: Part): string;

/** What a decision about a tolerance means: the name in C, a colon, and a few words. */
export function describeConformity(conformity: Conformity): string;

/** How two cylinders differ: angle and distance of the axes, (radius of b - radius of a) / radius of a. */
export function compare(a: Cylinder, b: Cylinder): { angle: number; axisDistance: number; radiusRelative: number };

/**
 * Standard deviations of radius (m), direction (rad), position of the axis (m) and length (m; NaN where an end lies outside
 * the image).
 */
export interface Deviations { radius: number; direction: number; position: number; length: number }

/**
 * What to expect of measurements of a cylinder with the middle of its axis on the optical axis: `scatter` is what captures of
 * one scene differ by, `total` what a fit states. Lengths are in metres; `tilt` is the angle of the axis out of the plane of
 * the image, `turn` its angle in the image from the vertical. `noise` has six numbers: a, b, c of the noise of depth
 * a + b z + c z^2; the side of the squares of pixels that share it; the noise of a pixel of the image as a part of the step
 * of brightness at limbs and ends; the blur of the image. Without it, it is that of structured light.
 */
export function plan(
  intrinsics: Intrinsics,
  cylinder: { distance: number; radius: number; length: number; tilt?: number; turn?: number },
  noise?: ArrayLike<number>,
): { scatter: Deviations; total: Deviations };

/** The version of the loaded library. */
export const version: string;

/** How the loaded library was built, for reports of defects. */
export const buildInfo: string;

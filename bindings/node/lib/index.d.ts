/**
 * Measures a cylinder (a pipe, a can, a shaft, a trunk) from one RGB-D view.
 *
 * Lengths are in one unit, which is the caller's. Angles are in radians. The camera frame is x to the right, y down, z
 * forward, with its origin in the centre of projection. Pixel centres are at integer coordinates. NaN stands for what
 * does not apply. All strides count in numbers of the typed array, not bytes; 0 or none = packed.
 *
 * What the library refuses is a {@link CylfuseError}; a wrong type is a TypeError and an array that does not hold what
 * its description says a RangeError, both before the library is called. A call that fails changes nothing.
 */

/** x, y, z. */
export type Vector = [number, number, number];

/** Numbers in an array of any kind. */
export type Numbers = readonly number[] | Float32Array | Float64Array;

/** An infinite cylinder. */
export interface Cylinder {
  /** A point on the axis. */
  point: Vector;
  /** The direction of the axis: as input of any length but 0, as output of length 1. Its sign has no meaning. */
  direction: Vector;
  /** The radius, greater than 0. */
  radius: number;
}

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
 * How a cylinder is estimated: points and edges together by an objective, points alone by plain least squares, random
 * sample consensus over the points, or Eberly's algebraic fit by their moments.
 */
export type Method = 'fused' | 'points' | 'ransac' | 'eberly';

/**
 * Where an iteration starts: the best of what follows, two limb segments scaled by the points, Eberly's fit, random
 * sample consensus, or the model of {@link Fitter.setStartModel}.
 */
export type Start = 'auto' | 'limbs' | 'moments' | 'ransac' | 'model';

/** The settings of a fit. */
export interface Options {
  /** How the cylinder is estimated. Default fused: points and edges together, by the objective. */
  method?: Method;
  /** What fused minimises: default robust; paper is that of Zhang, Liu and Wang, with exactly two segments. */
  objective?: 'robust' | 'paper';
  /** Where the iteration starts. Default auto. */
  start?: Start;
  /** Whether the points must lie on the wall that a camera at the origin sees. Default auto: on with intrinsics. */
  nearWall?: 'auto' | 'on' | 'off';
  /** The coordinates of the iteration. Default auto. */
  chart?: 'auto' | 'local' | 'orthonormal';
  /** What edge segments are for robust: default refine, a start for limbs located in the image; or the measurement. */
  edgeUse?: 'refine' | 'as-given';
  /** How the ends of the visible cylinder are found. Default auto. */
  extentRule?: 'auto' | 'extremes' | 'located';
  /** Most linear solves. Default 400. */
  maxIterations?: number;
  /** Most threads; the result has the same bits for any number. Default 0 = as many as the machine has. */
  maxThreads?: number;
  /** The weight of the edges in paper, in [0, 1]. Default 0.6. */
  edgeWeight?: number;
  /** Damping of the first step, greater than 0. Default 1e-3. */
  initialLambda?: number;
  /** Factor by which the damping changes, greater than 1. Default 10. */
  lambdaFactor?: number;
  /** Damping at which no smaller step is tried any more. Default 1e12. */
  maxLambda?: number;
  /** Smallest relative decrease of the cost that counts as progress, in [0, 1). Default 1e-12. */
  costTolerance?: number;
  /** Distance within which RANSAC counts a point as an inlier. Default 0 = from the data. */
  ransacThreshold?: number;
  /** Seed of the random samples, in [0, 2^64). Default 0. */
  seed?: number | bigint;
  /** Most random samples. Default 1000. */
  ransacMaxIterations?: number;
  /** The smallest radius of the returned cylinder. Default 0 = no limit. */
  radiusMin?: number;
  /** The largest radius, equal to radiusMin for a known one. Default 0 = no limit. */
  radiusMax?: number;
  /** The middle of the cone of directions that the returned axis keeps. Default [0, 0, 0] = all directions. */
  axis?: Numbers;
  /** The largest angle of the axis from `axis`, from 0 to pi/2; 0 for a known direction. */
  axisMaxAngle?: number;
}

/** A camera as a calibration gives it. */
export interface Intrinsics {
  /** Width of the image in pixels. */
  width: number;
  /** Height of the image in pixels. */
  height: number;
  /** Focal length in pixel widths, greater than 0. */
  fx: number;
  /** Focal length in pixel heights, greater than 0. */
  fy: number;
  /** Principal point from the centre of the first pixel, to the right. */
  cx: number;
  /** Principal point from the centre of the first pixel, down. */
  cy: number;
  /** What the coefficients mean. Default none. */
  distortionModel?: 'none' | 'brown-conrady' | 'kannala-brandt';
  /** At most 8 coefficients in the order of OpenCV. Default none. */
  distortion?: Numbers;
}

/** Coordinates. */
export type Scalars = Float32Array | Float64Array;

/** A cloud. */
export interface Points<T extends Scalars = Scalars> {
  /** x, y, z of the first point at the beginning. */
  data: T;
  /** Columns of an organised cloud, or the number of points; without width and height all that data hold. */
  width?: number;
  /** Rows of an organised cloud. Default 1. */
  height?: number;
  /** From a point to the next one in its row. Default 3. */
  pointStride?: number;
  /** From a row to the next one. Default width * pointStride. */
  rowStride?: number;
  /** A weight for each point, 0 or greater; 0 drops the point. */
  weights?: T | null;
  /** From a weight to the next one in its row. Default 1. */
  weightStride?: number;
  /** From a row of weights to the next one. Default width * weightStride. */
  weightRowStride?: number;
  /** A normal for each point, of any length and sign. Only RANSAC uses them. */
  normals?: T | null;
  /** From a normal to the next one in its row. Default 3. */
  normalStride?: number;
  /** From a row of normals to the next one. Default width * normalStride. */
  normalRowStride?: number;
}

/** Pixels in memory. */
export interface Pixels<T> {
  /** The first row at the beginning. */
  data: T;
  /** Columns; those of the intrinsics. */
  width: number;
  /** Rows; those of the intrinsics. */
  height: number;
  /** From a row to the next one. Default width * pixelStride. */
  rowStride?: number;
  /** From a pixel to the next one in its row. Default 1. */
  pixelStride?: number;
}

/** A depth image of the camera: z, not the distance along the ray; 0 = no measurement. */
export interface Depth<T = Uint16Array | Float32Array> extends Pixels<T> {
  /** Length of one unit of the stored value. Default 1. */
  scale?: number;
  /** The nearest depth that counts. Default 0. */
  minDepth?: number;
  /** The farthest depth that counts. Default 0 = no limit. */
  maxDepth?: number;
}

/** A grey image of the camera. With pixelStride 3 the first channel of packed colours. */
export interface Image extends Pixels<Uint8Array | Uint8ClampedArray | Uint16Array | Float32Array> {
  /** The power of the value that is light: 2.2 for sRGB, in which cameras and image files usually come. Default 1. */
  gamma?: number;
}

/** Non-zero = visible lateral surface of the cylinder. */
export type Mask = Pixels<Uint8Array | Uint8ClampedArray>;

/** Pieces of the two lines that bound the cylinder in the (distorted) image, in pixels. */
export interface Segments {
  /** x1, y1, x2, y2 of segment after segment. */
  data: Scalars;
  /** From a segment to the next one. Default 4. */
  stride?: number;
  /** A weight for each segment, from 0 to 1e9; 0 leaves it out. */
  weights?: Float64Array | null;
}

/** A doubt about a result. */
export type Flag =
  | 'edges-ignored' | 'segments-unusable' | 'edges-cross' | 'edges-coincide' | 'edges-behind' | 'scale-held'
  | 'weak-radius' | 'resolution-lost' | 'not-converged' | 'hidden-wall' | 'camera-inside' | 'points-not-finite'
  | 'points-and-limbs-disagree' | 'radius-at-limit' | 'axis-at-limit';

/** The outcome of a fit with the numbers to judge it. */
export interface Result {
  /** Its axis point is the one nearest to the middle of the points. */
  cylinder: Cylinder;
  /** The model that the iteration started from, moved into the limits. */
  startCylinder: Cylinder;
  /** Why the iteration ended. */
  termination: 'none' | 'cost' | 'stalled' | 'max-iterations' | 'radius-ran-away';
  /** How the start was found. */
  startKind: Start;
  /** Doubts; none of them is an error. */
  flags: Flag[];
  /** Linear solves. */
  iterations: number;
  /** Solves whose step was rejected. */
  rejectedSteps: number;
  /** Segments that took part. */
  segmentsUsed: number;
  /** Segments that were pushed. */
  segmentsGiven: number;
  /** Points that took part. */
  pointsUsed: number;
  /** Points that were pushed; the counts say why the others were left out. */
  pointsGiven: number;
  /** Cost of the start, unit of length squared. */
  initialCost: number;
  /** Cost of the cylinder, unit of length squared. */
  cost: number;
  /** E_P: mean squared distance of the points from the surface. */
  energyPoints: number;
  /** E_L: mean squared distance of the back-projected endpoints from the limb lines. */
  energyEdges: number;
  /** The edge weight that was used, 0 when no edges count; NaN where the objective has none. */
  edgeWeight: number;
  /** Root of E_P. */
  pointRms: number;
  /** Root mean square distance of the endpoints from the limb lines in ideal pixels. */
  edgeRmsPixels: number;
  /** The part of the points on the wall that the camera sees. */
  nearWallFraction: number;
  /** Condition number of the Jacobian, in units of the size of the data. */
  condition: number;
  /** The last damping. */
  lambda: number;
  /** Norm of half the gradient of the cost at the end, in units of the size of the data. */
  gradientNorm: number;
  /** Norm of the last accepted step, in units of the size of the data. */
  stepNorm: number;
  /** Wall-clock seconds to find the start. */
  secondsStart: number;
  /** Wall-clock seconds to iterate. */
  secondsSolve: number;
  /** Wall-clock seconds of the whole fit. */
  secondsTotal: number;
  /** Standard deviation of the radius by the noise of the data. */
  radiusDeviation: number;
  /** Standard deviation of the direction in radians, where it is least certain. */
  directionDeviation: number;
  /** Standard deviation of the axis across itself at cylinder.point, where it is least certain. */
  positionDeviation: number;
  /** The radius by the curvature of the points alone. */
  radiusFromPoints: number;
  /** Its standard deviation. */
  radiusFromPointsDeviation: number;
  /** The radius by the limbs, with distance and tilt of the axis from the points. */
  radiusFromLimbs: number;
  /** Its standard deviation. */
  radiusFromLimbsDeviation: number;
  /** The difference of the two in standard deviations. */
  radiusZScore: number;
  /** Covariance of (point, direction, radius), 7 x 7 row by row. */
  covariance: Float64Array;
  /** Limb lines that were located in the grey image and took part, 0 to 2. */
  limbsLocated: number;
}

/** What was pushed, and what was left out by reason. */
export interface Counts {
  /** Points and pixels that were pushed. */
  pointsGiven: number;
  /** Points that a fit uses. */
  pointsUsed: number;
  /** A coordinate or weight is not finite. */
  droppedNotFinite: number;
  /** The weight is 0. */
  droppedZeroWeight: number;
  /** The mask is 0 there. */
  droppedOutsideMask: number;
  /** No depth was measured there. */
  droppedNoDepth: number;
  /** The depth is below minDepth or above maxDepth. */
  droppedOutOfRange: number;
  /** The camera model has no ray for the pixel. */
  droppedOutsideCamera: number;
  /** Edge segments that were pushed. */
  segmentsGiven: number;
}

/** What a short piece of a limb in the grey image says. */
export interface LimbSample {
  /** Where the limb is seen, x and y. */
  pixel: [number, number];
  /** Standard deviation across the limb in ideal pixels. */
  sigma: number;
  /** What the sample counted, from 1 down to 0 for a refused one. */
  weight: number;
  /** The limb that it belongs to, 0 or 1. */
  limb: number;
}

/** What the data determine at a cylinder. */
export interface Diagnosis {
  /** 5 when everything is determined. */
  rank: number;
  /** Of the Jacobian, the largest first. */
  singularValues: number[];
  /** The largest over the smallest singular value; may be infinite. */
  condition: number;
  /** How the step along which the residuals change least moves the axis, */
  weakestShift: Vector;
  /** tilts it, in radians, */
  weakestTilt: Vector;
  /** and changes the radius. */
  weakestRadius: number;
}

/** What became of the pixels of a completion. */
export interface Completion {
  /** Points or pixels that were written. */
  count: number;
  /** Pixels of the mask whose ray meets the cylinder. */
  hits: number;
  /** Pixels of the mask whose ray passes the cylinder by. */
  misses: number;
  /** Pixels of the mask for which the camera model has no ray. */
  outsideCamera: number;
  /** Hits whose depth does not fit the pixel format: written as 0. */
  outOfRange: number;
}

/** What an end is: not known, the end of the surface, cut off by the border of the image, or covered. */
export type EndState = 'unknown' | 'seen' | 'cut' | 'hidden';

/** The visible piece of the cylinder: end = start + length * direction. */
export interface Extent {
  /** What the end against the direction is. */
  startState: EndState;
  /** What the end along the direction is. */
  endState: EndState;
  /** The end against the direction, a point on the axis. */
  start: Vector;
  /** The end along the direction, a point on the axis. */
  end: Vector;
  /** The middle of the ends. */
  center: Vector;
  /** The distance of the ends. */
  length: number;
  /** Standard deviation of the position of the start along the axis, for a model without error. */
  startDeviation: number;
  /** The same for the end. */
  endDeviation: number;
  /** Standard deviation of the length together with the uncertainty of the fit; NaN for a model that was given. */
  lengthDeviation: number;
  /** Covariance of the start, 3 x 3 row by row; NaN likewise, as the other two. */
  startCovariance: Float64Array;
  /** Covariance of the end. */
  endCovariance: Float64Array;
  /** Covariance of the center. */
  centerCovariance: Float64Array;
}

/** The state of a running fit, before each linear solve. */
export interface Progress {
  /** What the fit is doing: looking for a start, or iterating. */
  phase: 'start' | 'solve';
  /** Linear solves, from 0 with every start that is tried and every robust round. */
  iteration: number;
  /** The most linear solves. */
  maxIterations: number;
  /** The lowest so far, unit of length squared; infinite in the phase start. */
  cost: number;
  /** The damping of the next step; 0 in the phase start. */
  lambda: number;
  /** The best so far, of radius 0 in the phase start. */
  cylinder: Cylinder;
}

/** How much a log line matters: calls that failed, doubts, what was done, every iteration. */
export type LogLevel = 'off' | 'error' | 'warning' | 'info' | 'debug';

/** A model and where it is looked at. */
export interface Region {
  /** Default: that of the last fit. */
  model?: Cylinder | null;
  /** Default: that of the last depth image. */
  mask?: Mask | null;
}

/**
 * Estimates one cylinder: holds options, camera, data and the last result.
 *
 * It runs one call at a time: while an asynchronous fit is running, and from callbacks, every method but `cancel` throws
 * BUSY. Other fitters run in parallel. A fitter belongs to its thread: it cannot be handed to a worker. What is called
 * after `close` throws an Error.
 */
export class Fitter {
  constructor();
  /** Frees the fitter; a second time does nothing. A forgotten one is freed by the garbage collector. */
  close(): void;
  /** The same, for `using fitter = new Fitter()`. */
  [Symbol.dispose](): void;
  /** Makes room, so that pushing that many more points and segments needs no memory. */
  reserve(points: number, segments?: number): void;
  /** Forgets data, result and a pending request to cancel: the way from one frame to the next. */
  clear(): void;
  /** Asks the running fit to stop, which then throws CANCELLED; when none is running, the next one. */
  cancel(): void;
  /** Replaces the options: what is not given takes its default. */
  setOptions(options: Options): void;
  /** The options as they are. */
  getOptions(): Required<Options>;
  /** Sets the camera, which depth images and edges need. */
  setIntrinsics(intrinsics: Intrinsics): void;
  /** Sets a candidate for the start auto, the start of model; null takes it away. */
  setStartModel(model: Cylinder | null): void;
  /**
   * Sets what hears of every linear solve; false stops the fit. What it throws, the fit throws. A `fit` waits for the
   * event loop to get to it.
   */
  setProgress(callback: ((progress: Progress) => boolean | void) | null): void;
  /** Sets what takes log lines up to a level. The rules of `setProgress` hold here too. */
  setLog(maxLevel: LogLevel, callback: ((level: LogLevel, message: string) => void) | null): void;
  /** Adds points: a typed array of x, y, z, or a description. The mask selects points of an organised cloud. */
  pushPoints(points: Scalars | Points, mask?: Mask | null): void;
  /** Adds the points of a depth image; intrinsics come before. Image and mask are kept for what follows a fit. */
  pushDepth(depth: Depth, mask?: Mask | null): void;
  /** Takes the grey image, in which limbs and ends are located. */
  pushImage(image: Image): void;
  /** Adds edge segments: a typed array of x1, y1, x2, y2, or a description. */
  pushEdges(edges: Scalars | Segments): void;
  /** What was pushed since the fitter was made or cleared. */
  counts(): Counts;
  /** Estimates the cylinder on a thread of the pool of Node, which has 4, or UV_THREADPOOL_SIZE. */
  fit(): Promise<Result>;
  /** Estimates the cylinder on this thread. */
  fitSync(): Result;
  /** What a fit would report for a given model, without iterating. */
  evaluate(model: Cylinder): Result;
  /** The result of the last fit that succeeded. */
  result(): Result;
  /** Signed distances: of every used point from the surface, or of both endpoints of every used segment in pixels. */
  residuals(kind: 'points' | 'edges', model?: Cylinder | null): Float64Array;
  /** What the last fit saw of the limbs in the grey image, used and refused; none when the image was not searched. */
  limbSamples(): LimbSample[];
  /** What the data determine at a model, by an orthogonal factorisation: more precise than `condition`, and slower. */
  diagnose(model?: Cylinder | null): Diagnosis;
  /** Casts the ray of every pixel of the mask: x, y, z of point after point; organised: NaN for a pixel without one. */
  complete<T extends Scalars = Float64Array>(
    options?: Region & { layout?: 'packed' | 'organised'; type?: new (length: number) => T },
  ): { points: T; completion: Completion };
  /** Writes the z of every completed point into a depth image. */
  completeDepth<T extends Uint16Array | Float32Array = Float32Array>(
    options?: Region & { scale?: number; type?: new (length: number) => T },
  ): { depth: Depth<T>; completion: Completion };
  /** The visible piece of the cylinder and what its ends are. */
  extent(options?: Region): Extent;
  /**
   * Selects, of straight edges that a line detector found, those on the two limbs of a rough cylinder (none = that of the
   * last fit) beside the points that were pushed: 1 or 2 for the limb that a segment lies on, in the order of
   * {@link project}, 0 for none. A limb may be `reach` pixels from that of the model; 0 = 15 % of the distance of the
   * limbs, at least 4. Nothing is pushed, and weights are ignored.
   */
  selectEdges(edges: Scalars | Segments, options?: { model?: Cylinder | null; reach?: number }): Uint8Array;
}

/** Fits a cylinder to a cloud by the default options. For anything else there is {@link Fitter}. */
export function fitPoints(points: Scalars | Points): Promise<Result>;

/** Signed distances of points from the surface, negative inside; NaN for a point that is not finite. */
export function distances(cylinder: Cylinder, points: Scalars | Points): Float64Array;

/** The two limb lines in the image: a u + b v + c = 0 with a² + b² = 1, in ideal pixels. */
export function project(cylinder: Cylinder, intrinsics: Intrinsics): [Vector, Vector];

/** How two cylinders differ: angle and distance of the axes, (radius of b - radius of a) / radius of a. */
export function compare(a: Cylinder, b: Cylinder): { angle: number; axisDistance: number; radiusRelative: number };

/** The version of the loaded library. */
export const version: string;

/** How the loaded library was built, for reports of defects. */
export const buildInfo: string;

// What comes out of a fit.

import type { Cylinder, Start, Vector } from './data.js';

/** A warning about a result. */
export type Flag =
  | 'edges-ignored' | 'segments-unusable' | 'edges-cross' | 'edges-coincide' | 'edges-behind' | 'scale-held'
  | 'weak-radius' | 'resolution-lost' | 'not-converged' | 'hidden-wall' | 'camera-inside' | 'points-not-finite'
  | 'points-and-limbs-disagree' | 'radius-at-limit' | 'axis-at-limit' | 'uncertainty-unknown'
  | 'depth-shifted' | 'mask-ends-with-depth' | 'poor-fit'
  | 'body-tapers' | 'mask-disagrees';

/**
 * Why an iteration ended: there was none; the cost no longer fell; no step lowered it; the limit of iterations; the data are
 * flat; gradient or step fell below its tolerance.
 */
export type Termination = 'none' | 'cost' | 'stalled' | 'max-iterations' | 'radius-ran-away' | 'gradient' | 'step';

/** The outcome of a fit: the cylinder, how certain it is, and the numbers to judge it. Deviations are standard ones. */
export interface Result {
  /** In the reference frame; its axis point is the one nearest to the middle of the points. */
  cylinder: Cylinder;
  /** The cylinder that the iteration started from, moved into the limits. */
  startCylinder: Cylinder;
  /** How the start was found. */
  startKind: Start;
  /**
   * Standard deviation of the radius. This and what follows is that of the noise of the data. With the method `fused` and
   * the objective `robust` it also has the errors that all points of a view share and `depthShared` of the options states,
   * by default 0.2 % of the depth. Errors of the calibration, the registration and a scale of the depth are not in it.
   */
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
  /** Warnings; none of them is an error. */
  flags: Flag[];
  /** Why the iteration ended. */
  termination: Termination;
  /** Iterations: linear systems that were solved. */
  iterations: number;
  /** Solves whose step was rejected. */
  rejectedSteps: number;
  /** Limb lines that were located in the images and took part, at most 2 a view. */
  limbsLocated: number;
  /** Segments that were pushed. */
  segmentsGiven: number;
  /** Segments that took part. */
  segmentsUsed: number;
  /** Points that were pushed; the counts say why some were left out. */
  pointsGiven: number;
  /** Points that took part. */
  pointsUsed: number;
  /** How many points with independent noise the points of all views are worth. */
  independentPoints: number;
  /** Standard deviation of the points from the surface by their median. */
  pointDeviation: number;
  /** Root mean square distance of the points from the surface. */
  pointRms: number;
  /** Root mean square distance of the given endpoints from the limb lines in ideal pixels. */
  edgeRmsPixels: number;
  /** The part of the points on the wall that the camera sees. */
  nearWallFraction: number;
  /** Cost of the start, unit of length squared. */
  initialCost: number;
  /** Cost of the outcome, unit of length squared. */
  cost: number;
  /** E_P: mean squared distance of the points from the surface. */
  energyPoints: number;
  /** E_L: mean squared distance of the back-projected endpoints from the limb lines. */
  energyEdges: number;
  /** The edge weight that was used, 0 when no edges count; NaN where the objective has none. */
  edgeWeight: number;
  /** Condition number of the Jacobian, in units of the size of the data. */
  condition: number;
  /** Norm of half the gradient of the cost at the end, in units of the size of the data. */
  gradientNorm: number;
  /** Norm of the last accepted step, in units of the size of the data. */
  stepNorm: number;
  /** The last damping. */
  lambda: number;
  /** Wall-clock seconds to find the start. */
  secondsStart: number;
  /** Wall-clock seconds to iterate. */
  secondsSolve: number;
  /** Wall-clock seconds of the whole fit. */
  secondsTotal: number;
}

/** What was pushed into one view, and what was left out by reason. */
export interface Counts {
  /** The view that the counts are of. */
  view: number;
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
  /** The mask is set there, but the colour camera sees something nearer. Only with a depth camera of its own. */
  droppedHidden: number;
  /** Edge segments that were pushed. */
  segmentsGiven: number;
}

/**
 * What a measurement says about a tolerance. 'undecided': its uncertainty reaches over a limit or is not known, or a warning
 * puts it in doubt.
 */
export type Conformity = 'undecided' | 'conforming' | 'not-conforming';

/**
 * What a point in the mask belongs to: the lateral surface; a cap, in the plane across the axis at an end; the inside, seen
 * through an open end; something nearer, as a wider lid, a handle or what stands in front; the background.
 */
export type Part = 'body' | 'cap' | 'inner-wall' | 'other' | 'behind';

/** Whether a limb was located in the image, or why not. */
export type LimbStatus =
  | 'located' | 'not-searched' | 'no-limbs' | 'too-short' | 'no-edge' | 'out-of-reach' | 'uncertain' | 'patchy'
  | 'same-line';

/** A limb of the cylinder in the image of one view: where it was located, or why it was not. */
export interface Limb {
  /** From 0. */
  view: number;
  /** 0 or 1, in the order of {@link project}. */
  limb: number;
  /** Whether it was located, or why not. */
  status: LimbStatus;
  /** How many pieces of it `limbSamples` lists. */
  samples: number;
  /**
   * x1, y1, x2, y2: the two points of the located line whose errors across it are independent and equally large, in
   * ideal pixels. NaN when it was not located.
   */
  line: [number, number, number, number];
  /** Standard deviation of either point across the line, in ideal pixels. */
  deviation: number;
}

/** What a short piece of a limb in the image says. */
export interface LimbSample {
  /** From 0. */
  view: number;
  /** The limb that it belongs to, 0 or 1, in the order of {@link project}. */
  limb: number;
  /** Where the limb is seen, x and y. */
  pixel: [number, number];
  /** Standard deviation across the limb in ideal pixels, by the noise of the image only. */
  deviation: number;
  /** Its part in the line, from 1 down to 0 for a refused one. */
  weight: number;
}

/** A sample on the arc of an end of the cylinder in the image. */
export interface EndSample {
  /** From 0. */
  view: number;
  /** 0 for the start of the extent, 1 for its end. */
  end: number;
  /** Where the arc is seen, x and y. */
  pixel: [number, number];
  /** The unit vector across the arc in the image, away from the surface. */
  normal: [number, number];
  /** Standard deviation along the normal, in pixels. */
  deviation: number;
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
  /** The view whose pixels were completed. */
  view: number;
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

/**
 * What the position of an end was taken from. extreme: the extreme point completed over the mask. mask: where the lines along
 * the surface leave the mask, or where within the mask the depth shows that the body ends (at a cap, an opening, a shoulder or a
 * narrower part); also where the image shows an arc that is less certain than that. image: mostly the arc of the end circle
 * in the image. border: the last of the surface inside the border of the image. points: the points on the surface, where
 * there is no mask, and from inside a pipe.
 */
export type EndSource = 'extreme' | 'mask' | 'image' | 'border' | 'points';

/** The visible piece of the cylinder, in the reference frame: end = start + length * direction. */
export interface Extent {
  /** What the end against the direction is. */
  startState: EndState;
  /** What the end along the direction is. */
  endState: EndState;
  /** What the position of the start was taken from. */
  startSource: EndSource;
  /** What the position of the end was taken from. */
  endSource: EndSource;
  /** The view that tells most of the start. */
  startView: number;
  /** The view that tells most of the end. */
  endView: number;
  /**
   * Whether the limbs were taken as good to a fraction of a pixel, so that the bias of the mask was read off at them.
   */
  limbsKnown: boolean;
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

/** The state of a running fit, before each iteration. */
export interface Progress {
  /**
   * What the fit is doing: looking for a start, or iterating. In both it may only ask whether to go on; when it iterates, the
   * last state is reported again then.
   */
  phase: 'start' | 'solve';
  /** Iterations, from 0 with every start that is tried and every robust round. */
  iteration: number;
  /** The maximum number of iterations. */
  maxIterations: number;
  /** The lowest so far, unit of length squared; infinite in the phase start. */
  cost: number;
  /** The damping of the next step; 0 in the phase start. */
  lambda: number;
  /** The best so far; null in the phase start. */
  cylinder: Cylinder | null;
}

/** How much a log line matters: calls that failed, warnings, what was done, every iteration. */
export type LogLevel = 'off' | 'error' | 'warning' | 'info' | 'debug';

'use strict';
// The C interface: where the library is, its structs and its functions. include/cylfuse/cylfuse.h is the manual.

const path = require('node:path');
const koffi = require('koffi');

const ABI_VERSION = 1;
// The oldest library that knows every field of the structs below: major * 65536 + minor * 256 + patch.
const OLDEST_VERSION = 0x000200;

const pointer = koffi.pointer;
const vector = koffi.array('double', 3);
const matrix = koffi.array('double', 9);

// Anonymous, so that two copies of this package may be in one program.
const Handle = pointer(koffi.opaque());

const Cylinder = koffi.struct({ point: vector, direction: vector, radius: 'double' });

const Intrinsics = koffi.struct({
  struct_size: 'uint32_t', distortion_model: 'int32_t', width: 'uint32_t', height: 'uint32_t', fx: 'double',
  fy: 'double', cx: 'double', cy: 'double', distortion: koffi.array('double', 8),
});

const PointsView = koffi.struct({
  struct_size: 'uint32_t', scalar: 'int32_t', data: 'void *', width: 'size_t', height: 'size_t',
  point_stride: 'intptr_t', row_stride: 'intptr_t', weights: 'void *', weight_stride: 'intptr_t',
  weight_row_stride: 'intptr_t', normals: 'void *', normal_stride: 'intptr_t', normal_row_stride: 'intptr_t',
});

const PointsOut = koffi.struct({
  struct_size: 'uint32_t', scalar: 'int32_t', data: 'void *', capacity: 'size_t', point_stride: 'intptr_t',
  row_stride: 'intptr_t',
});

const DepthView = koffi.struct({
  struct_size: 'uint32_t', format: 'int32_t', data: 'void *', width: 'uint32_t', height: 'uint32_t',
  row_stride: 'intptr_t', pixel_stride: 'intptr_t', scale: 'double', min_depth: 'double', max_depth: 'double',
});

const DepthOut = koffi.struct({
  struct_size: 'uint32_t', format: 'int32_t', data: 'void *', width: 'uint32_t', height: 'uint32_t',
  row_stride: 'intptr_t', pixel_stride: 'intptr_t', scale: 'double',
});

const MaskView = koffi.struct({
  struct_size: 'uint32_t', width: 'uint32_t', height: 'uint32_t', label: 'uint32_t', data: 'void *',
  row_stride: 'intptr_t', pixel_stride: 'intptr_t',
});

const ImageView = koffi.struct({
  struct_size: 'uint32_t', format: 'int32_t', data: 'void *', width: 'uint32_t', height: 'uint32_t',
  row_stride: 'intptr_t', pixel_stride: 'intptr_t', gamma: 'double',
});

const SegmentsView = koffi.struct({
  struct_size: 'uint32_t', scalar: 'int32_t', data: 'void *', count: 'size_t', segment_stride: 'intptr_t',
  weights: 'void *',
});

const Options = koffi.struct({
  struct_size: 'uint32_t', method: 'int32_t', objective: 'int32_t', start: 'int32_t', near_wall: 'int32_t',
  chart: 'int32_t', edge_use: 'int32_t', extent_rule: 'int32_t', max_threads: 'uint32_t', max_iterations: 'uint32_t',
  cost_tolerance: 'double', gradient_tolerance: 'double', step_tolerance: 'double', initial_lambda: 'double',
  lambda_factor: 'double', max_lambda: 'double', edge_weight: 'double', seed: 'uint64_t',
  ransac_max_iterations: 'uint64_t', ransac_threshold: 'double', independent_points: 'double', depth_noise: 'double',
  image_noise: 'double', edge_noise: 'double', mask_noise: 'double', image_blur: 'double', drawn_pixel: 'double',
  radius_min: 'double', radius_max: 'double', axis: vector, axis_max_angle: 'double', depth_shared: 'double',
});

const DetectorOptions = koffi.struct({
  struct_size: 'uint32_t', image_use: 'int32_t', max_threads: 'uint32_t', max_count: 'uint32_t',
  min_pixels: 'uint64_t', min_score: 'double', radius_min: 'double', radius_max: 'double', axis: vector,
  axis_max_angle: 'double',
});

const Counts = koffi.struct({
  struct_size: 'uint32_t', view: 'uint32_t', points_given: 'uint64_t', points_used: 'uint64_t',
  dropped_not_finite: 'uint64_t', dropped_zero_weight: 'uint64_t', dropped_outside_mask: 'uint64_t',
  dropped_no_depth: 'uint64_t', dropped_out_of_range: 'uint64_t', dropped_outside_camera: 'uint64_t',
  dropped_hidden: 'uint64_t', segments_given: 'uint64_t',
});

const Result = koffi.struct({
  struct_size: 'uint32_t', flags: 'uint32_t', termination: 'int32_t', iterations: 'uint32_t',
  rejected_steps: 'uint32_t', limbs_located: 'uint32_t', segments_given: 'uint32_t', segments_used: 'uint32_t',
  points_given: 'uint64_t', points_used: 'uint64_t', independent_points: 'double', point_deviation: 'double',
  point_rms: 'double', edge_rms_pixels: 'double', near_wall_fraction: 'double', initial_cost: 'double', cost: 'double',
  energy_points: 'double', energy_edges: 'double', edge_weight: 'double', condition: 'double', gradient_norm: 'double',
  step_norm: 'double', lambda: 'double', seconds_start: 'double', seconds_solve: 'double', seconds_total: 'double',
});

const CylinderEstimate = koffi.struct({
  struct_size: 'uint32_t', start_kind: 'int32_t', model: Cylinder, start_model: Cylinder, radius_deviation: 'double',
  direction_deviation: 'double', position_deviation: 'double', radius_from_points: 'double',
  radius_from_points_deviation: 'double', radius_from_limbs: 'double', radius_from_limbs_deviation: 'double',
  radius_z_score: 'double', covariance: koffi.array('double', 49),
});

const CylinderDiagnosis = koffi.struct({
  struct_size: 'uint32_t', rank: 'uint32_t', singular_values: koffi.array('double', 5), condition: 'double',
  weakest_shift: vector, weakest_tilt: vector, weakest_radius: 'double',
});

const Completion = koffi.struct({
  struct_size: 'uint32_t', view: 'uint32_t', count: 'uint64_t', hits: 'uint64_t', misses: 'uint64_t',
  outside_camera: 'uint64_t', out_of_range: 'uint64_t',
});

const Extent = koffi.struct({
  struct_size: 'uint32_t', start_state: 'int32_t', end_state: 'int32_t', start_source: 'int32_t', end_source: 'int32_t',
  start_view: 'uint32_t', end_view: 'uint32_t', limbs_known: 'uint32_t', start: vector, end: vector, center: vector,
  length: 'double', start_deviation: 'double', end_deviation: 'double', length_deviation: 'double',
  start_covariance: matrix, end_covariance: matrix, center_covariance: matrix,
});

const Progress = koffi.struct({
  struct_size: 'uint32_t', phase: 'int32_t', iteration: 'uint32_t', max_iterations: 'uint32_t', cost: 'double',
  lambda: 'double', cylinder: 'void *',
});

const DetectionProgress = koffi.struct({
  struct_size: 'uint32_t', phase: 'int32_t', fits_done: 'uint32_t', fits: 'uint32_t',
});

const Detection = koffi.struct({ score: 'double', pixels: 'uint64_t', model: Cylinder });

const Limb = koffi.struct({
  view: 'uint32_t', limb: 'uint32_t', status: 'int32_t', samples: 'uint32_t', line: koffi.array('double', 4),
  deviation: 'double',
});

const LimbSample = koffi.struct({
  view: 'uint32_t', limb: 'uint32_t', pixel: koffi.array('double', 2), deviation: 'double', weight: 'double',
});

const EndSample = koffi.struct({
  view: 'uint32_t', end: 'uint32_t', pixel: koffi.array('double', 2), normal: koffi.array('double', 2),
  deviation: 'double',
});

const ProgressCallback = pointer(koffi.proto('int32_t', ['void *', 'void *']));
const FitEndedCallback = pointer(koffi.proto('int32_t', ['size_t', 'int32_t', 'void *']));
const LogCallback = pointer(koffi.proto('void', ['int32_t', 'str', 'void *']));

/** The structs by the names of the C interface without prefix. */
const structs = {
  cylinder: Cylinder, intrinsics: Intrinsics, points_view: PointsView, points_out: PointsOut, depth_view: DepthView,
  depth_out: DepthOut, mask_view: MaskView, image_view: ImageView, segments_view: SegmentsView, options: Options,
  counts: Counts, result: Result, cylinder_estimate: CylinderEstimate, cylinder_diagnosis: CylinderDiagnosis,
  completion: Completion, extent: Extent, progress: Progress, limb: Limb, limb_sample: LimbSample,
  end_sample: EndSample, detector_options: DetectorOptions, detection_progress: DetectionProgress,
  detection: Detection,
};

const input = pointer;
const output = (type) => koffi.out(pointer(type));
// What the library fills says its size before.
const filled = (type) => koffi.inout(pointer(type));

const signatures = {
  cylfuse_abi_version: ['uint32_t', []],
  cylfuse_version_number: ['uint32_t', []],
  cylfuse_version_string: ['str', []],
  cylfuse_build_info: ['str', []],
  cylfuse_status_string: ['str', ['int32_t']],
  cylfuse_flag_string: ['str', ['uint32_t']],
  cylfuse_termination_string: ['str', ['int32_t']],
  cylfuse_start_string: ['str', ['int32_t']],
  cylfuse_end_state_string: ['str', ['int32_t']],
  cylfuse_end_source_string: ['str', ['int32_t']],
  cylfuse_limb_status_string: ['str', ['int32_t']],
  cylfuse_part_string: ['str', ['uint8_t']],
  cylfuse_conformity_string: ['str', ['int32_t']],
  cylfuse_options_init: ['int32_t', [output(Options), 'size_t']],
  cylfuse_intrinsics_init: ['int32_t', [output(Intrinsics), 'size_t']],
  cylfuse_points_view_init: ['int32_t', [output(PointsView), 'size_t']],
  cylfuse_depth_view_init: ['int32_t', [output(DepthView), 'size_t']],
  cylfuse_mask_view_init: ['int32_t', [output(MaskView), 'size_t']],
  cylfuse_image_view_init: ['int32_t', [output(ImageView), 'size_t']],
  cylfuse_segments_view_init: ['int32_t', [output(SegmentsView), 'size_t']],
  cylfuse_points_out_init: ['int32_t', [output(PointsOut), 'size_t']],
  cylfuse_depth_out_init: ['int32_t', [output(DepthOut), 'size_t']],
  cylfuse_counts_init: ['int32_t', [output(Counts), 'size_t']],
  cylfuse_result_init: ['int32_t', [output(Result), 'size_t']],
  cylfuse_cylinder_estimate_init: ['int32_t', [output(CylinderEstimate), 'size_t']],
  cylfuse_cylinder_diagnosis_init: ['int32_t', [output(CylinderDiagnosis), 'size_t']],
  cylfuse_completion_init: ['int32_t', [output(Completion), 'size_t']],
  cylfuse_extent_init: ['int32_t', [output(Extent), 'size_t']],
  cylfuse_fitter_create: ['int32_t', ['uint32_t', output(Handle)]],
  cylfuse_fitter_clone: ['int32_t', [Handle, output(Handle)]],
  cylfuse_fitter_destroy: ['int32_t', [Handle]],
  cylfuse_fitter_reserve: ['int32_t', [Handle, 'size_t', 'size_t']],
  cylfuse_fitter_clear: ['int32_t', [Handle]],
  cylfuse_fitter_clear_input: ['int32_t', [Handle, 'uint32_t']],
  cylfuse_fitter_last_error: ['str', [Handle]],
  cylfuse_fitter_cancel: ['int32_t', [Handle]],
  cylfuse_fitter_set_options: ['int32_t', [Handle, input(Options)]],
  cylfuse_fitter_get_options: ['int32_t', [Handle, filled(Options)]],
  cylfuse_fitter_select_view: ['int32_t', [Handle, 'size_t']],
  cylfuse_fitter_view_count: ['int32_t', [Handle, output('size_t')]],
  cylfuse_fitter_set_pose: ['int32_t', [Handle, 'void *', 'void *']],
  cylfuse_fitter_set_depth_camera: ['int32_t', [Handle, input(Intrinsics), 'void *', 'void *']],
  cylfuse_fitter_set_intrinsics: ['int32_t', [Handle, input(Intrinsics)]],
  cylfuse_fitter_get_intrinsics: ['int32_t', [Handle, filled(Intrinsics)]],
  cylfuse_fitter_set_start_model: ['int32_t', [Handle, input(Cylinder)]],
  cylfuse_fitter_set_progress: ['int32_t', [Handle, ProgressCallback, 'void *']],
  cylfuse_fitter_set_log: ['int32_t', [Handle, 'int32_t', LogCallback, 'void *']],
  cylfuse_fitter_push_points: ['int32_t', [Handle, input(PointsView), input(MaskView)]],
  cylfuse_fitter_push_depth: ['int32_t', [Handle, input(DepthView), input(MaskView)]],
  cylfuse_fitter_push_image: ['int32_t', [Handle, input(ImageView)]],
  cylfuse_fitter_push_edges: ['int32_t', [Handle, input(SegmentsView)]],
  cylfuse_fitter_counts: ['int32_t', [Handle, filled(Counts)]],
  cylfuse_frame_create: ['int32_t', ['uint32_t', output(Handle)]],
  cylfuse_frame_destroy: ['int32_t', [Handle]],
  cylfuse_frame_last_error: ['str', [Handle]],
  cylfuse_frame_set_intrinsics: ['int32_t', [Handle, input(Intrinsics)]],
  cylfuse_frame_set_pose: ['int32_t', [Handle, 'void *', 'void *']],
  cylfuse_frame_set_depth_camera: ['int32_t', [Handle, input(Intrinsics), 'void *', 'void *']],
  cylfuse_frame_set_depth: ['int32_t', [Handle, input(DepthView)]],
  cylfuse_frame_set_image: ['int32_t', [Handle, input(ImageView)]],
  cylfuse_fitter_use_frame: ['int32_t', [Handle, Handle, input(MaskView)]],
  cylfuse_fitter_fit: ['int32_t', [Handle, filled(Result), filled(CylinderEstimate)]],
  cylfuse_fit_all: ['int32_t', ['void *', 'size_t', 'uint32_t', FitEndedCallback, 'void *', 'void *']],
  cylfuse_fitter_evaluate: ['int32_t', [Handle, input(Cylinder), filled(Result), filled(CylinderEstimate)]],
  cylfuse_fitter_get_result: ['int32_t', [Handle, filled(Result)]],
  cylfuse_fitter_get_cylinder: ['int32_t', [Handle, filled(CylinderEstimate)]],
  cylfuse_fitter_diagnose: ['int32_t', [Handle, input(Cylinder), filled(CylinderDiagnosis)]],
  cylfuse_fitter_residuals: ['int32_t', [Handle, input(Cylinder), 'int32_t', 'void *', 'size_t', output('size_t')]],
  cylfuse_fitter_point_weights: ['int32_t', [Handle, 'void *', 'void *', 'size_t', output('size_t')]],
  cylfuse_fitter_point_parts: ['int32_t', [Handle, input(Cylinder), 'void *', 'size_t', output('size_t')]],
  cylfuse_fitter_limbs: ['int32_t', [Handle, 'void *', 'size_t', 'size_t', output('size_t')]],
  cylfuse_fitter_limb_samples: ['int32_t', [Handle, 'void *', 'size_t', 'size_t', output('size_t')]],
  cylfuse_fitter_end_samples: [
    'int32_t', [Handle, input(Cylinder), input(MaskView), 'void *', 'size_t', 'size_t', output('size_t')],
  ],
  cylfuse_fitter_complete_bound: ['int32_t', [Handle, input(MaskView), 'int32_t', output('size_t')]],
  cylfuse_fitter_complete: [
    'int32_t', [Handle, input(Cylinder), input(MaskView), 'int32_t', input(PointsOut), filled(Completion)],
  ],
  cylfuse_fitter_complete_depth: [
    'int32_t', [Handle, input(Cylinder), input(MaskView), input(DepthOut), filled(Completion)],
  ],
  cylfuse_fitter_extent: ['int32_t', [Handle, input(Cylinder), input(MaskView), filled(Extent)]],
  cylfuse_fitter_select_edges: [
    'int32_t', [Handle, input(Cylinder), input(SegmentsView), 'double', 'void *', 'size_t'],
  ],
  cylfuse_detector_options_init: ['int32_t', [output(DetectorOptions), 'size_t']],
  cylfuse_detector_create: ['int32_t', ['uint32_t', output(Handle)]],
  cylfuse_detector_destroy: ['int32_t', [Handle]],
  cylfuse_detector_last_error: ['str', [Handle]],
  cylfuse_detector_cancel: ['int32_t', [Handle]],
  cylfuse_detector_set_options: ['int32_t', [Handle, input(DetectorOptions)]],
  cylfuse_detector_get_options: ['int32_t', [Handle, filled(DetectorOptions)]],
  cylfuse_detector_set_fit_options: ['int32_t', [Handle, input(Options)]],
  cylfuse_detector_get_fit_options: ['int32_t', [Handle, filled(Options)]],
  cylfuse_detector_set_progress: ['int32_t', [Handle, ProgressCallback, 'void *']],
  cylfuse_detector_detect: ['int32_t', [Handle, Handle]],
  cylfuse_detector_detect_points: ['int32_t', [Handle, input(PointsView)]],
  cylfuse_detector_count: ['int32_t', [Handle, output('size_t')]],
  cylfuse_detector_is_complete: ['int32_t', [Handle, output('int32_t')]],
  cylfuse_detector_depth_moved: ['int32_t', [Handle, output('int32_t'), output('int32_t')]],
  cylfuse_detector_detections: ['int32_t', [Handle, 'void *', 'size_t', 'size_t', output('size_t')]],
  cylfuse_detector_get_result: ['int32_t', [Handle, 'size_t', filled(Result)]],
  cylfuse_detector_get_cylinder: ['int32_t', [Handle, 'size_t', filled(CylinderEstimate)]],
  cylfuse_detector_get_extent: ['int32_t', [Handle, 'size_t', filled(Extent)]],
  cylfuse_detector_labels: ['int32_t', [Handle, 'void *', 'size_t', output('size_t')]],
  cylfuse_detector_indices: ['int32_t', [Handle, 'size_t', 'void *', 'size_t', output('size_t')]],
  cylfuse_detector_make_fitter: ['int32_t', [Handle, 'size_t', output(Handle)]],
  cylfuse_cylinder_distances: ['int32_t', [input(Cylinder), input(PointsView), 'void *', 'size_t']],
  cylfuse_cylinder_project: ['int32_t', [input(Cylinder), input(Intrinsics), 'void *']],
  cylfuse_cylinder_compare: [
    'int32_t', [input(Cylinder), input(Cylinder), output('double'), output('double'), output('double')],
  ],
  cylfuse_plan: ['int32_t', [input(Intrinsics), 'void *', 'void *', 'void *', 'void *']],
  cylfuse_decide_conformity: [
    'int32_t', ['double', 'double', 'uint32_t', 'double', 'double', 'double', output('int32_t')],
  ],
  cylfuse_intrinsics_project: ['int32_t', [input(Intrinsics), input(PointsView), 'void *', 'size_t']],
  cylfuse_intrinsics_unproject: ['int32_t', [input(Intrinsics), 'void *', 'size_t', 'void *']],
};

const functions = {};

/** Loads the library, at CYLFUSE_LIBRARY or in the package, and refuses one that does not know the structs above. */
function loadLibrary() {
  const platform = `${process.platform}-${process.arch}`;
  const name = { darwin: 'libcylfuse.dylib', win32: 'cylfuse.dll' }[process.platform] ?? 'libcylfuse.so';
  const named = process.env.CYLFUSE_LIBRARY;
  const file = named || path.join(__dirname, '..', 'native', platform, name);
  const bind = (library, symbol) => { functions[symbol] = library.func(symbol, ...signatures[symbol]); };
  let library;
  try {
    library = koffi.load(file);
    for (const symbol of ['abi_version', 'version_number', 'version_string']) bind(library, `cylfuse_${symbol}`);
  } catch (error) {
    const source = named ? 'which CYLFUSE_LIBRARY names' : `that of the package for ${platform}`;
    throw new Error(
      `cylfuse cannot load the native library ${file}, ${source}: ${error.message}. Set CYLFUSE_LIBRARY to the path ` +
        `of ${name}`,
      { cause: error },
    );
  }
  if (functions.cylfuse_abi_version() !== ABI_VERSION || functions.cylfuse_version_number() < OLDEST_VERSION) {
    throw new Error(
      `the native library ${file} is version ${functions.cylfuse_version_string()} with version ` +
        `${functions.cylfuse_abi_version()} of the binary interface, this package needs at least 0.2.0 with version ` +
        `${ABI_VERSION}: install the library that belongs to the package`,
    );
  }
  for (const symbol of Object.keys(signatures)) bind(library, symbol);
  return library;
}

const library = loadLibrary();

/**
 * The long calls on a thread of the pool. What they point to is memory of koffi.alloc: the collector does not move it,
 * and nothing is converted when a call ends after the JavaScript of its worker.
 */
const onPool = {
  fit: library.func('cylfuse_fitter_fit', 'int32_t', [Handle, 'void *', 'void *']).async,
  fitAll: library.func('cylfuse_fit_all', 'int32_t', signatures.cylfuse_fit_all[1]).async,
  detect: library.func('cylfuse_detector_detect', 'int32_t', [Handle, Handle]).async,
  detectPoints: library.func('cylfuse_detector_detect_points', 'int32_t', [Handle, 'void *']).async,
};

/** A struct as its ..._init function fills it: with the defaults, or with zeros for an output. */
function initialised(name) {
  const struct = {};
  functions[`cylfuse_${name}_init`](struct, koffi.sizeof(structs[name]));
  return struct;
}

module.exports = {
  ABI_VERSION, koffi, Handle, structs, functions, onPool, initialised, ProgressCallback, FitEndedCallback, LogCallback,
};

package org.cylfuse;

import com.sun.jna.Pointer;
import com.sun.jna.Structure;
import com.sun.jna.Structure.FieldOrder;

/**
 * The structs of cylfuse.h, field by field. {@code size_t} and {@code ptrdiff_t} are {@code long}: the library is
 * opened in 64-bit processes only. The tests compare sizes and offsets with those of the library.
 */
final class NativeStructs {
    private NativeStructs() {}

    @FieldOrder({"struct_size", "method", "objective", "start", "near_wall", "chart", "edge_use", "extent_rule",
        "max_threads", "max_iterations", "cost_tolerance", "gradient_tolerance", "step_tolerance", "initial_lambda",
        "lambda_factor", "max_lambda", "edge_weight", "seed", "ransac_max_iterations", "ransac_threshold",
        "independent_points", "depth_noise", "image_noise", "edge_noise", "mask_noise", "image_blur", "drawn_pixel",
        "radius_min", "radius_max", "axis", "axis_max_angle", "depth_shared"})
    public static class Options extends Structure {
        public int struct_size;
        public int method;
        public int objective;
        public int start;
        public int near_wall;
        public int chart;
        public int edge_use;
        public int extent_rule;
        public int max_threads;
        public int max_iterations;
        public double cost_tolerance;
        public double gradient_tolerance;
        public double step_tolerance;
        public double initial_lambda;
        public double lambda_factor;
        public double max_lambda;
        public double edge_weight;
        public long seed;
        public long ransac_max_iterations;
        public double ransac_threshold;
        public double independent_points;
        public double depth_noise;
        public double image_noise;
        public double edge_noise;
        public double mask_noise;
        public double image_blur;
        public double drawn_pixel;
        public double radius_min;
        public double radius_max;
        public double[] axis = new double[3];
        public double axis_max_angle;
        public double depth_shared;
    }

    @FieldOrder({"struct_size", "image_use", "max_threads", "max_count", "min_pixels", "min_score", "radius_min",
        "radius_max", "axis", "axis_max_angle"})
    public static class DetectorOptions extends Structure {
        public int struct_size;
        public int image_use;
        public int max_threads;
        public int max_count;
        public long min_pixels;
        public double min_score;
        public double radius_min;
        public double radius_max;
        public double[] axis = new double[3];
        public double axis_max_angle;
    }

    @FieldOrder({"struct_size", "distortion_model", "width", "height", "fx", "fy", "cx", "cy", "distortion"})
    public static class Intrinsics extends Structure {
        public int struct_size;
        public int distortion_model;
        public int width;
        public int height;
        public double fx;
        public double fy;
        public double cx;
        public double cy;
        public double[] distortion = new double[8];
    }

    @FieldOrder({"struct_size", "scalar", "data", "width", "height", "point_stride", "row_stride", "weights",
        "weight_stride", "weight_row_stride", "normals", "normal_stride", "normal_row_stride"})
    public static class PointsView extends Structure {
        public int struct_size;
        public int scalar;
        public Pointer data;
        public long width;
        public long height;
        public long point_stride;
        public long row_stride;
        public Pointer weights;
        public long weight_stride;
        public long weight_row_stride;
        public Pointer normals;
        public long normal_stride;
        public long normal_row_stride;
    }

    @FieldOrder({"struct_size", "format", "data", "width", "height", "row_stride", "pixel_stride", "scale", "min_depth",
        "max_depth"})
    public static class DepthView extends Structure {
        public int struct_size;
        public int format;
        public Pointer data;
        public int width;
        public int height;
        public long row_stride;
        public long pixel_stride;
        public double scale;
        public double min_depth;
        public double max_depth;
    }

    @FieldOrder({"struct_size", "width", "height", "label", "data", "row_stride", "pixel_stride"})
    public static class MaskView extends Structure {
        public int struct_size;
        public int width;
        public int height;
        public int label;
        public Pointer data;
        public long row_stride;
        public long pixel_stride;
    }

    @FieldOrder({"struct_size", "format", "data", "width", "height", "row_stride", "pixel_stride", "gamma"})
    public static class ImageView extends Structure {
        public int struct_size;
        public int format;
        public Pointer data;
        public int width;
        public int height;
        public long row_stride;
        public long pixel_stride;
        public double gamma;
    }

    @FieldOrder({"struct_size", "scalar", "data", "count", "segment_stride", "weights"})
    public static class SegmentsView extends Structure {
        public int struct_size;
        public int scalar;
        public Pointer data;
        public long count;
        public long segment_stride;
        public Pointer weights;
    }

    @FieldOrder({"struct_size", "scalar", "data", "capacity", "point_stride", "row_stride"})
    public static class PointsOut extends Structure {
        public int struct_size;
        public int scalar;
        public Pointer data;
        public long capacity;
        public long point_stride;
        public long row_stride;
    }

    @FieldOrder({"struct_size", "format", "data", "width", "height", "row_stride", "pixel_stride", "scale"})
    public static class DepthOut extends Structure {
        public int struct_size;
        public int format;
        public Pointer data;
        public int width;
        public int height;
        public long row_stride;
        public long pixel_stride;
        public double scale;
    }

    @FieldOrder({"struct_size", "view", "points_given", "points_used", "dropped_not_finite", "dropped_zero_weight",
        "dropped_outside_mask", "dropped_no_depth", "dropped_out_of_range", "dropped_outside_camera", "dropped_hidden",
        "segments_given"})
    public static class Counts extends Structure {
        public int struct_size;
        public int view;
        public long points_given;
        public long points_used;
        public long dropped_not_finite;
        public long dropped_zero_weight;
        public long dropped_outside_mask;
        public long dropped_no_depth;
        public long dropped_out_of_range;
        public long dropped_outside_camera;
        public long dropped_hidden;
        public long segments_given;
    }

    @FieldOrder({"struct_size", "flags", "termination", "iterations", "rejected_steps", "limbs_located",
        "segments_given", "segments_used", "points_given", "points_used", "independent_points", "point_deviation",
        "point_rms", "edge_rms_pixels", "near_wall_fraction", "initial_cost", "cost", "energy_points", "energy_edges",
        "edge_weight", "condition", "gradient_norm", "step_norm", "lambda", "seconds_start", "seconds_solve",
        "seconds_total"})
    public static class Result extends Structure {
        public int struct_size;
        public int flags;
        public int termination;
        public int iterations;
        public int rejected_steps;
        public int limbs_located;
        public int segments_given;
        public int segments_used;
        public long points_given;
        public long points_used;
        public double independent_points;
        public double point_deviation;
        public double point_rms;
        public double edge_rms_pixels;
        public double near_wall_fraction;
        public double initial_cost;
        public double cost;
        public double energy_points;
        public double energy_edges;
        public double edge_weight;
        public double condition;
        public double gradient_norm;
        public double step_norm;
        public double lambda;
        public double seconds_start;
        public double seconds_solve;
        public double seconds_total;
    }

    @FieldOrder({"point", "direction", "radius"})
    public static class Cylinder extends Structure {
        public double[] point = new double[3];
        public double[] direction = new double[3];
        public double radius;

        public Cylinder() {}

        Cylinder(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"struct_size", "start_kind", "model", "start_model", "radius_deviation", "direction_deviation",
        "position_deviation", "radius_from_points", "radius_from_points_deviation", "radius_from_limbs",
        "radius_from_limbs_deviation", "radius_z_score", "covariance"})
    public static class CylinderEstimate extends Structure {
        public int struct_size;
        public int start_kind;
        public Cylinder model;
        public Cylinder start_model;
        public double radius_deviation;
        public double direction_deviation;
        public double position_deviation;
        public double radius_from_points;
        public double radius_from_points_deviation;
        public double radius_from_limbs;
        public double radius_from_limbs_deviation;
        public double radius_z_score;
        public double[] covariance = new double[49];
    }

    @FieldOrder({"struct_size", "rank", "singular_values", "condition", "weakest_shift", "weakest_tilt",
        "weakest_radius"})
    public static class CylinderDiagnosis extends Structure {
        public int struct_size;
        public int rank;
        public double[] singular_values = new double[5];
        public double condition;
        public double[] weakest_shift = new double[3];
        public double[] weakest_tilt = new double[3];
        public double weakest_radius;
    }

    @FieldOrder({"struct_size", "view", "count", "hits", "misses", "outside_camera", "out_of_range"})
    public static class Completion extends Structure {
        public int struct_size;
        public int view;
        public long count;
        public long hits;
        public long misses;
        public long outside_camera;
        public long out_of_range;
    }

    @FieldOrder({"struct_size", "start_state", "end_state", "start_source", "end_source", "start_view", "end_view",
        "limbs_known", "start", "end", "center", "length", "start_deviation", "end_deviation", "length_deviation",
        "start_covariance", "end_covariance", "center_covariance"})
    public static class Extent extends Structure {
        public int struct_size;
        public int start_state;
        public int end_state;
        public int start_source;
        public int end_source;
        public int start_view;
        public int end_view;
        public int limbs_known;
        public double[] start = new double[3];
        public double[] end = new double[3];
        public double[] center = new double[3];
        public double length;
        public double start_deviation;
        public double end_deviation;
        public double length_deviation;
        public double[] start_covariance = new double[9];
        public double[] end_covariance = new double[9];
        public double[] center_covariance = new double[9];
    }

    @FieldOrder({"struct_size", "phase", "iteration", "max_iterations", "cost", "lambda", "cylinder"})
    public static class Progress extends Structure {
        public int struct_size;
        public int phase;
        public int iteration;
        public int max_iterations;
        public double cost;
        public double lambda;
        public Pointer cylinder;

        public Progress() {}

        Progress(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"struct_size", "phase", "fits_done", "fits"})
    public static class DetectionProgress extends Structure {
        public int struct_size;
        public int phase;
        public int fits_done;
        public int fits;

        public DetectionProgress() {}

        DetectionProgress(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"score", "pixels", "model"})
    public static class Detection extends Structure {
        public double score;
        public long pixels;
        public Cylinder model;

        public Detection() {}

        Detection(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"view", "limb", "status", "samples", "line", "deviation"})
    public static class Limb extends Structure {
        public int view;
        public int limb;
        public int status;
        public int samples;
        public double[] line = new double[4];
        public double deviation;

        public Limb() {}

        Limb(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"view", "limb", "pixel", "deviation", "weight"})
    public static class LimbSample extends Structure {
        public int view;
        public int limb;
        public double[] pixel = new double[2];
        public double deviation;
        public double weight;

        public LimbSample() {}

        LimbSample(Pointer address) {
            super(address);
        }
    }

    @FieldOrder({"view", "end", "pixel", "normal", "deviation"})
    public static class EndSample extends Structure {
        public int view;
        public int end;
        public double[] pixel = new double[2];
        public double[] normal = new double[2];
        public double deviation;

        public EndSample() {}

        EndSample(Pointer address) {
            super(address);
        }
    }
}

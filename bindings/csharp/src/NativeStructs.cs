using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    // The structs of cylfuse.h, field by field. The tests compare sizes and offsets with those of the library.

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeOptions
    {
        internal uint struct_size;
        internal int method;
        internal int objective;
        internal int start;
        internal int near_wall;
        internal int chart;
        internal int edge_use;
        internal int extent_rule;
        internal uint max_threads;
        internal uint max_iterations;
        internal double cost_tolerance;
        internal double gradient_tolerance;
        internal double step_tolerance;
        internal double initial_lambda;
        internal double lambda_factor;
        internal double max_lambda;
        internal double edge_weight;
        internal ulong seed;
        internal ulong ransac_max_iterations;
        internal double ransac_threshold;
        internal double independent_points;
        internal double depth_noise;
        internal double image_noise;
        internal double edge_noise;
        internal double mask_noise;
        internal double image_blur;
        internal double drawn_pixel;
        internal double radius_min;
        internal double radius_max;
        internal Vector axis;
        internal double axis_max_angle;
        internal double depth_shared;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeDetectorOptions
    {
        internal uint struct_size;
        internal int image_use;
        internal uint max_threads;
        internal uint max_count;
        internal ulong min_pixels;
        internal double min_score;
        internal double radius_min;
        internal double radius_max;
        internal Vector axis;
        internal double axis_max_angle;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeIntrinsics
    {
        internal uint struct_size;
        internal int distortion_model;
        internal uint width;
        internal uint height;
        internal double fx;
        internal double fy;
        internal double cx;
        internal double cy;
        internal fixed double distortion[8];
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePointsView
    {
        internal uint struct_size;
        internal int scalar;
        internal IntPtr data;
        internal UIntPtr width;
        internal UIntPtr height;
        internal IntPtr point_stride;
        internal IntPtr row_stride;
        internal IntPtr weights;
        internal IntPtr weight_stride;
        internal IntPtr weight_row_stride;
        internal IntPtr normals;
        internal IntPtr normal_stride;
        internal IntPtr normal_row_stride;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeDepthView
    {
        internal uint struct_size;
        internal int format;
        internal IntPtr data;
        internal uint width;
        internal uint height;
        internal IntPtr row_stride;
        internal IntPtr pixel_stride;
        internal double scale;
        internal double min_depth;
        internal double max_depth;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeMaskView
    {
        internal uint struct_size;
        internal uint width;
        internal uint height;
        internal uint label;
        internal IntPtr data;
        internal IntPtr row_stride;
        internal IntPtr pixel_stride;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeImageView
    {
        internal uint struct_size;
        internal int format;
        internal IntPtr data;
        internal uint width;
        internal uint height;
        internal IntPtr row_stride;
        internal IntPtr pixel_stride;
        internal double gamma;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeSegmentsView
    {
        internal uint struct_size;
        internal int scalar;
        internal IntPtr data;
        internal UIntPtr count;
        internal IntPtr segment_stride;
        internal IntPtr weights;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativePointsOut
    {
        internal uint struct_size;
        internal int scalar;
        internal IntPtr data;
        internal UIntPtr capacity;
        internal IntPtr point_stride;
        internal IntPtr row_stride;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeDepthOut
    {
        internal uint struct_size;
        internal int format;
        internal IntPtr data;
        internal uint width;
        internal uint height;
        internal IntPtr row_stride;
        internal IntPtr pixel_stride;
        internal double scale;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeCounts
    {
        internal uint struct_size;
        internal uint view;
        internal ulong points_given;
        internal ulong points_used;
        internal ulong dropped_not_finite;
        internal ulong dropped_zero_weight;
        internal ulong dropped_outside_mask;
        internal ulong dropped_no_depth;
        internal ulong dropped_out_of_range;
        internal ulong dropped_outside_camera;
        internal ulong dropped_hidden;
        internal ulong segments_given;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeResult
    {
        internal uint struct_size;
        internal uint flags;
        internal int termination;
        internal uint iterations;
        internal uint rejected_steps;
        internal uint limbs_located;
        internal uint segments_given;
        internal uint segments_used;
        internal ulong points_given;
        internal ulong points_used;
        internal double independent_points;
        internal double point_deviation;
        internal double point_rms;
        internal double edge_rms_pixels;
        internal double near_wall_fraction;
        internal double initial_cost;
        internal double cost;
        internal double energy_points;
        internal double energy_edges;
        internal double edge_weight;
        internal double condition;
        internal double gradient_norm;
        internal double step_norm;
        internal double lambda;
        internal double seconds_start;
        internal double seconds_solve;
        internal double seconds_total;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeCylinder
    {
        internal Vector point;
        internal Vector direction;
        internal double radius;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeCylinderEstimate
    {
        internal uint struct_size;
        internal int start_kind;
        internal NativeCylinder model;
        internal NativeCylinder start_model;
        internal double radius_deviation;
        internal double direction_deviation;
        internal double position_deviation;
        internal double radius_from_points;
        internal double radius_from_points_deviation;
        internal double radius_from_limbs;
        internal double radius_from_limbs_deviation;
        internal double radius_z_score;
        internal fixed double covariance[49];
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeCylinderDiagnosis
    {
        internal uint struct_size;
        internal uint rank;
        internal fixed double singular_values[5];
        internal double condition;
        internal Vector weakest_shift;
        internal Vector weakest_tilt;
        internal double weakest_radius;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeCompletion
    {
        internal uint struct_size;
        internal uint view;
        internal ulong count;
        internal ulong hits;
        internal ulong misses;
        internal ulong outside_camera;
        internal ulong out_of_range;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeExtent
    {
        internal uint struct_size;
        internal int start_state;
        internal int end_state;
        internal int start_source;
        internal int end_source;
        internal uint start_view;
        internal uint end_view;
        internal uint limbs_known;
        internal Vector start;
        internal Vector end;
        internal Vector center;
        internal double length;
        internal double start_deviation;
        internal double end_deviation;
        internal double length_deviation;
        internal fixed double start_covariance[9];
        internal fixed double end_covariance[9];
        internal fixed double center_covariance[9];
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeProgress
    {
        internal uint struct_size;
        internal int phase;
        internal uint iteration;
        internal uint max_iterations;
        internal double cost;
        internal double lambda;
        internal IntPtr cylinder;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeDetectionProgress
    {
        internal uint struct_size;
        internal int phase;
        internal uint fits_done;
        internal uint fits;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal struct NativeDetection
    {
        internal double score;
        internal ulong pixels;
        internal NativeCylinder model;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeLimb
    {
        internal uint view;
        internal uint limb;
        internal int status;
        internal uint samples;
        internal fixed double line[4];
        internal double deviation;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeLimbSample
    {
        internal uint view;
        internal uint limb;
        internal fixed double pixel[2];
        internal double deviation;
        internal double weight;
    }

    [StructLayout(LayoutKind.Sequential)]
    internal unsafe struct NativeEndSample
    {
        internal uint view;
        internal uint end;
        internal fixed double pixel[2];
        internal fixed double normal[2];
        internal double deviation;
    }
}

using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>The functions of cylfuse.h in the loaded library.</summary>
    /// <remarks>They are looked up by name and not imported with DllImport, because DllImport has no way to name
    /// the file of the library at run time that all runtimes of .NET Standard 2.0 share.</remarks>
    internal sealed unsafe class NativeFunctions
    {
        /// <summary>The version of the binary interface that NativeStructs.cs describes.</summary>
        internal const uint AbiVersionOfBinding = 1;

        private const CallingConvention C = CallingConvention.Cdecl;

        [UnmanagedFunctionPointer(C)] internal delegate uint NumberFunction();
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr TextFunction();
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr StatusTextFunction(int status);
        [UnmanagedFunctionPointer(C)] internal delegate int InitFunction(void* target, UIntPtr structSize);
        [UnmanagedFunctionPointer(C)] internal delegate int CreateFunction(uint abiVersion, out IntPtr fitter);
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr FitterTextFunction(IntPtr fitter);
        [UnmanagedFunctionPointer(C)] internal delegate int FitterFunction(IntPtr fitter);
        [UnmanagedFunctionPointer(C)] internal delegate int ReserveFunction(IntPtr fitter, UIntPtr points, UIntPtr segments);
        [UnmanagedFunctionPointer(C)] internal delegate int OptionsFunction(IntPtr fitter, NativeOptions* options);
        [UnmanagedFunctionPointer(C)] internal delegate int IntrinsicsFunction(IntPtr fitter, NativeIntrinsics* intrinsics);
        [UnmanagedFunctionPointer(C)] internal delegate int ModelFunction(IntPtr fitter, NativeCylinder* model);
        [UnmanagedFunctionPointer(C)] internal delegate int ProgressCallback(NativeProgress* progress, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate void LogCallback(int level, IntPtr message, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetProgressFunction(IntPtr fitter, ProgressCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetLogFunction(IntPtr fitter, int maxLevel, LogCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int PushPointsFunction(IntPtr fitter, NativePointsView* points, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int PushDepthFunction(IntPtr fitter, NativeDepthView* depth, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int PushImageFunction(IntPtr fitter, NativeImageView* image);
        [UnmanagedFunctionPointer(C)] internal delegate int PushEdgesFunction(IntPtr fitter, NativeSegmentsView* segments);
        [UnmanagedFunctionPointer(C)] internal delegate int CountsFunction(IntPtr fitter, NativeCounts* counts);
        [UnmanagedFunctionPointer(C)] internal delegate int ResultFunction(IntPtr fitter, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int EvaluateFunction(IntPtr fitter, NativeCylinder* model, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int ResidualsFunction(IntPtr fitter, NativeCylinder* model, int kind, double* values, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int LimbSamplesFunction(IntPtr fitter, NativeLimbSample* samples, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int DiagnoseFunction(IntPtr fitter, NativeCylinder* model, NativeDiagnosis* diagnosis);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteBoundFunction(IntPtr fitter, NativeMaskView* mask, int layout, out UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativePointsOut* points, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteDepthFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativeDepthOut* depth, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int ExtentFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativeExtent* extent);
        [UnmanagedFunctionPointer(C)] internal delegate int SelectEdgesFunction(IntPtr fitter, NativeCylinder* model, NativeSegmentsView* segments, double reach, byte* limbs, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int DistancesFunction(NativeCylinder* model, NativePointsView* points, double* distances, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int ProjectFunction(NativeCylinder* model, NativeIntrinsics* intrinsics, double* lines);
        [UnmanagedFunctionPointer(C)] internal delegate int CompareFunction(NativeCylinder* a, NativeCylinder* b, out double angle, out double axisDistance, out double radiusRelative);

        internal readonly NumberFunction AbiVersion = Find<NumberFunction>("cylfuse_abi_version");
        internal readonly NumberFunction VersionNumber = Find<NumberFunction>("cylfuse_version_number");
        internal readonly TextFunction VersionString = Find<TextFunction>("cylfuse_version_string");
        internal readonly TextFunction BuildInfo = Find<TextFunction>("cylfuse_build_info");
        internal readonly StatusTextFunction StatusString = Find<StatusTextFunction>("cylfuse_status_string");

        internal readonly InitFunction OptionsInit = Find<InitFunction>("cylfuse_options_init");
        internal readonly InitFunction IntrinsicsInit = Find<InitFunction>("cylfuse_intrinsics_init");
        internal readonly InitFunction PointsViewInit = Find<InitFunction>("cylfuse_points_view_init");
        internal readonly InitFunction DepthViewInit = Find<InitFunction>("cylfuse_depth_view_init");
        internal readonly InitFunction MaskViewInit = Find<InitFunction>("cylfuse_mask_view_init");
        internal readonly InitFunction ImageViewInit = Find<InitFunction>("cylfuse_image_view_init");
        internal readonly InitFunction SegmentsViewInit = Find<InitFunction>("cylfuse_segments_view_init");
        internal readonly InitFunction PointsOutInit = Find<InitFunction>("cylfuse_points_out_init");
        internal readonly InitFunction DepthOutInit = Find<InitFunction>("cylfuse_depth_out_init");

        internal readonly CreateFunction FitterCreate = Find<CreateFunction>("cylfuse_fitter_create");
        internal readonly FitterFunction FitterDestroy = Find<FitterFunction>("cylfuse_fitter_destroy");
        internal readonly ReserveFunction FitterReserve = Find<ReserveFunction>("cylfuse_fitter_reserve");
        internal readonly FitterFunction FitterClear = Find<FitterFunction>("cylfuse_fitter_clear");
        internal readonly FitterTextFunction FitterLastError = Find<FitterTextFunction>("cylfuse_fitter_last_error");
        internal readonly FitterFunction FitterCancel = Find<FitterFunction>("cylfuse_fitter_cancel");
        internal readonly OptionsFunction FitterSetOptions = Find<OptionsFunction>("cylfuse_fitter_set_options");
        internal readonly OptionsFunction FitterGetOptions = Find<OptionsFunction>("cylfuse_fitter_get_options");
        internal readonly IntrinsicsFunction FitterSetIntrinsics = Find<IntrinsicsFunction>("cylfuse_fitter_set_intrinsics");
        internal readonly ModelFunction FitterSetStartModel = Find<ModelFunction>("cylfuse_fitter_set_start_model");
        internal readonly SetProgressFunction FitterSetProgress = Find<SetProgressFunction>("cylfuse_fitter_set_progress");
        internal readonly SetLogFunction FitterSetLog = Find<SetLogFunction>("cylfuse_fitter_set_log");
        internal readonly PushPointsFunction FitterPushPoints = Find<PushPointsFunction>("cylfuse_fitter_push_points");
        internal readonly PushDepthFunction FitterPushDepth = Find<PushDepthFunction>("cylfuse_fitter_push_depth");
        internal readonly PushImageFunction FitterPushImage = Find<PushImageFunction>("cylfuse_fitter_push_image");
        internal readonly PushEdgesFunction FitterPushEdges = Find<PushEdgesFunction>("cylfuse_fitter_push_edges");
        internal readonly CountsFunction FitterCounts = Find<CountsFunction>("cylfuse_fitter_counts");
        internal readonly ResultFunction FitterFit = Find<ResultFunction>("cylfuse_fitter_fit");
        internal readonly EvaluateFunction FitterEvaluate = Find<EvaluateFunction>("cylfuse_fitter_evaluate");
        internal readonly ResultFunction FitterGetResult = Find<ResultFunction>("cylfuse_fitter_get_result");
        internal readonly ResidualsFunction FitterResiduals = Find<ResidualsFunction>("cylfuse_fitter_residuals");
        internal readonly LimbSamplesFunction FitterLimbSamples = Find<LimbSamplesFunction>("cylfuse_fitter_limb_samples");
        internal readonly DiagnoseFunction FitterDiagnose = Find<DiagnoseFunction>("cylfuse_fitter_diagnose");
        internal readonly CompleteBoundFunction FitterCompleteBound = Find<CompleteBoundFunction>("cylfuse_fitter_complete_bound");
        internal readonly CompleteFunction FitterComplete = Find<CompleteFunction>("cylfuse_fitter_complete");
        internal readonly CompleteDepthFunction FitterCompleteDepth = Find<CompleteDepthFunction>("cylfuse_fitter_complete_depth");
        internal readonly ExtentFunction FitterExtent = Find<ExtentFunction>("cylfuse_fitter_extent");
        internal readonly SelectEdgesFunction FitterSelectEdges = Find<SelectEdgesFunction>("cylfuse_fitter_select_edges");

        internal readonly DistancesFunction CylinderDistances = Find<DistancesFunction>("cylfuse_cylinder_distances");
        internal readonly ProjectFunction CylinderProject = Find<ProjectFunction>("cylfuse_cylinder_project");
        internal readonly CompareFunction CylinderCompare = Find<CompareFunction>("cylfuse_cylinder_compare");

        private NativeFunctions() { }

        /// <summary>Opens the library and checks that it is one for this package.</summary>
        internal static NativeFunctions Open()
        {
            NativeLibraryFile.Open();
            // Before the other functions are looked up: those of another interface may be others.
            uint version = Find<NumberFunction>("cylfuse_abi_version")();
            if (version != AbiVersionOfBinding)
                throw CylfuseException.For(Status.AbiMismatch,
                    $"The native library of cylfuse, {NativeLibraryFile.Opened}, has version {version} of the binary " +
                    $"interface; this package needs version {AbiVersionOfBinding}. Use the library that belongs to it.");
            return new NativeFunctions();
        }

        private static T Find<T>(string name) => Marshal.GetDelegateForFunctionPointer<T>(NativeLibraryFile.Find(name));
    }
}

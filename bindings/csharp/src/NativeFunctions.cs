using System;
using System.Runtime.InteropServices;

namespace Cylfuse
{
    /// <summary>The functions of cylfuse.h in the loaded library.</summary>
    /// <remarks>They are looked up by name and not imported with DllImport, because DllImport has no way to name
    /// the file of the library at run time that all runtimes of .NET Standard 2.0 share.</remarks>
    internal static unsafe class NativeFunctions
    {
        /// <summary>The version of the binary interface that NativeStructs.cs describes.</summary>
        internal const uint AbiVersionOfBinding = 1;

        private const CallingConvention C = CallingConvention.Cdecl;

        [UnmanagedFunctionPointer(C)] internal delegate uint NumberFunction();
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr TextFunction();
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr StatusTextFunction(int status);
        [UnmanagedFunctionPointer(C)] internal delegate int InitFunction(void* target, UIntPtr structSize);
        [UnmanagedFunctionPointer(C)] internal delegate int CreateFunction(uint abiVersion, out IntPtr fitter);
        [UnmanagedFunctionPointer(C)] internal delegate int DestroyFunction(IntPtr fitter);
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr FitterTextFunction(FitterHandle fitter);
        [UnmanagedFunctionPointer(C)] internal delegate int FitterFunction(FitterHandle fitter);
        [UnmanagedFunctionPointer(C)] internal delegate int ReserveFunction(FitterHandle fitter, UIntPtr points, UIntPtr segments);
        [UnmanagedFunctionPointer(C)] internal delegate int OptionsFunction(FitterHandle fitter, NativeOptions* options);
        [UnmanagedFunctionPointer(C)] internal delegate int IntrinsicsFunction(FitterHandle fitter, NativeIntrinsics* intrinsics);
        [UnmanagedFunctionPointer(C)] internal delegate int ModelFunction(FitterHandle fitter, NativeCylinder* model);
        [UnmanagedFunctionPointer(C)] internal delegate int ProgressCallback(NativeProgress* progress, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate void LogCallback(int level, IntPtr message, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetProgressFunction(FitterHandle fitter, ProgressCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetLogFunction(FitterHandle fitter, int maxLevel, LogCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int PushPointsFunction(FitterHandle fitter, NativePointsView* points, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int PushDepthFunction(FitterHandle fitter, NativeDepthView* depth, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int PushImageFunction(FitterHandle fitter, NativeImageView* image);
        [UnmanagedFunctionPointer(C)] internal delegate int PushEdgesFunction(FitterHandle fitter, NativeSegmentsView* segments);
        [UnmanagedFunctionPointer(C)] internal delegate int CountsFunction(FitterHandle fitter, NativeCounts* counts);
        [UnmanagedFunctionPointer(C)] internal delegate int ResultFunction(FitterHandle fitter, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int EvaluateFunction(FitterHandle fitter, NativeCylinder* model, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int ResidualsFunction(FitterHandle fitter, NativeCylinder* model, int kind, double* values, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int LimbSamplesFunction(FitterHandle fitter, NativeLimbSample* samples, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int DiagnoseFunction(FitterHandle fitter, NativeCylinder* model, NativeDiagnosis* diagnosis);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteBoundFunction(FitterHandle fitter, NativeMaskView* mask, int layout, out UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteFunction(FitterHandle fitter, NativeCylinder* model, NativeMaskView* mask, NativePointsOut* points, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteDepthFunction(FitterHandle fitter, NativeCylinder* model, NativeMaskView* mask, NativeDepthOut* depth, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int ExtentFunction(FitterHandle fitter, NativeCylinder* model, NativeMaskView* mask, NativeExtent* extent);
        [UnmanagedFunctionPointer(C)] internal delegate int SelectEdgesFunction(FitterHandle fitter, NativeCylinder* model, NativeSegmentsView* segments, double reach, byte* limbs, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int DistancesFunction(NativeCylinder* model, NativePointsView* points, double* distances, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int ProjectFunction(NativeCylinder* model, NativeIntrinsics* intrinsics, double* lines);
        [UnmanagedFunctionPointer(C)] internal delegate int CompareFunction(NativeCylinder* a, NativeCylinder* b, out double angle, out double axisDistance, out double radiusRelative);

        private static readonly IntPtr library = NativeLibraryFile.Open();

        internal static readonly NumberFunction AbiVersion = Find<NumberFunction>("cylfuse_abi_version");
        internal static readonly NumberFunction VersionNumber = Find<NumberFunction>("cylfuse_version_number");
        internal static readonly TextFunction VersionString = Find<TextFunction>("cylfuse_version_string");
        internal static readonly TextFunction BuildInfo = Find<TextFunction>("cylfuse_build_info");
        internal static readonly StatusTextFunction StatusString = Find<StatusTextFunction>("cylfuse_status_string");

        internal static readonly InitFunction OptionsInit = Find<InitFunction>("cylfuse_options_init");
        internal static readonly InitFunction IntrinsicsInit = Find<InitFunction>("cylfuse_intrinsics_init");
        internal static readonly InitFunction PointsViewInit = Find<InitFunction>("cylfuse_points_view_init");
        internal static readonly InitFunction DepthViewInit = Find<InitFunction>("cylfuse_depth_view_init");
        internal static readonly InitFunction MaskViewInit = Find<InitFunction>("cylfuse_mask_view_init");
        internal static readonly InitFunction ImageViewInit = Find<InitFunction>("cylfuse_image_view_init");
        internal static readonly InitFunction SegmentsViewInit = Find<InitFunction>("cylfuse_segments_view_init");
        internal static readonly InitFunction PointsOutInit = Find<InitFunction>("cylfuse_points_out_init");
        internal static readonly InitFunction DepthOutInit = Find<InitFunction>("cylfuse_depth_out_init");

        internal static readonly CreateFunction FitterCreate = Find<CreateFunction>("cylfuse_fitter_create");
        internal static readonly DestroyFunction FitterDestroy = Find<DestroyFunction>("cylfuse_fitter_destroy");
        internal static readonly ReserveFunction FitterReserve = Find<ReserveFunction>("cylfuse_fitter_reserve");
        internal static readonly FitterFunction FitterClear = Find<FitterFunction>("cylfuse_fitter_clear");
        internal static readonly FitterTextFunction FitterLastError = Find<FitterTextFunction>("cylfuse_fitter_last_error");
        internal static readonly FitterFunction FitterCancel = Find<FitterFunction>("cylfuse_fitter_cancel");
        internal static readonly OptionsFunction FitterSetOptions = Find<OptionsFunction>("cylfuse_fitter_set_options");
        internal static readonly OptionsFunction FitterGetOptions = Find<OptionsFunction>("cylfuse_fitter_get_options");
        internal static readonly IntrinsicsFunction FitterSetIntrinsics = Find<IntrinsicsFunction>("cylfuse_fitter_set_intrinsics");
        internal static readonly ModelFunction FitterSetStartModel = Find<ModelFunction>("cylfuse_fitter_set_start_model");
        internal static readonly SetProgressFunction FitterSetProgress = Find<SetProgressFunction>("cylfuse_fitter_set_progress");
        internal static readonly SetLogFunction FitterSetLog = Find<SetLogFunction>("cylfuse_fitter_set_log");
        internal static readonly PushPointsFunction FitterPushPoints = Find<PushPointsFunction>("cylfuse_fitter_push_points");
        internal static readonly PushDepthFunction FitterPushDepth = Find<PushDepthFunction>("cylfuse_fitter_push_depth");
        internal static readonly PushImageFunction FitterPushImage = Find<PushImageFunction>("cylfuse_fitter_push_image");
        internal static readonly PushEdgesFunction FitterPushEdges = Find<PushEdgesFunction>("cylfuse_fitter_push_edges");
        internal static readonly CountsFunction FitterCounts = Find<CountsFunction>("cylfuse_fitter_counts");
        internal static readonly ResultFunction FitterFit = Find<ResultFunction>("cylfuse_fitter_fit");
        internal static readonly EvaluateFunction FitterEvaluate = Find<EvaluateFunction>("cylfuse_fitter_evaluate");
        internal static readonly ResultFunction FitterGetResult = Find<ResultFunction>("cylfuse_fitter_get_result");
        internal static readonly ResidualsFunction FitterResiduals = Find<ResidualsFunction>("cylfuse_fitter_residuals");
        internal static readonly LimbSamplesFunction FitterLimbSamples = Find<LimbSamplesFunction>("cylfuse_fitter_limb_samples");
        internal static readonly DiagnoseFunction FitterDiagnose = Find<DiagnoseFunction>("cylfuse_fitter_diagnose");
        internal static readonly CompleteBoundFunction FitterCompleteBound = Find<CompleteBoundFunction>("cylfuse_fitter_complete_bound");
        internal static readonly CompleteFunction FitterComplete = Find<CompleteFunction>("cylfuse_fitter_complete");
        internal static readonly CompleteDepthFunction FitterCompleteDepth = Find<CompleteDepthFunction>("cylfuse_fitter_complete_depth");
        internal static readonly ExtentFunction FitterExtent = Find<ExtentFunction>("cylfuse_fitter_extent");
        internal static readonly SelectEdgesFunction FitterSelectEdges = Find<SelectEdgesFunction>("cylfuse_fitter_select_edges");

        internal static readonly DistancesFunction CylinderDistances = Find<DistancesFunction>("cylfuse_cylinder_distances");
        internal static readonly ProjectFunction CylinderProject = Find<ProjectFunction>("cylfuse_cylinder_project");
        internal static readonly CompareFunction CylinderCompare = Find<CompareFunction>("cylfuse_cylinder_compare");

        /// <summary>Throws for a failed call that leaves no message of its own.</summary>
        internal static void Check(int status)
        {
            if (status != 0) throw CylfuseException.For((Status)status, Library.StatusText((Status)status));
        }

        /// <summary>The size of a struct for its struct_size.</summary>
        internal static UIntPtr SizeOf<T>() where T : struct => (UIntPtr)Marshal.SizeOf(typeof(T));

        private static T Find<T>(string name) =>
            Marshal.GetDelegateForFunctionPointer<T>(NativeLibraryFile.Find(library, name));
    }
}

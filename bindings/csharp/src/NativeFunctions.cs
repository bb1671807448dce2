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
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr ConstantTextFunction(int constant);
        [UnmanagedFunctionPointer(C)] internal delegate int InitFunction(void* target, UIntPtr structSize);
        [UnmanagedFunctionPointer(C)] internal delegate int CreateFunction(uint abiVersion, out IntPtr handle);
        [UnmanagedFunctionPointer(C)] internal delegate IntPtr HandleTextFunction(IntPtr handle);
        [UnmanagedFunctionPointer(C)] internal delegate int HandleFunction(IntPtr handle);
        [UnmanagedFunctionPointer(C)] internal delegate int ReserveFunction(IntPtr fitter, UIntPtr points, UIntPtr segments);
        [UnmanagedFunctionPointer(C)] internal delegate int OptionsFunction(IntPtr fitter, NativeOptions* options);
        [UnmanagedFunctionPointer(C)] internal delegate int IntrinsicsFunction(IntPtr handle, NativeIntrinsics* intrinsics);
        [UnmanagedFunctionPointer(C)] internal delegate int PoseFunction(IntPtr handle, double* rotation, double* translation);
        [UnmanagedFunctionPointer(C)] internal delegate int DepthCameraFunction(IntPtr handle, NativeIntrinsics* intrinsics, double* rotation, double* translation);
        [UnmanagedFunctionPointer(C)] internal delegate int SelectViewFunction(IntPtr fitter, UIntPtr index);
        [UnmanagedFunctionPointer(C)] internal delegate int ViewCountFunction(IntPtr fitter, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int ClearInputFunction(IntPtr fitter, uint inputs);
        [UnmanagedFunctionPointer(C)] internal delegate int SetDepthFunction(IntPtr frame, NativeDepthView* depth);
        [UnmanagedFunctionPointer(C)] internal delegate int UseFrameFunction(IntPtr fitter, IntPtr frame, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int ModelFunction(IntPtr fitter, NativeCylinder* model);
        [UnmanagedFunctionPointer(C)] internal delegate int ProgressCallback(NativeProgress* progress, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate void LogCallback(int level, IntPtr message, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetProgressFunction(IntPtr fitter, ProgressCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetLogFunction(IntPtr fitter, int maxLevel, LogCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int PushPointsFunction(IntPtr fitter, NativePointsView* points, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int PushDepthFunction(IntPtr fitter, NativeDepthView* depth, NativeMaskView* mask);
        [UnmanagedFunctionPointer(C)] internal delegate int ImageFunction(IntPtr handle, NativeImageView* image);
        [UnmanagedFunctionPointer(C)] internal delegate int PushEdgesFunction(IntPtr fitter, NativeSegmentsView* segments);
        [UnmanagedFunctionPointer(C)] internal delegate int CountsFunction(IntPtr fitter, NativeCounts* counts);
        [UnmanagedFunctionPointer(C)] internal delegate int FitFunction(IntPtr fitter, NativeResult* result, NativeCylinderEstimate* estimate);
        [UnmanagedFunctionPointer(C)] internal delegate int ResultFunction(IntPtr fitter, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int EstimateFunction(IntPtr fitter, NativeCylinderEstimate* estimate);
        [UnmanagedFunctionPointer(C)] internal delegate int EvaluateFunction(IntPtr fitter, NativeCylinder* model, NativeResult* result, NativeCylinderEstimate* estimate);
        [UnmanagedFunctionPointer(C)] internal delegate int ResidualsFunction(IntPtr fitter, NativeCylinder* model, int kind, double* values, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int ListFunction(IntPtr fitter, void* elements, UIntPtr elementSize, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int DiagnoseFunction(IntPtr fitter, NativeCylinder* model, NativeCylinderDiagnosis* diagnosis);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteBoundFunction(IntPtr fitter, NativeMaskView* mask, int layout, out UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, int layout, NativePointsOut* points, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int CompleteDepthFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativeDepthOut* depth, NativeCompletion* completion);
        [UnmanagedFunctionPointer(C)] internal delegate int ExtentFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativeExtent* extent);
        [UnmanagedFunctionPointer(C)] internal delegate int SelectEdgesFunction(IntPtr fitter, NativeCylinder* model, NativeSegmentsView* segments, double reach, byte* limbs, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int DistancesFunction(NativeCylinder* model, NativePointsView* points, double* distances, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int ProjectFunction(NativeCylinder* model, NativeIntrinsics* intrinsics, double* lines);
        [UnmanagedFunctionPointer(C)] internal delegate int PointWeightsFunction(IntPtr fitter, double* weights, byte* inliers, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int PointPartsFunction(IntPtr fitter, NativeCylinder* model, Part* parts, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int FitEndedCallback(UIntPtr index, int status, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int FitAllFunction(IntPtr* fitters, UIntPtr count, uint threads, FitEndedCallback callback, IntPtr userData, int* statuses);
        [UnmanagedFunctionPointer(C)] internal delegate int EndSamplesFunction(IntPtr fitter, NativeCylinder* model, NativeMaskView* mask, NativeEndSample* samples, UIntPtr elementSize, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int ProjectPointsFunction(NativeIntrinsics* intrinsics, NativePointsView* points, double* pixels, UIntPtr capacity);
        [UnmanagedFunctionPointer(C)] internal delegate int UnprojectFunction(NativeIntrinsics* intrinsics, double* pixels, UIntPtr count, double* rays);
        [UnmanagedFunctionPointer(C)] internal delegate int PlanFunction(NativeIntrinsics* intrinsics, double* cylinder, double* noise, double* scatter, double* total);
        [UnmanagedFunctionPointer(C)] internal delegate int CompareFunction(NativeCylinder* a, NativeCylinder* b, out double angle, out double axisDistance, out double radiusRelative);
        [UnmanagedFunctionPointer(C)] internal delegate int DetectorOptionsFunction(IntPtr detector, NativeDetectorOptions* options);
        [UnmanagedFunctionPointer(C)] internal delegate int DetectionProgressCallback(NativeDetectionProgress* progress, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int SetDetectionProgressFunction(IntPtr detector, DetectionProgressCallback callback, IntPtr userData);
        [UnmanagedFunctionPointer(C)] internal delegate int DetectFunction(IntPtr detector, IntPtr frame);
        [UnmanagedFunctionPointer(C)] internal delegate int DetectPointsFunction(IntPtr detector, NativePointsView* points);
        [UnmanagedFunctionPointer(C)] internal delegate int CountFunction(IntPtr detector, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int IsCompleteFunction(IntPtr detector, out int complete);
        [UnmanagedFunctionPointer(C)]
        internal delegate int DepthMovedFunction(IntPtr detector, out int columns, out int rows);
        [UnmanagedFunctionPointer(C)] internal delegate int ResultOfFunction(IntPtr detector, UIntPtr index, NativeResult* result);
        [UnmanagedFunctionPointer(C)] internal delegate int EstimateOfFunction(IntPtr detector, UIntPtr index, NativeCylinderEstimate* estimate);
        [UnmanagedFunctionPointer(C)] internal delegate int ExtentOfFunction(IntPtr detector, UIntPtr index, NativeExtent* extent);
        [UnmanagedFunctionPointer(C)] internal delegate int LabelsFunction(IntPtr detector, ushort* labels, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int IndicesFunction(IntPtr detector, UIntPtr index, uint* indices, UIntPtr capacity, out UIntPtr count);
        [UnmanagedFunctionPointer(C)] internal delegate int CloneFunction(IntPtr fitter, out IntPtr clone);
        [UnmanagedFunctionPointer(C)] internal delegate int DecideConformityFunction(double value, double deviation, uint flags, double lower, double upper, double coverage, out int conformity);
        [UnmanagedFunctionPointer(C)] internal delegate int MakeFitterFunction(IntPtr detector, UIntPtr index, out IntPtr fitter);

        internal readonly NumberFunction AbiVersion = Find<NumberFunction>("cylfuse_abi_version");
        internal readonly NumberFunction VersionNumber = Find<NumberFunction>("cylfuse_version_number");
        internal readonly TextFunction VersionString = Find<TextFunction>("cylfuse_version_string");
        internal readonly TextFunction BuildInfo = Find<TextFunction>("cylfuse_build_info");
        internal readonly ConstantTextFunction StatusString = Find<ConstantTextFunction>("cylfuse_status_string");
        internal readonly ConstantTextFunction FlagString = Find<ConstantTextFunction>("cylfuse_flag_string");
        internal readonly ConstantTextFunction TerminationString = Find<ConstantTextFunction>("cylfuse_termination_string");
        internal readonly ConstantTextFunction StartString = Find<ConstantTextFunction>("cylfuse_start_string");
        internal readonly ConstantTextFunction EndStateString = Find<ConstantTextFunction>("cylfuse_end_state_string");
        internal readonly ConstantTextFunction EndSourceString = Find<ConstantTextFunction>("cylfuse_end_source_string");
        internal readonly ConstantTextFunction LimbStatusString = Find<ConstantTextFunction>("cylfuse_limb_status_string");
        internal readonly ConstantTextFunction PartString = Find<ConstantTextFunction>("cylfuse_part_string");
        internal readonly ConstantTextFunction ConformityString = Find<ConstantTextFunction>("cylfuse_conformity_string");

        internal readonly InitFunction OptionsInit = Find<InitFunction>("cylfuse_options_init");
        internal readonly InitFunction DetectorOptionsInit = Find<InitFunction>("cylfuse_detector_options_init");
        internal readonly InitFunction IntrinsicsInit = Find<InitFunction>("cylfuse_intrinsics_init");
        internal readonly InitFunction PointsViewInit = Find<InitFunction>("cylfuse_points_view_init");
        internal readonly InitFunction DepthViewInit = Find<InitFunction>("cylfuse_depth_view_init");
        internal readonly InitFunction MaskViewInit = Find<InitFunction>("cylfuse_mask_view_init");
        internal readonly InitFunction ImageViewInit = Find<InitFunction>("cylfuse_image_view_init");
        internal readonly InitFunction SegmentsViewInit = Find<InitFunction>("cylfuse_segments_view_init");
        internal readonly InitFunction PointsOutInit = Find<InitFunction>("cylfuse_points_out_init");
        internal readonly InitFunction DepthOutInit = Find<InitFunction>("cylfuse_depth_out_init");
        internal readonly InitFunction CountsInit = Find<InitFunction>("cylfuse_counts_init");
        internal readonly InitFunction ResultInit = Find<InitFunction>("cylfuse_result_init");
        internal readonly InitFunction CylinderEstimateInit = Find<InitFunction>("cylfuse_cylinder_estimate_init");
        internal readonly InitFunction CylinderDiagnosisInit = Find<InitFunction>("cylfuse_cylinder_diagnosis_init");
        internal readonly InitFunction CompletionInit = Find<InitFunction>("cylfuse_completion_init");
        internal readonly InitFunction ExtentInit = Find<InitFunction>("cylfuse_extent_init");

        internal readonly CreateFunction FitterCreate = Find<CreateFunction>("cylfuse_fitter_create");
        internal readonly HandleFunction FitterDestroy = Find<HandleFunction>("cylfuse_fitter_destroy");
        internal readonly ReserveFunction FitterReserve = Find<ReserveFunction>("cylfuse_fitter_reserve");
        internal readonly HandleFunction FitterClear = Find<HandleFunction>("cylfuse_fitter_clear");
        internal readonly ClearInputFunction FitterClearInput = Find<ClearInputFunction>("cylfuse_fitter_clear_input");
        internal readonly HandleTextFunction FitterLastError = Find<HandleTextFunction>("cylfuse_fitter_last_error");
        internal readonly HandleFunction FitterCancel = Find<HandleFunction>("cylfuse_fitter_cancel");
        internal readonly OptionsFunction FitterSetOptions = Find<OptionsFunction>("cylfuse_fitter_set_options");
        internal readonly OptionsFunction FitterGetOptions = Find<OptionsFunction>("cylfuse_fitter_get_options");
        internal readonly SelectViewFunction FitterSelectView = Find<SelectViewFunction>("cylfuse_fitter_select_view");
        internal readonly ViewCountFunction FitterViewCount = Find<ViewCountFunction>("cylfuse_fitter_view_count");
        internal readonly IntrinsicsFunction FitterSetIntrinsics = Find<IntrinsicsFunction>("cylfuse_fitter_set_intrinsics");
        internal readonly IntrinsicsFunction FitterGetIntrinsics = Find<IntrinsicsFunction>("cylfuse_fitter_get_intrinsics");
        internal readonly CloneFunction FitterClone = Find<CloneFunction>("cylfuse_fitter_clone");
        internal readonly PoseFunction FitterSetPose = Find<PoseFunction>("cylfuse_fitter_set_pose");
        internal readonly DepthCameraFunction FitterSetDepthCamera = Find<DepthCameraFunction>("cylfuse_fitter_set_depth_camera");
        internal readonly UseFrameFunction FitterUseFrame = Find<UseFrameFunction>("cylfuse_fitter_use_frame");
        internal readonly ModelFunction FitterSetStartModel = Find<ModelFunction>("cylfuse_fitter_set_start_model");
        internal readonly SetProgressFunction FitterSetProgress = Find<SetProgressFunction>("cylfuse_fitter_set_progress");
        internal readonly SetLogFunction FitterSetLog = Find<SetLogFunction>("cylfuse_fitter_set_log");
        internal readonly PushPointsFunction FitterPushPoints = Find<PushPointsFunction>("cylfuse_fitter_push_points");
        internal readonly PushDepthFunction FitterPushDepth = Find<PushDepthFunction>("cylfuse_fitter_push_depth");
        internal readonly ImageFunction FitterPushImage = Find<ImageFunction>("cylfuse_fitter_push_image");
        internal readonly PushEdgesFunction FitterPushEdges = Find<PushEdgesFunction>("cylfuse_fitter_push_edges");
        internal readonly CountsFunction FitterCounts = Find<CountsFunction>("cylfuse_fitter_counts");
        internal readonly FitFunction FitterFit = Find<FitFunction>("cylfuse_fitter_fit");
        internal readonly EvaluateFunction FitterEvaluate = Find<EvaluateFunction>("cylfuse_fitter_evaluate");
        internal readonly ResultFunction FitterGetResult = Find<ResultFunction>("cylfuse_fitter_get_result");
        internal readonly EstimateFunction FitterGetCylinder = Find<EstimateFunction>("cylfuse_fitter_get_cylinder");
        internal readonly ResidualsFunction FitterResiduals = Find<ResidualsFunction>("cylfuse_fitter_residuals");
        internal readonly PointWeightsFunction FitterPointWeights = Find<PointWeightsFunction>("cylfuse_fitter_point_weights");
        internal readonly PointPartsFunction FitterPointParts = Find<PointPartsFunction>("cylfuse_fitter_point_parts");
        internal readonly FitAllFunction FitAll = Find<FitAllFunction>("cylfuse_fit_all");
        internal readonly ListFunction FitterLimbs = Find<ListFunction>("cylfuse_fitter_limbs");
        internal readonly ListFunction FitterLimbSamples = Find<ListFunction>("cylfuse_fitter_limb_samples");
        internal readonly EndSamplesFunction FitterEndSamples = Find<EndSamplesFunction>("cylfuse_fitter_end_samples");
        internal readonly DiagnoseFunction FitterDiagnose = Find<DiagnoseFunction>("cylfuse_fitter_diagnose");
        internal readonly CompleteBoundFunction FitterCompleteBound = Find<CompleteBoundFunction>("cylfuse_fitter_complete_bound");
        internal readonly CompleteFunction FitterComplete = Find<CompleteFunction>("cylfuse_fitter_complete");
        internal readonly CompleteDepthFunction FitterCompleteDepth = Find<CompleteDepthFunction>("cylfuse_fitter_complete_depth");
        internal readonly ExtentFunction FitterExtent = Find<ExtentFunction>("cylfuse_fitter_extent");
        internal readonly SelectEdgesFunction FitterSelectEdges = Find<SelectEdgesFunction>("cylfuse_fitter_select_edges");

        internal readonly CreateFunction FrameCreate = Find<CreateFunction>("cylfuse_frame_create");
        internal readonly HandleFunction FrameDestroy = Find<HandleFunction>("cylfuse_frame_destroy");
        internal readonly HandleTextFunction FrameLastError = Find<HandleTextFunction>("cylfuse_frame_last_error");
        internal readonly IntrinsicsFunction FrameSetIntrinsics = Find<IntrinsicsFunction>("cylfuse_frame_set_intrinsics");
        internal readonly PoseFunction FrameSetPose = Find<PoseFunction>("cylfuse_frame_set_pose");
        internal readonly DepthCameraFunction FrameSetDepthCamera = Find<DepthCameraFunction>("cylfuse_frame_set_depth_camera");
        internal readonly SetDepthFunction FrameSetDepth = Find<SetDepthFunction>("cylfuse_frame_set_depth");
        internal readonly ImageFunction FrameSetImage = Find<ImageFunction>("cylfuse_frame_set_image");

        internal readonly CreateFunction DetectorCreate = Find<CreateFunction>("cylfuse_detector_create");
        internal readonly HandleFunction DetectorDestroy = Find<HandleFunction>("cylfuse_detector_destroy");
        internal readonly HandleTextFunction DetectorLastError = Find<HandleTextFunction>("cylfuse_detector_last_error");
        internal readonly HandleFunction DetectorCancel = Find<HandleFunction>("cylfuse_detector_cancel");
        internal readonly DetectorOptionsFunction DetectorSetOptions = Find<DetectorOptionsFunction>("cylfuse_detector_set_options");
        internal readonly DetectorOptionsFunction DetectorGetOptions = Find<DetectorOptionsFunction>("cylfuse_detector_get_options");
        internal readonly OptionsFunction DetectorSetFitOptions = Find<OptionsFunction>("cylfuse_detector_set_fit_options");
        internal readonly OptionsFunction DetectorGetFitOptions = Find<OptionsFunction>("cylfuse_detector_get_fit_options");
        internal readonly SetDetectionProgressFunction DetectorSetProgress = Find<SetDetectionProgressFunction>("cylfuse_detector_set_progress");
        internal readonly DetectFunction DetectorDetect = Find<DetectFunction>("cylfuse_detector_detect");
        internal readonly DetectPointsFunction DetectorDetectPoints = Find<DetectPointsFunction>("cylfuse_detector_detect_points");
        internal readonly CountFunction DetectorCount = Find<CountFunction>("cylfuse_detector_count");
        internal readonly IsCompleteFunction DetectorIsComplete = Find<IsCompleteFunction>("cylfuse_detector_is_complete");
        internal readonly DepthMovedFunction DetectorDepthMoved = Find<DepthMovedFunction>("cylfuse_detector_depth_moved");
        internal readonly ListFunction DetectorDetections = Find<ListFunction>("cylfuse_detector_detections");
        internal readonly ResultOfFunction DetectorGetResult = Find<ResultOfFunction>("cylfuse_detector_get_result");
        internal readonly EstimateOfFunction DetectorGetCylinder = Find<EstimateOfFunction>("cylfuse_detector_get_cylinder");
        internal readonly ExtentOfFunction DetectorGetExtent = Find<ExtentOfFunction>("cylfuse_detector_get_extent");
        internal readonly LabelsFunction DetectorLabels = Find<LabelsFunction>("cylfuse_detector_labels");
        internal readonly IndicesFunction DetectorIndices = Find<IndicesFunction>("cylfuse_detector_indices");
        internal readonly MakeFitterFunction DetectorMakeFitter = Find<MakeFitterFunction>("cylfuse_detector_make_fitter");

        internal readonly DistancesFunction CylinderDistances = Find<DistancesFunction>("cylfuse_cylinder_distances");
        internal readonly ProjectFunction CylinderProject = Find<ProjectFunction>("cylfuse_cylinder_project");
        internal readonly PlanFunction Plan = Find<PlanFunction>("cylfuse_plan");
        internal readonly DecideConformityFunction DecideConformity = Find<DecideConformityFunction>("cylfuse_decide_conformity");
        internal readonly CompareFunction CylinderCompare = Find<CompareFunction>("cylfuse_cylinder_compare");
        internal readonly ProjectPointsFunction IntrinsicsProject = Find<ProjectPointsFunction>("cylfuse_intrinsics_project");
        internal readonly UnprojectFunction IntrinsicsUnproject = Find<UnprojectFunction>("cylfuse_intrinsics_unproject");

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

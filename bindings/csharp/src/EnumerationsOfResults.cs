using System;

namespace Cylfuse
{
    /// <summary>What a fit is doing.</summary>
    public enum Phase
    {
        /// <summary>It is about to look for a start, or looks for one and asks whether to go on.</summary>
        Start = 1,
        /// <summary>It iterates, or asks after an iteration whether to go on: the last state is reported again then.</summary>
        Solve = 2,
    }

    /// <summary>How much a log line matters.</summary>
    public enum LogLevel
    {
        /// <summary>No lines.</summary>
        Off = 0,
        /// <summary>Calls that failed, with the text of <c>cylfuse_fitter_last_error</c>.</summary>
        Error = 1,
        /// <summary>Warnings about a result, such as ignored edges.</summary>
        Warning = 2,
        /// <summary>What was pushed, which start was taken, how a fit ended.</summary>
        Info = 3,
        /// <summary>Every iteration.</summary>
        Debug = 4,
    }

    /// <summary>Why an iteration ended.</summary>
    public enum Termination
    {
        /// <summary>There was no iteration: the method has none, or a given model was evaluated.</summary>
        None = 0,
        /// <summary>The cost no longer fell by more than the tolerance, or reached the rounding error of the
        /// data.</summary>
        Cost = 1,
        /// <summary>No step down to the largest damping lowered the cost: a minimum to rounding.</summary>
        Stalled = 2,
        /// <summary>The limit of iterations was reached; <see cref="ResultFlags.NotConverged"/> is set too.</summary>
        MaxIterations = 3,
        /// <summary>The radius left all proportion to the data: they are flat.</summary>
        RadiusRanAway = 4,
        /// <summary>The gradient fell below its tolerance.</summary>
        Gradient = 5,
        /// <summary>The step fell below its tolerance.</summary>
        Step = 6,
    }

    /// <summary>Warnings about a result, one bit each. None of them is an error: the numbers of the result say how much
    /// it matters.</summary>
    [Flags]
    public enum ResultFlags : uint
    {
        /// <summary>No warnings.</summary>
        None = 0,
        /// <summary>Segments were given but none of them counts; the other flags and the counts say why.</summary>
        EdgesIgnored = 1,
        /// <summary>Some segments have no length or lie outside the field of the camera model.</summary>
        SegmentsUnusable = 2,
        /// <summary>Two segments cross each other: they cannot be the two limbs.</summary>
        EdgesCross = 4,
        /// <summary>Two segments lie on one line to within 2 pixels: they are the same limb.</summary>
        EdgesCoincide = 8,
        /// <summary>The rays of the endpoints do not meet the plane of the limbs in front of the camera.</summary>
        EdgesBehind = 16,
        /// <summary>The edges alone (an edge weight of 1) do not tell the scale: that of the start was kept.</summary>
        ScaleHeld = 32,
        /// <summary>The data hardly determine the radius: see its stated deviation.</summary>
        WeakRadius = 64,
        /// <summary>The coordinates are coarser than 0.01 % of the radius: a float cloud far from the origin.</summary>
        ResolutionLost = 128,
        /// <summary>The limit of iterations came before convergence. Of a cylinder of a scene also: its depth came
        /// without an image, no work was left for its fit, or no fit was as good, and it is what the search found.</summary>
        NotConverged = 256,
        /// <summary>Most points lie on the wall that the camera cannot see.</summary>
        HiddenWall = 512,
        /// <summary>The camera is inside the cylinder: there are no limbs.</summary>
        CameraInside = 1024,
        /// <summary>Points with coordinates that are not finite were left out.</summary>
        PointsNotFinite = 2048,
        /// <summary>The radius by the points alone and the radius by the limbs differ by more than 4 standard
        /// deviations: <see cref="FitResult.RadiusFromPoints"/> and <see cref="FitResult.RadiusFromLimbs"/> say how. An
        /// offset of the depth, depth that is smeared or bent, wrong intrinsics or edges that are not the limbs do
        /// that. Or the points alone, far from edges that were taken as given, would be another cylinder: one 1.5 times
        /// nearer to them, or surely 1.5 times as large or as small. Or the points contradict limbs or edges, which were
        /// not followed.</summary>
        PointsAndLimbsDisagree = 4096,
        /// <summary>The radius is at its limit, and the data fit better beyond it. Of a known radius: the data
        /// contradict it by more than 4 standard deviations.</summary>
        RadiusAtLimit = 8192,
        /// <summary>The axis is on the border of its cone, and the data fit better beyond it. Of a known direction: the
        /// data contradict it by more than 4 standard deviations.</summary>
        AxisAtLimit = 16384,
        /// <summary>The data do not tell how uncertain the result is, and deviations and covariance are NaN: fewer than
        /// eight points are independent, some degree of freedom is not determined, the coordinates are coarser than the noise,
        /// or most points lie on the cylinder to the last digit and more than a tenth do not.</summary>
        UncertaintyUnknown = 32768,
        /// <summary>Depth and image are shifted against each other across the axis, by a wrong registration or wrong
        /// principal points. Or one of the limbs is the edge of something else, and the radius is wrong. From a detector
        /// also: the whole depth image was shifted, and has been moved.</summary>
        DepthShifted = 65536,
        /// <summary>A mask holds the pixels that have depth and no others, although depth is missing around it: its sides are
        /// no hint where the limbs are.</summary>
        MaskEndsWithDepth = 131072,
        /// <summary>The points do not lie on the cylinder: they scatter about its surface by more than 1 % of their distance
        /// from the camera or, without a camera, by more than a quarter of the radius, or have a shape along the axis that
        /// no cylinder has, or lie on two planes, as the sides of a box do.</summary>
        PoorFit = 262144,
        /// <summary>The lines of both limbs turn against each other, so that the radius changes along the axis: the body
        /// is no cylinder, or one of the lines is no limb. Or, without them, the sides of the mask do, or points without a camera tell it.</summary>
        BodyTapers = 524288,
        /// <summary>The mask ends beside a limb of the cylinder along most of the axis, by more than masks are off and the
        /// deviation of the radius says; or no limb was seen, and the radii by the mask and by the points differ by more than
        /// 2.5 standard deviations, or the points would scatter 3 times as much if the mask were followed; or the mask holds
        /// another body.</summary>
        MaskDisagrees = 1048576,
    }

    /// <summary>Which residuals to list.</summary>
    public enum ResidualKind
    {
        /// <summary>Signed distance of every used point from the surface, in the unit of length, negative inside; in
        /// the order in which the points were pushed, without the dropped ones.</summary>
        Points = 1,
        /// <summary>Signed distance of both endpoints of every used segment from its limb line, in ideal
        /// pixels.</summary>
        Edges = 2,
    }

    /// <summary>What an end of the visible cylinder is.</summary>
    public enum EndState
    {
        /// <summary>Nothing tells what lies beyond the end: no depth was measured there, or no depth image pushed.</summary>
        Unknown = 0,
        /// <summary>The surface ends there: what lies beyond is farther than the surface would be.</summary>
        Seen = 1,
        /// <summary>The border of the image cuts the cylinder off.</summary>
        Cut = 2,
        /// <summary>Something nearer than the surface covers what lies beyond.</summary>
        Hidden = 3,
    }

    /// <summary>What the position of an end was taken from.</summary>
    public enum EndSource
    {
        /// <summary>The extreme point completed over the mask.</summary>
        Extreme = 0,
        /// <summary>Where the lines along the surface leave the mask, or where within the mask the depth shows that the body
        /// ends: at a cap, an opening, a shoulder or a narrower part. Also where the image shows an arc that is less certain than
        /// that.</summary>
        Mask = 1,
        /// <summary>Mostly the arc of the end circle in the image: it is joined with mask and depth by the variances, and is
        /// the more certain.</summary>
        Image = 2,
        /// <summary>The last of the surface inside the border of the image.</summary>
        Border = 3,
        /// <summary>The points on the surface, where there is no mask, and from inside a pipe.</summary>
        Points = 4,
    }

    /// <summary>What a measurement says about a tolerance.</summary>
    public enum Conformity
    {
        /// <summary>It does not tell: its uncertainty reaches over a limit or is not known, or a warning puts it in
        /// doubt.</summary>
        Undecided = 0,
        /// <summary>The value is within the limits with all of its uncertainty.</summary>
        Conforming = 1,
        /// <summary>The value is outside the limits with all of its uncertainty.</summary>
        NotConforming = 2,
    }

    /// <summary>What a point in the mask belongs to.</summary>
    public enum Part : byte
    {
        /// <summary>The lateral surface.</summary>
        Body = 1,
        /// <summary>A cap: it lies in the plane across the axis at an end.</summary>
        Cap = 2,
        /// <summary>The inside of the cylinder, seen through an open end: its inner wall or its bottom.</summary>
        InnerWall = 3,
        /// <summary>Something nearer than the surface: a lid or a rim that is wider, a handle, what stands in
        /// front.</summary>
        Other = 4,
        /// <summary>Something farther away than the cylinder: the background.</summary>
        Behind = 5,
    }

    /// <summary>Whether a limb was located in the image, or why not.</summary>
    public enum LimbStatus
    {
        /// <summary>It was located.</summary>
        Located = 0,
        /// <summary>The image was not searched: there is none, the edges were taken as given, or the objective does not
        /// look.</summary>
        NotSearched = 1,
        /// <summary>The cylinder has no limbs in front of the camera: the camera is inside it, or it lies
        /// behind.</summary>
        NoLimbs = 2,
        /// <summary>Fewer than 12 rows or columns of the image show the limb, or something in front covers
        /// it.</summary>
        TooShort = 3,
        /// <summary>No line near the expected place has more of an edge than noise gives.</summary>
        NoEdge = 4,
        /// <summary>The line left the expected place while it was refined, or lies beside the mask.</summary>
        OutOfReach = 5,
        /// <summary>The line would be less certain than one set by hand, or what is there is softer than any
        /// limb.</summary>
        Uncertain = 6,
        /// <summary>A small part of the line carries it all.</summary>
        Patchy = 7,
        /// <summary>The other limb was found at the same place, and more certainly.</summary>
        SameLine = 8,
    }
}

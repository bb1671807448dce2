using System;

namespace Cylfuse
{
    /// <summary>What a call returns: 0 when it did what it was asked to, else a negative number that says why not. A
    /// failed call changes nothing and writes no output unless its text says so; the handle stays usable, but for <see
    /// cref="Status.Panic"/>. The numbers never change and new ones may be added: treat an unknown negative number as a
    /// failure.</summary>
    public enum Status
    {
        /// <summary>The call did what it was asked to.</summary>
        Ok = 0,
        /// <summary>An argument or field has a value outside its documented range.</summary>
        InvalidArgument = -1,
        /// <summary>A pointer that is needed is null.</summary>
        NullPointer = -2,
        /// <summary>A <c>struct_size</c> or <c>element_size</c> is smaller than the first version of the struct or
        /// larger than 4096, or a struct to be read is larger than this library knows it and uses fields that this
        /// library does not know.</summary>
        StructSize = -3,
        /// <summary>The program was compiled for another, incompatible version of the library.</summary>
        AbiMismatch = -4,
        /// <summary>The call came before something that it needs.</summary>
        BadState = -5,
        /// <summary>Another call on the same handle is running, in another thread or around a callback, and one of the
        /// two may change it.</summary>
        Busy = -6,
        /// <summary>The buffer for the output is too small; the call says how much it needs and writes nothing
        /// else.</summary>
        BufferTooSmall = -7,
        /// <summary>Memory could not be allocated: pass less data at once, or free memory.</summary>
        OutOfMemory = -8,
        /// <summary>Not supported with these options or data.</summary>
        Unsupported = -9,
        /// <summary>Images on one pixel grid have different sizes.</summary>
        SizeMismatch = -10,
        /// <summary>No camera works with these intrinsics.</summary>
        InvalidIntrinsics = -11,
        /// <summary>Too few usable points. A fit needs 5, as many as a cylinder has degrees of freedom; a plan needs 8 points
        /// with independent noise.</summary>
        TooFewPoints = -20,
        /// <summary>The points are as flat as a plane.</summary>
        PlanarPoints = -21,
        /// <summary>The points lie on one straight line.</summary>
        CollinearPoints = -22,
        /// <summary>No pixel of the mask is set.</summary>
        EmptyMask = -23,
        /// <summary>No pixel in the region has a usable depth.</summary>
        NoDepth = -24,
        /// <summary>No start for the iteration could be found.</summary>
        NoStart = -25,
        /// <summary>The camera sees no limbs of the cylinder, or nothing that was given meets it.</summary>
        EdgeGeometry = -26,
        /// <summary>The arithmetic left the range of numbers.</summary>
        Numerical = -27,
        /// <summary>The progress callback or <see cref="Fitter.Cancel"/> asked to stop.</summary>
        Cancelled = -40,
        /// <summary>A defect of the library. The handle can only be destroyed after it; others are not
        /// affected.</summary>
        Panic = -99,
    }

    /// <summary>How the cylinder is estimated.</summary>
    public enum Method
    {
        /// <summary>Points and edges together, by the chosen <see cref="Objective"/>.</summary>
        Fused = 0,
        /// <summary>Points alone by plain least squares; edges are ignored.</summary>
        Points = 1,
        /// <summary>Random sample consensus over the points, without a final iteration.</summary>
        Ransac = 2,
        /// <summary>Eberly's algebraic fit by the moments of the points, without a final iteration.</summary>
        Eberly = 3,
    }

    /// <summary>What <see cref="Method.Fused"/> minimises.</summary>
    public enum Objective
    {
        /// <summary>Robust points and the distances of the segment endpoints in pixels, each weighted by its own scale.
        /// Takes any number of segments, none included.</summary>
        Robust = 0,
        /// <summary>F = (1 - w) E_P + w E_L of Zhang, Liu and Wang (Sensors 2026, 26(5), 1687), exactly, with the
        /// weight w = <see cref="FitOptions.EdgeWeight"/>. Takes exactly two segments, or w = 0.</summary>
        Paper = 1,
    }

    /// <summary>Where the iteration starts.</summary>
    public enum StartKind
    {
        /// <summary>The candidate of the kinds below that explains the data best. Never in a result.</summary>
        Auto = 0,
        /// <summary>From two limb segments, scaled by the points.</summary>
        Limbs = 1,
        /// <summary>Eberly's algebraic fit by the moments of the points.</summary>
        Moments = 2,
        /// <summary>Random sample consensus over the points.</summary>
        Ransac = 3,
        /// <summary>The model given by <see cref="Fitter.SetStartModel"/>.</summary>
        Model = 4,
        /// <summary>The cylinder of the last successful fit of the fitter, for frames of a sequence, also after
        /// <see cref="Fitter.Clear"/>. Where its limbs are about where it or the points have them, and look in the image
        /// as they did, they are not searched, and the result depends on the fits before. Where not, and before the
        /// first fit, as <see cref="Auto"/>, with that cylinder or the start model one of the candidates. Of points alone
        /// that hold several bodies the one near that cylinder is fitted.</summary>
        Last = 5,
    }

    /// <summary>Whether the points must lie on the wall of the cylinder that a camera at the origin sees. There is
    /// often a second minimum with the cylinder between camera and surface; this rule refuses it.</summary>
    public enum NearWall
    {
        /// <summary>On when intrinsics are set: only then is the origin known to be a camera.</summary>
        Auto = 0,
        /// <summary>On: the origin is the observer.</summary>
        On = 1,
        /// <summary>Off: the minimum nearest to the start stays.</summary>
        Off = 2,
    }

    /// <summary>The coordinates in which the iteration steps. All reach the same optima.</summary>
    public enum Chart
    {
        /// <summary>Orthonormal for the paper's objective where a camera stands outside the cylinder, else
        /// Local.</summary>
        Auto = 0,
        /// <summary>Shift and tilt of the axis at the data: regular wherever the axis runs.</summary>
        Local = 1,
        /// <summary>The orthonormal representation about the origin of coordinates, as in the paper: singular for an
        /// axis through the origin.</summary>
        Orthonormal = 2,
    }

    /// <summary>What given edge segments are for the objective Robust. No other looks for limbs in the image.</summary>
    public enum EdgeUse
    {
        /// <summary>A start: where there is an image, the limbs are located in it and join the fit.</summary>
        Refine = 0,
        /// <summary>The measurement: no limbs are looked for in the image. The arcs of the ends are.</summary>
        AsGiven = 1,
    }

    /// <summary>How the ends of the visible cylinder are found in a mask. Without one, and from inside a pipe, the points
    /// on the surface tell them.</summary>
    public enum ExtentRule
    {
        /// <summary>Located for the method Fused with the objective Robust, Extremes otherwise.</summary>
        Auto = 0,
        /// <summary>The rule of the paper: the extreme positions along the axis of the points completed over the
        /// mask.</summary>
        Extremes = 1,
        /// <summary>From all lines along the surface together, in the mask and, when there is one, in the
        /// image.</summary>
        Located = 2,
    }

    /// <summary>Whether a detector looks at the image of a frame.</summary>
    public enum ImageUse
    {
        /// <summary>Where there is one.</summary>
        Auto = 0,
        /// <summary>Never: by depth alone.</summary>
        Ignore = 1,
    }

    /// <summary>What a detector is doing.</summary>
    public enum DetectionPhase
    {
        /// <summary>It is about to look for cylinders.</summary>
        Search = 1,
        /// <summary>It fits those that were found.</summary>
        Fit = 2,
    }

    /// <summary>The distortion of the lens. What the numbers in Intrinsics mean.</summary>
    public enum DistortionModel
    {
        /// <summary>A pinhole; all coefficients are 0.</summary>
        None = 0,
        /// <summary>Brown and Conrady: k1 k2 p1 p2 k3 k4 k5 k6 in the order of OpenCV; the missing ones of a shorter
        /// list are 0.</summary>
        BrownConrady = 1,
        /// <summary>Kannala and Brandt, the fisheye model of OpenCV: k1 k2 k3 k4; the other coefficients are 0. Rays
        /// less than 89 degrees from the axis.</summary>
        KannalaBrandt = 2,
    }

    /// <summary>How the points of an output buffer are arranged.</summary>
    public enum Layout
    {
        /// <summary>Only the points that exist, one after the other, row by row of the image.</summary>
        Packed = 0,
        /// <summary>One point for each pixel of the image, NaN where there is none.</summary>
        Organised = 1,
    }

    /// <summary>Data of a view, one bit each.</summary>
    [Flags]
    public enum Inputs : uint
    {
        /// <summary>Nothing.</summary>
        None = 0,
        /// <summary>All points: those of clouds and those that were made of depth images.</summary>
        Points = 1,
        /// <summary>The depth image and its mask, which completion and extent look at; the points that were made of it
        /// stay.</summary>
        Depth = 2,
        /// <summary>Edge segments, of <see cref="Fitter.PushEdges(Segments)"/>.</summary>
        Edges = 4,
        /// <summary>The image, of <see cref="Fitter.PushImage"/> and of a frame.</summary>
        Image = 8,
    }
}

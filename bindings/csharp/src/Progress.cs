using System;

namespace Cylfuse
{
    /// <summary>The state of a running fit, before each iteration.</summary>
    public sealed class Progress
    {
        private readonly NativeProgress native;

        /// <summary>What the fit is doing.</summary>
        public Phase Phase => (Phase)native.phase;

        /// <summary>Iterations so far. Begins again at 0 with every start that is tried and every robust
        /// round.</summary>
        public int Iteration => (int)native.iteration;

        /// <summary>Maximum number of iterations.</summary>
        public int MaxIterations => (int)native.max_iterations;

        /// <summary>The lowest cost so far, unit of length squared; infinite in the phase Start.</summary>
        public double Cost => native.cost;

        /// <summary>The damping of the next step; 0 in the phase Start.</summary>
        public double Lambda => native.lambda;

        /// <summary>The best cylinder so far; null in the phase Start.</summary>
        public Cylinder Cylinder { get; }

        internal unsafe Progress(NativeProgress native)
        {
            this.native = native;
            if (native.cylinder != IntPtr.Zero) Cylinder = new Cylinder(*(NativeCylinder*)native.cylinder);
        }
    }
}

namespace Cylfuse
{
    /// <summary>The state of a running fit, before each linear solve.</summary>
    public sealed class Progress
    {
        /// <summary>What the fit is doing.</summary>
        public Phase Phase { get; }

        /// <summary>Linear solves so far. Begins again at 0 with every start that is tried and every robust
        /// round.</summary>
        public int Iteration { get; }

        /// <summary>Most linear solves.</summary>
        public int MaxIterations { get; }

        /// <summary>The lowest cost so far, unit of length squared; infinite in the phase Start.</summary>
        public double Cost { get; }

        /// <summary>The damping of the next step; 0 in the phase Start.</summary>
        public double Lambda { get; }

        /// <summary>The best cylinder so far; of radius 0 in the phase Start.</summary>
        public Cylinder Model { get; }

        internal unsafe Progress(NativeProgress* native)
        {
            Phase = (Phase)native->phase;
            Iteration = (int)native->iteration;
            MaxIterations = (int)native->max_iterations;
            Cost = native->cost;
            Lambda = native->lambda;
            Model = new Cylinder(&native->model);
        }
    }
}

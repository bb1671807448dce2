using System;

namespace Cylfuse
{
    /// <summary>A call of the library failed. <see cref="Status"/> is the kind; the message names the value, the limit
    /// and the remedy. A call that failed has changed nothing.</summary>
    /// <remarks>Arrays of a wrong shape give an <see cref="ArgumentException"/> before the library is called.</remarks>
    public class CylfuseException : Exception
    {
        /// <summary>The kind of the failure.</summary>
        public Status Status { get; }

        internal CylfuseException(Status status, string message) : base(message)
        {
            Status = status;
        }

        /// <summary>The exception of the class for a status.</summary>
        internal static CylfuseException For(Status status, string message) =>
            status <= Status.TooFewPoints && status > Status.Cancelled
                ? new UnusableDataException(status, message)
                : new CylfuseException(status, message);
    }

    /// <summary>The data do not determine a cylinder: too few points, flat points, no depth in the mask and the like.
    /// In a loop over frames the reason to leave one out; every other failure is one of the program.</summary>
    public sealed class UnusableDataException : CylfuseException
    {
        internal UnusableDataException(Status status, string message) : base(status, message) { }
    }
}

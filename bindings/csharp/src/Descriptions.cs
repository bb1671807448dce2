using System.Collections.Generic;

namespace Cylfuse
{
    /// <summary>The constants of results as text: the name in C, a colon, and what it means in a few words.</summary>
    public static class Descriptions
    {
        /// <summary>What each warning that is set means; empty for none.</summary>
        public static string[] Describe(this ResultFlags flags)
        {
            var texts = new List<string>();
            for (int bit = 0; bit < 32; bit++)
            {
                uint flag = (uint)flags & 1u << bit;
                if (flag != 0) texts.Add(Library.Text(Native.Functions.FlagString(unchecked((int)flag))));
            }
            return texts.ToArray();
        }

        /// <summary>What it means that an iteration ended so.</summary>
        public static string Describe(this Termination termination) =>
            Library.Text(Native.Functions.TerminationString((int)termination));

        /// <summary>What it means that an iteration starts or started so.</summary>
        public static string Describe(this StartKind start) => Library.Text(Native.Functions.StartString((int)start));

        /// <summary>What the state of an end means.</summary>
        public static string Describe(this EndState state) => Library.Text(Native.Functions.EndStateString((int)state));

        /// <summary>What the source of the position of an end means.</summary>
        public static string Describe(this EndSource source) =>
            Library.Text(Native.Functions.EndSourceString((int)source));

        /// <summary>What it means that a limb was located, or was not.</summary>
        public static string Describe(this LimbStatus status) =>
            Library.Text(Native.Functions.LimbStatusString((int)status));

        /// <summary>What it means that a point belongs to this.</summary>
        public static string Describe(this Part part) => Library.Text(Native.Functions.PartString((int)part));

        /// <summary>What a decision about a tolerance means.</summary>
        public static string Describe(this Conformity conformity) =>
            Library.Text(Native.Functions.ConformityString((int)conformity));
    }
}

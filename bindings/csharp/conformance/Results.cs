using System;
using System.Collections.Generic;
using System.IO;
using System.Json;
using System.Linq;

namespace Cylfuse.Conformance
{
    /// <summary>Runs the golden cases and prints the results as bindings/conformance/README.md says.</summary>
    internal static class Results
    {
        private static void Main(string[] arguments)
        {
            JsonValue file = JsonValue.Parse(File.ReadAllText(arguments[0]));
            foreach (JsonValue golden in (JsonArray)file["cases"])
            {
                using (var runner = new Runner(file))
                {
                    int index = 0;
                    foreach (JsonValue step in (JsonArray)golden["steps"])
                        Print(runner, step, $"{(string)golden["name"]}\t{index++}");
                }
            }
        }

        private static void Print(Runner runner, JsonValue step, string name)
        {
            try
            {
                Dictionary<string, double[]> outputs = runner.Run(step);
                Console.WriteLine($"{name}\tok");
                foreach (var output in outputs)
                    Console.WriteLine($"{name}\t{output.Key}\t{string.Join(" ", output.Value.Select(Bits))}");
            }
            catch (CylfuseException failure)
            {
                string status = Names.OfC(failure.Status.ToString()).ToUpperInvariant();
                Console.WriteLine($"{name}\terror\t{status}\t{failure.Message}");
            }
        }

        /// <summary>The sign and the payload of a NaN say nothing.</summary>
        private static string Bits(double number) =>
            double.IsNaN(number) ? "nan" : BitConverter.DoubleToInt64Bits(number).ToString("x16");
    }

    /// <summary>Names in C# and in C.</summary>
    internal static class Names
    {
        /// <summary>EdgeRmsPixels becomes edge_rms_pixels.</summary>
        internal static string OfC(string name) =>
            string.Concat(name.Select((letter, k) =>
                (char.IsUpper(letter) && k > 0 ? "_" : "") + char.ToLowerInvariant(letter)));

        /// <summary>edge_rms_pixels becomes EdgeRmsPixels.</summary>
        internal static string OfCSharp(string name) =>
            string.Concat(name.Split('_').Select(word => char.ToUpperInvariant(word[0]) + word.Substring(1)));
    }
}

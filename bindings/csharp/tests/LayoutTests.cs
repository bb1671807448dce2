using System;
using System.Collections.Generic;
using System.IO;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;

namespace Cylfuse.Tests
{
    /// <summary>The structs of the binding against tests/data/abi_layout.txt, the statuses against
    /// status_codes.txt.</summary>
    [Tests]
    internal static class LayoutTests
    {
        private static string Data => Path.Combine(
            Environment.GetEnvironmentVariable("CYLFUSE_REPOSITORY") ??
                throw new Exception("CYLFUSE_REPOSITORY is not set: run test.sh"), "tests", "data");

        public static void StructsHaveTheLayoutOfTheLibrary()
        {
            Type type = null;
            var seen = new HashSet<string>();
            foreach (string line in File.ReadAllLines(Path.Combine(Data, "abi_layout.txt")))
            {
                string[] words = line.Split(new[] { ' ' }, StringSplitOptions.RemoveEmptyEntries);
                if (!line.StartsWith(" "))
                {
                    string name = "Cylfuse.Native" + string.Concat(words[0].Substring("cylfuse_".Length).Split('_').Select(w => char.ToUpperInvariant(w[0]) + w.Substring(1)));
                    type = typeof(Fitter).Assembly.GetType(name);
                    Check.That(type != null, $"{name} is missing");
                    Check.Equal(int.Parse(words[1]), Marshal.SizeOf(type), words[0]);
                    seen.Clear();
                }
                else
                {
                    Check.Equal(int.Parse(words[1]), (int)Marshal.OffsetOf(type, words[0]), $"{type.Name}.{words[0]}");
                    Check.That(seen.Add(words[0]), "listed twice");
                }
            }
            Check.That(type != null, "the list is empty");
        }

        public static void StatusesHaveTheNumbersOfTheLibrary()
        {
            string[] lines = File.ReadAllLines(Path.Combine(Data, "status_codes.txt"));
            foreach (string line in lines)
            {
                string[] words = line.Split(' ');
                string name = ((Status)int.Parse(words[0])).ToString();
                Check.Equal(words[1].Replace("_", ""), name.ToUpperInvariant());
            }
            Check.Equal(lines.Length, Enum.GetValues(typeof(Status)).Length, "number of statuses");
        }

        public static void EveryFunctionOfTheHeaderIsBound()
        {
            int delegates = typeof(Fitter).Assembly.GetType("Cylfuse.NativeFunctions")
                .GetFields(BindingFlags.NonPublic | BindingFlags.Instance).Count(field =>
                    typeof(Delegate).IsAssignableFrom(field.FieldType));
            Check.Equal(File.ReadAllLines(Path.Combine(Data, "symbols.txt")).Length, delegates);
        }
    }
}

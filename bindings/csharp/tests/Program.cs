using System;
using System.Linq;
using System.Reflection;

namespace Cylfuse.Tests
{
    /// <summary>Marks a class whose public static methods are tests.</summary>
    [AttributeUsage(AttributeTargets.Class)]
    internal sealed class TestsAttribute : Attribute { }

    /// <summary>Runs all tests and prints "N passed, N failed". A runner of 30 lines, because Debian has no test
    /// framework for Mono that works without the whole of Mono.</summary>
    internal static class Program
    {
        private static int Main(string[] arguments)
        {
            if (arguments.Contains(nameof(DetectorTests.PrintMissingExtents))) return DetectorTests.PrintMissingExtents();
            if (arguments.Length > 0) return LoadingTests.Open();
            int passed = 0, failed = 0;
            var tests = Assembly.GetExecutingAssembly().GetTypes()
                .Where(type => type.GetCustomAttribute<TestsAttribute>() != null)
                .SelectMany(type => type.GetMethods(BindingFlags.Public | BindingFlags.Static));
            foreach (MethodInfo test in tests)
            {
                try
                {
                    test.Invoke(null, null);
                    passed++;
                    Console.WriteLine($"ok     {test.DeclaringType.Name}.{test.Name}");
                }
                catch (TargetInvocationException failure)
                {
                    failed++;
                    Console.WriteLine($"FAILED {test.DeclaringType.Name}.{test.Name}\n{failure.InnerException}");
                }
            }
            Console.WriteLine($"{passed} passed, {failed} failed");
            return failed == 0 && passed > 0 ? 0 : 1;
        }
    }

    internal static class Check
    {
        internal static void That(bool condition, string what)
        {
            if (!condition) throw new Exception(what);
        }

        internal static void Equal<T>(T expected, T actual, string what = "value") =>
            That(Equals(expected, actual), $"{what}: {actual} instead of {expected}");

        internal static void Near(double expected, double actual, double tolerance, string what = "value") =>
            That(Math.Abs(actual - expected) <= tolerance, $"{what}: {actual} instead of {expected} to {tolerance}");

        internal static T Throws<T>(Action action, string part) where T : Exception
        {
            try { action(); }
            catch (T thrown)
            {
                That(thrown.Message.Contains(part), $"the message lacks '{part}': {thrown.Message}");
                return thrown;
            }
            throw new Exception($"no {typeof(T).Name} was thrown");
        }

        internal static void Fails(Status status, Action action, string part = "") =>
            Equal(status, Throws<CylfuseException>(action, part).Status, "status");
    }
}

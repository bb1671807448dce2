package org.cylfuse;

import org.junit.runner.Description;
import org.junit.runner.JUnitCore;
import org.junit.runner.Result;
import org.junit.runner.notification.Failure;
import org.junit.runner.notification.RunListener;

/** Runs the test classes that are named and prints "N passed, N failed" at the end. */
public final class RunTests {
    private RunTests() {}

    public static void main(String[] classes) throws ClassNotFoundException {
        Class<?>[] tests = new Class<?>[classes.length];
        for (int k = 0; k < classes.length; k++) {
            tests[k] = Class.forName(classes[k]);
        }
        JUnitCore core = new JUnitCore();
        core.addListener(new RunListener() {
            @Override
            public void testStarted(Description test) {
                System.out.println("test " + test.getTestClass().getSimpleName() + "." + test.getMethodName());
            }

            @Override
            public void testFailure(Failure failure) {
                System.out.println("FAILED " + failure.getDescription() + "\n" + failure.getTrace());
            }
        });
        Result result = core.run(tests);
        System.out.println((result.getRunCount() - result.getFailureCount()) + " passed, " + result.getFailureCount() + " failed");
        System.exit(result.wasSuccessful() && result.getRunCount() > 0 ? 0 : 1);
    }
}

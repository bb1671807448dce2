package org.cylfuse;

import static org.junit.Assert.assertEquals;
import static org.junit.Assert.assertTrue;
import static org.junit.Assume.assumeNotNull;

import java.io.IOException;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.ArrayList;
import java.util.List;
import org.junit.Test;

/**
 * What happens when the native library is missing or another one. Each case is a process of its own, because a process
 * opens the library once.
 */
public class LoadingTest {
    /** The other process. */
    public static void main(String[] arguments) {
        try (Fitter fitter = new Fitter()) {
            System.out.print("opened " + fitter.counts().pointsGiven());
        } catch (UnsatisfiedLinkError failure) {
            System.out.print(failure.getMessage());
        }
    }

    private static String open(String library, String... options) throws IOException, InterruptedException {
        return run(LoadingTest.class, library, options);
    }

    /** Runs another process with another library; gives what it printed. */
    static String run(Class<?> program, String library, String... options) throws IOException, InterruptedException {
        List<String> command = new ArrayList<>();
        command.add(Path.of(System.getProperty("java.home"), "bin", "java").toString());
        command.addAll(List.of(options));
        command.addAll(List.of("-cp", System.getProperty("java.class.path"), program.getName()));
        ProcessBuilder builder = new ProcessBuilder(command).redirectError(ProcessBuilder.Redirect.INHERIT);
        builder.environment().put("CYLFUSE_LIBRARY", library);
        Process process = builder.start();
        String printed = new String(process.getInputStream().readAllBytes(), StandardCharsets.UTF_8);
        assertEquals(printed, 0, process.waitFor());
        return printed;
    }

    private static void assertSays(String printed, String... parts) {
        for (String part : parts) {
            assertTrue(printed, printed.contains(part));
        }
    }

    @Test
    public void aMissingLibraryIsNamed() throws Exception {
        assertSays(open("/nowhere/libcylfuse.so"), "CYLFUSE_LIBRARY names this file", "/nowhere/libcylfuse.so: cannot open");
    }

    @Test
    public void whatIsNoLibraryIsRefused() throws Exception {
        assertSays(open("/dev/null"), "CYLFUSE_LIBRARY names this file", "/dev/null: ");
    }

    @Test
    public void anotherLibraryIsRefused() throws Exception {
        assertSays(open("libm.so.6"), "libm.so.6 is not the native library of this package", "cylfuse_abi_version");
    }

    /** A library that says of itself that it has another interface. */
    private static String otherInterface() {
        String library = System.getenv("CYLFUSE_OTHER_ABI");
        assumeNotNull(library); // test.sh makes it; Maven does not
        return library;
    }

    @Test
    public void anotherBinaryInterfaceIsRefused() throws Exception {
        String library = otherInterface();
        assertSays(open(library), library, "version 2 of the binary interface; this package needs version 1");
    }

    @Test
    public void theLibraryOfTheJarComesBeforeAnother() throws Exception {
        String library = otherInterface();
        Path folder = Files.createTempDirectory("cylfuse");
        Path other = folder.resolve("libcylfuse.so");
        Files.copy(Path.of(library), other);
        assertEquals("opened 0", open("", "-Djna.library.path=" + folder));
        Files.delete(other);
        Files.delete(folder);
    }
}

package org.cylfuse;

import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import com.google.gson.JsonParser;
import java.io.IOException;
import java.io.PrintStream;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.Map;
import java.util.stream.Collectors;

/** Runs the golden cases and prints the results as bindings/conformance/README.md says. */
public final class ConformanceResults {
    private ConformanceResults() {}

    public static void main(String[] arguments) throws IOException, ReflectiveOperationException {
        JsonObject file = JsonParser.parseString(Files.readString(Path.of(arguments[0]))).getAsJsonObject();
        PrintStream out = new PrintStream(System.out, false, StandardCharsets.UTF_8);
        for (JsonElement element : file.getAsJsonArray("cases")) {
            JsonObject golden = element.getAsJsonObject();
            try (ConformanceRunner runner = new ConformanceRunner(file)) {
                int index = 0;
                for (JsonElement step : golden.getAsJsonArray("steps")) {
                    out.print(results(runner, step.getAsJsonObject(), golden.get("name").getAsString() + "\t" + index++));
                }
            }
        }
        out.flush();
    }

    private static String results(ConformanceRunner runner, JsonObject step, String name) throws ReflectiveOperationException {
        try {
            Map<String, double[]> outputs = runner.run(step);
            StringBuilder lines = new StringBuilder(name + "\tok\n");
            outputs.forEach((field, numbers) -> lines.append(name + "\t" + field + "\t"
                    + Arrays.stream(numbers).mapToObj(ConformanceResults::bits).collect(Collectors.joining(" ")) + "\n"));
            return lines.toString();
        } catch (CylfuseException failure) {
            return name + "\terror\t" + failure.status() + "\t" + failure.getMessage() + "\n";
        }
    }

    /** The sign and the payload of a NaN say nothing. */
    private static String bits(double number) {
        return Double.isNaN(number) ? "nan" : String.format("%016x", Double.doubleToRawLongBits(number));
    }
}

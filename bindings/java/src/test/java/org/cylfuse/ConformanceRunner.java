package org.cylfuse;

import com.google.gson.JsonArray;
import com.google.gson.JsonElement;
import com.google.gson.JsonObject;
import java.lang.reflect.Field;
import java.lang.reflect.RecordComponent;
import java.nio.Buffer;
import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.DoubleBuffer;
import java.nio.FloatBuffer;
import java.nio.ShortBuffer;
import java.util.ArrayList;
import java.util.Arrays;
import java.util.Base64;
import java.util.LinkedHashMap;
import java.util.List;
import java.util.Locale;
import java.util.Map;
import java.util.Set;
import java.util.stream.Collectors;
import java.util.stream.IntStream;

/** Runs one golden case of bindings/conformance/cases.json, step by step. */
final class ConformanceRunner implements AutoCloseable {
    private final JsonObject file;
    private Fitter fitter = new Fitter();
    private Frame frame = new Frame();
    private Detector detector = new Detector();

    ConformanceRunner(JsonObject file) {
        this.file = file;
    }

    @Override
    public void close() {
        fitter.close();
        frame.close();
        detector.close();
    }

    /** What a step gives: numbers under the names of the C fields. */
    Map<String, double[]> run(JsonObject step) throws ReflectiveOperationException {
        Map<String, double[]> outputs = new LinkedHashMap<>();
        Cylinder model = cylinder(step.get("model"));
        switch (text(step, "call")) {
            case "new_fitter" -> {
                fitter.close();
                fitter = new Fitter();
            }
            case "new_frame" -> {
                frame.close();
                frame = new Frame();
            }
            case "select_view" -> fitter.selectView(step.get("index").getAsInt());
            case "view_count" -> outputs.put("count", new double[] {fitter.viewCount()});
            case "set_pose" -> fitter.setPose(pose(step));
            case "frame_set_pose" -> frame.setPose(pose(step));
            case "frame_set_intrinsics" -> frame.setIntrinsics(camera(step));
            case "set_depth_camera" -> fitter.setDepthCamera(camera(step), pose(step));
            case "frame_set_depth_camera" -> frame.setDepthCamera(camera(step), pose(step));
            case "frame_set_depth" -> frame.setDepth(depth(step));
            case "frame_set_image" -> frame.setImage(image(step));
            case "use_frame" -> fitter.useFrame(frame, mask(step));
            case "clear_input" -> fitter.clearInput(step.getAsJsonArray("inputs").asList().stream()
                    .map(input -> Input.valueOf(input.getAsString()))
                    .toArray(Input[]::new));
            case "set_options" -> fitter.setOptions(options(new FitOptions(), step));
            case "get_options" -> describeOptions(fitter.options(), outputs);
            case "detector_set_options" -> detector.setOptions(options(new DetectorOptions(), step));
            case "detector_get_options" -> describeOptions(detector.options(), outputs);
            case "detector_set_fit_options" -> detector.setFitOptions(options(new FitOptions(), step));
            case "detector_get_fit_options" -> describeOptions(detector.fitOptions(), outputs);
            case "detector_cancel" -> detector.cancel();
            case "new_detector" -> {
                detector.close();
                detector = new Detector();
            }
            case "detect" -> detector.detect(frame);
            case "detect_points" -> detector.detectPoints(cloud(step.getAsJsonObject("points")));
            case "detector_count" -> outputs.put("count", new double[] {detector.detections().size()});
            case "detector_detections" -> describeDetections(detector.detections(), outputs);
            case "detector_get_result" -> describeResult(detected(step).result(), false, outputs);
            case "detector_get_cylinder" -> describeResult(detected(step).result(), true, outputs);
            case "detector_get_extent" -> {
                Extent extent = detected(step).extent();
                // The fitter says why there is none.
                describe(extent != null ? extent : detector.makeFitter(step.get("index").getAsInt()).extent(), "", outputs);
            }
            case "detector_labels" -> outputs.put("labels", Arrays.stream(detector.labels().numbers()).asDoubleStream().toArray());
            case "detector_indices" -> outputs.put(
                    "indices", Arrays.stream(detector.indices(step.get("index").getAsInt())).asDoubleStream().toArray());
            case "detector_make_fitter" -> {
                Fitter made = detector.makeFitter(step.get("index").getAsInt());
                fitter.close();
                fitter = made;
            }
            case "set_intrinsics" -> fitter.setIntrinsics(camera(step));
            case "set_start_model" -> fitter.setStartModel(model);
            case "reserve" -> fitter.reserve(step.get("points").getAsLong(), step.get("segments").getAsLong());
            case "clear" -> fitter.clear();
            case "cancel" -> fitter.cancel();
            case "push_points" -> fitter.pushPoints(cloud(step.getAsJsonObject("points")), mask(step));
            case "push_depth" -> fitter.pushDepth(depth(step), mask(step));
            case "push_image" -> fitter.pushImage(image(step));
            case "push_edges" -> fitter.pushEdges(segments(step));
            case "select_edges" -> {
                double reach = step.has("reach") ? number(step.get("reach")) : 0;
                byte[] limbs = fitter.selectEdges(segments(step), model, reach);
                outputs.put("selected", IntStream.range(0, limbs.length).mapToDouble(k -> limbs[k]).toArray());
            }
            case "counts" -> describe(fitter.counts(), "", outputs);
            case "fit" -> describe(fitter.fit(), "", outputs);
            case "get_result" -> describeResult(fitter.result(), false, outputs);
            case "get_cylinder" -> describeResult(fitter.result(), true, outputs);
            case "evaluate" -> describe(fitter.evaluate(model), "", outputs);
            case "residuals" ->
                outputs.put("residuals", fitter.residuals(ResidualKind.valueOf(text(step, "kind")), model));
            case "point_weights" -> describe(fitter.pointWeights(), "", outputs);
            case "point_parts" ->
                outputs.put("parts", Arrays.stream(fitter.pointParts(model)).mapToDouble(Part::value).toArray());
            case "limbs" -> describeAll(LimbLine.class, fitter.limbs(), outputs);
            case "limb_samples" -> describeAll(LimbSample.class, fitter.limbSamples(), outputs);
            case "end_samples" -> describeAll(EndSample.class, fitter.endSamples(model, mask(step)), outputs);
            case "diagnose" -> describe(fitter.diagnose(model), "", outputs);
            case "extent" -> describe(fitter.extent(model, mask(step)), "", outputs);
            case "complete" -> complete(step, model, outputs);
            case "complete_depth" -> completeDepth(step, model, outputs);
            case "distances" -> outputs.put("distances", model.distances(cloud(step.getAsJsonObject("points"))));
            case "project" -> outputs.put("lines", flatten(model.project(camera(step))));
            case "intrinsics_project" ->
                outputs.put("pixels", camera(step).project(cloud(step.getAsJsonObject("points"))));
            case "intrinsics_unproject" -> {
                List<double[]> rows = new ArrayList<>();
                step.getAsJsonArray("pixels").forEach(row -> rows.add(numbers(row)));
                outputs.put("rays", camera(step).unproject(flatten(rows.toArray(new double[0][]))));
            }
            case "compare" -> describe(cylinder(step.get("a")).compare(cylinder(step.get("b"))), "", outputs);
            default -> throw new AssertionError("unknown call " + step.get("call"));
        }
        return outputs;
    }

    private void complete(JsonObject step, Cylinder model, Map<String, double[]> outputs) throws ReflectiveOperationException {
        Layout layout = Layout.valueOf(text(step, "layout"));
        if (text(step, "scalar").equals("F64")) {
            CompletedCloud cloud = fitter.complete(layout, model, mask(step));
            describe(cloud.pixels(), "", outputs);
            outputs.put("points", cloud.coordinates());
        } else {
            CompletedCloudSingle cloud = fitter.completeSingle(layout, model, mask(step));
            describe(cloud.pixels(), "", outputs);
            outputs.put("points", widen(cloud.coordinates()));
        }
    }

    private void completeDepth(JsonObject step, Cylinder model, Map<String, double[]> outputs) throws ReflectiveOperationException {
        double scale = number(step.get("scale"));
        if (text(step, "format").equals("F32")) {
            CompletedDepth image = fitter.completeDepth(scale, model, mask(step));
            describe(image.pixels(), "", outputs);
            outputs.put("depth", widen(image.depth()));
        } else {
            CompletedDepthInteger image = fitter.completeDepthInteger(scale, model, mask(step));
            describe(image.pixels(), "", outputs);
            double[] depth = new double[image.depth().length];
            for (int k = 0; k < depth.length; k++) {
                depth[k] = Short.toUnsignedInt(image.depth()[k]);
            }
            outputs.put("depth", depth);
        }
    }

    // What goes in.

    static String text(JsonObject object, String key) {
        return object.get(key).getAsString();
    }

    /** A number; null stands for NaN. */
    private static double number(JsonElement value) {
        return value.isJsonNull() ? Double.NaN : value.getAsDouble();
    }

    private static double[] numbers(JsonElement list) {
        JsonArray array = list.getAsJsonArray();
        double[] numbers = new double[array.size()];
        for (int k = 0; k < numbers.length; k++) {
            numbers[k] = number(array.get(k));
        }
        return numbers;
    }

    private static Cylinder cylinder(JsonElement value) {
        if (value == null || value.isJsonNull()) {
            return null;
        }
        JsonObject object = value.getAsJsonObject();
        return new Cylinder(
                Vector.of(numbers(object.get("point"))),
                Vector.of(numbers(object.get("direction"))),
                number(object.get("radius")));
    }

    private static RigidMotion pose(JsonObject step) {
        if (!step.has("pose")) {
            return RigidMotion.IDENTITY;
        }
        JsonObject pose = step.getAsJsonObject("pose");
        double[] numbers = numbers(pose.get("rotation"));
        double[][] rows = IntStream.range(0, 3).mapToObj(k -> Arrays.copyOfRange(numbers, 3 * k, 3 * k + 3)).toArray(double[][]::new);
        return new RigidMotion(rows, Vector.of(numbers(pose.get("translation"))));
    }

    private Intrinsics camera(JsonObject step) {
        if (step.get("camera").isJsonNull()) {
            return null;
        }
        JsonObject camera = file.getAsJsonObject("cameras").getAsJsonObject(text(step, "camera"));
        return new Intrinsics(
                camera.get("width").getAsInt(),
                camera.get("height").getAsInt(),
                number(camera.get("fx")),
                number(camera.get("fy")),
                number(camera.get("cx")),
                number(camera.get("cy")),
                DistortionModel.valueOf(text(camera, "distortion_model")),
                numbers(camera.get("distortion")));
    }

    /** Options with those of a step in them. */
    private static <T> T options(T options, JsonObject step) throws ReflectiveOperationException {
        JsonObject given = step.getAsJsonObject("options");
        for (String key : given.keySet()) {
            String name = camel(key);
            Class<?> type = options.getClass().getMethod(name).getReturnType();
            JsonElement value = given.get(key);
            Object argument;
            if (type == Vector.class) {
                argument = Vector.of(numbers(value));
            } else if (type == int.class) {
                argument = value.getAsInt();
            } else if (type == long.class) {
                argument = value.getAsLong();
            } else if (type == double.class) {
                argument = number(value);
            } else {
                argument = type.getMethod("valueOf", String.class).invoke(null, value.getAsString());
            }
            options.getClass().getMethod(name, type).invoke(options, argument);
        }
        return options;
    }

    /** An array of the file and its sizes, the slowest first. */
    private record Data(Buffer elements, int[] shape) {
        int width() {
            return shape.length == 3 ? shape[1] : shape[0];
        }

        int height() {
            return shape.length == 3 ? shape[0] : 1;
        }

        int channels() {
            return shape[shape.length - 1];
        }
    }

    private Data data(String name) {
        JsonObject array = file.getAsJsonObject("arrays").getAsJsonObject(name);
        ByteBuffer bytes = ByteBuffer.wrap(Base64.getDecoder().decode(text(array, "data"))).order(ByteOrder.LITTLE_ENDIAN);
        Buffer elements = switch (text(array, "type")) {
            case "u8" -> bytes;
            case "u16" -> bytes.asShortBuffer();
            case "f32" -> bytes.asFloatBuffer();
            case "f64" -> bytes.asDoubleBuffer();
            default -> throw new AssertionError("unknown type " + array.get("type"));
        };
        double[] shape = numbers(array.get("shape"));
        return new Data(elements, Arrays.stream(shape).mapToInt(size -> (int) size).toArray());
    }

    private static int column(JsonObject part) {
        return part.has("column") ? part.get("column").getAsInt() : 0;
    }

    private PointCloud cloud(JsonObject points) {
        Data data = data(text(points, "array"));
        int row = data.width() * data.channels();
        PointCloud cloud = data.elements() instanceof DoubleBuffer doubles
                ? PointCloud.of(doubles, data.width(), data.height(), column(points), data.channels(), row)
                : PointCloud.of((FloatBuffer) data.elements(), data.width(), data.height(), column(points), data.channels(), row);
        if (points.has("weights")) {
            JsonObject part = points.getAsJsonObject("weights");
            Data weights = data(text(part, "array"));
            cloud = cloud.withWeights(weights.elements(), column(part), weights.channels(), weights.width() * weights.channels());
        }
        if (points.has("normals")) {
            JsonObject part = points.getAsJsonObject("normals");
            Data normals = data(text(part, "array"));
            cloud = cloud.withNormals(normals.elements(), column(part), normals.channels(), normals.width() * normals.channels());
        }
        return cloud;
    }

    private Mask mask(JsonObject step) {
        if (!step.has("mask")) {
            return null;
        }
        Data data = data(text(step, "mask"));
        Mask mask = Mask.of((ByteBuffer) data.elements(), data.shape()[1], data.shape()[0], 0, 0, 0);
        return step.has("label") ? mask.withLabel(step.get("label").getAsInt()) : mask;
    }

    private DepthImage depth(JsonObject step) {
        Data data = data(text(step, "depth"));
        int width = data.shape()[1];
        int height = data.shape()[0];
        double scale = number(step.get("scale"));
        DepthImage depth = data.elements() instanceof ShortBuffer integers
                ? DepthImage.of(integers, width, height, scale, 0, 0, 0)
                : DepthImage.of((FloatBuffer) data.elements(), width, height, scale, 0, 0, 0);
        return depth.withRange(
                step.has("min_depth") ? number(step.get("min_depth")) : 0,
                step.has("max_depth") ? number(step.get("max_depth")) : 0);
    }

    private Image image(JsonObject step) {
        Image image = plainImage(step);
        return step.has("gamma") ? image.withGamma(number(step.get("gamma"))) : image;
    }

    private Image plainImage(JsonObject step) {
        Data data = data(text(step, "image"));
        int width = data.shape()[1];
        int height = data.shape()[0];
        if (data.shape().length == 3) {
            ColourFormat format = step.has("format")
                    ? ColourFormat.valueOf(text(step, "format"))
                    : data.channels() == 3 ? ColourFormat.RGB8 : ColourFormat.RGBA8;
            return Image.of((ByteBuffer) data.elements(), width, height, format, 0, 0, 0);
        }
        if (data.elements() instanceof ByteBuffer bytes) {
            return Image.of(bytes, width, height, 0, 0, 0);
        }
        return data.elements() instanceof ShortBuffer integers
                ? Image.of(integers, width, height, 0, 0, 0)
                : Image.of((FloatBuffer) data.elements(), width, height, 0, 0, 0);
    }

    private static Segments segments(JsonObject step) {
        List<double[]> rows = new ArrayList<>();
        step.getAsJsonArray("segments").forEach(row -> rows.add(numbers(row)));
        Segments segments = Segments.of(rows.toArray(new double[0][]));
        return step.has("weights") ? segments.withWeights(numbers(step.get("weights"))) : segments;
    }

    // What comes out.

    private static void describe(Record values, String prefix, Map<String, double[]> outputs) throws ReflectiveOperationException {
        for (RecordComponent component : values.getClass().getRecordComponents()) {
            String name = prefix + snake(component.getName());
            // Times are no result.
            if (!name.startsWith("seconds_")) {
                describe(component.getAccessor().invoke(values), name, outputs);
            }
        }
    }

    private Detection detected(JsonObject step) {
        // The list knows no such error as the library.
        detector.indices(step.get("index").getAsInt());
        return detector.detections().get(step.get("index").getAsInt());
    }

    /** What a search has found. */
    private static void describeDetections(List<Detection> found, Map<String, double[]> outputs) {
        outputs.put("score", found.stream().mapToDouble(Detection::score).toArray());
        outputs.put("pixels", found.stream().mapToDouble(Detection::pixels).toArray());
        List<Cylinder> models = found.stream().map(one -> one.result().model()).toList();
        outputs.put("model.point", models.stream().flatMapToDouble(m -> Arrays.stream(m.point().toArray())).toArray());
        outputs.put("model.direction", models.stream().flatMapToDouble(m -> Arrays.stream(m.direction().toArray())).toArray());
        outputs.put("model.radius", models.stream().mapToDouble(Cylinder::radius).toArray());
    }

    /** One of the two parts of a result, which come from two functions of C. */
    private static void describeResult(FitResult result, boolean ofCylinder, Map<String, double[]> outputs)
            throws ReflectiveOperationException {
        Map<String, double[]> all = new LinkedHashMap<>();
        describe(result, "", all);
        Set<String> cylinder = Arrays.stream(NativeStructs.CylinderEstimate.class.getFields())
                .map(Field::getName)
                .collect(Collectors.toSet());
        all.forEach((name, numbers) -> {
            if (cylinder.contains(name.split("\\.")[0]) == ofCylinder) {
                outputs.put(name, numbers);
            }
        });
    }

    /** A list for each component, over all elements. */
    private static <T extends Record> void describeAll(Class<T> type, List<T> elements, Map<String, double[]> outputs)
            throws ReflectiveOperationException {
        for (RecordComponent component : type.getRecordComponents()) {
            List<double[]> parts = new ArrayList<>();
            for (T element : elements) {
                Map<String, double[]> one = new LinkedHashMap<>();
                describe(component.getAccessor().invoke(element), "", one);
                parts.add(one.get(""));
            }
            outputs.put(snake(component.getName()), flatten(parts.toArray(new double[0][])));
        }
    }

    private static void describeOptions(Object options, Map<String, double[]> outputs) throws ReflectiveOperationException {
        for (java.lang.reflect.Method getter : options.getClass().getMethods()) {
            if (getter.getDeclaringClass() == options.getClass() && getter.getParameterCount() == 0) {
                describe(getter.invoke(options), snake(getter.getName()), outputs);
            }
        }
    }

    private static void describe(Object value, String name, Map<String, double[]> outputs) throws ReflectiveOperationException {
        if (value instanceof Vector vector) {
            outputs.put(name, vector.toArray());
        } else if (value instanceof Cylinder cylinder) {
            describe(cylinder, name + ".", outputs);
        } else if (value instanceof double[] list) {
            outputs.put(name, list);
        } else if (value instanceof double[][] rows) {
            outputs.put(name, flatten(rows));
        } else if (value instanceof boolean[] list) {
            outputs.put(name, IntStream.range(0, list.length).mapToDouble(k -> list[k] ? 1 : 0).toArray());
        } else if (value instanceof Boolean truth) {
            outputs.put(name, new double[] {truth ? 1 : 0});
        } else if (value instanceof Set<?> flags) {
            outputs.put(name, new double[] {flags.stream().mapToInt(flag -> ((ResultFlag) flag).value()).sum()});
        } else if (value instanceof Enum<?>) {
            outputs.put(name, new double[] {(int) value.getClass().getMethod("value").invoke(value)});
        } else {
            outputs.put(name, new double[] {((Number) value).doubleValue()});
        }
    }

    private static double[] flatten(double[][] rows) {
        return Arrays.stream(rows).flatMapToDouble(Arrays::stream).toArray();
    }

    private static double[] widen(float[] numbers) {
        double[] wide = new double[numbers.length];
        for (int k = 0; k < wide.length; k++) {
            wide[k] = numbers[k];
        }
        return wide;
    }

    private static String camel(String name) {
        String[] words = name.split("_");
        StringBuilder camel = new StringBuilder(words[0]);
        for (int k = 1; k < words.length; k++) {
            camel.append(Character.toUpperCase(words[k].charAt(0))).append(words[k].substring(1));
        }
        return camel.toString();
    }

    private static String snake(String name) {
        return name.replaceAll("([A-Z])", "_$1").toLowerCase(Locale.ROOT);
    }
}

using System;
using System.Collections;
using System.Collections.Generic;
using System.Json;
using System.Linq;
using System.Reflection;

namespace Cylfuse.Conformance
{
    /// <summary>Runs one golden case of bindings/conformance/cases.json, step by step.</summary>
    internal sealed class Runner : IDisposable
    {
        private readonly JsonValue file;
        private Fitter fitter = new Fitter();
        private Frame frame = new Frame();
        private Detector detector = new Detector();

        internal Runner(JsonValue file)
        {
            this.file = file;
        }

        public void Dispose()
        {
            fitter.Dispose();
            frame.Dispose();
            detector.Dispose();
        }

        /// <summary>What a step gives: numbers under the names of the C fields.</summary>
        internal Dictionary<string, double[]> Run(JsonValue step)
        {
            var outputs = new Dictionary<string, double[]>();
            Cylinder model = Cylinder(step, "model");
            string call = step["call"];
            switch (call)
            {
                case "new_fitter":
                    fitter.Dispose();
                    fitter = new Fitter();
                    break;
                case "new_frame":
                    frame.Dispose();
                    frame = new Frame();
                    break;
                case "select_view": fitter.SelectView(step["index"]); break;
                case "view_count": outputs["count"] = new[] { (double)fitter.ViewCount }; break;
                case "set_pose": fitter.SetPose(Pose(step["pose"])); break;
                case "frame_set_pose": frame.SetPose(Pose(step["pose"])); break;
                case "frame_set_intrinsics": frame.Intrinsics = Camera(step["camera"]); break;
                case "set_depth_camera":
                    fitter.SetDepthCamera(Camera(step["camera"]), Pose(Given(step, "pose")));
                    break;
                case "frame_set_depth_camera":
                    frame.SetDepthCamera(Camera(step["camera"]), Pose(Given(step, "pose")));
                    break;
                case "frame_set_depth": frame.SetDepth(Depth(step)); break;
                case "frame_set_image": frame.SetImage(Image(step)); break;
                case "use_frame": fitter.UseFrame(frame, Mask(step)); break;
                case "clear_input":
                    fitter.ClearInput(((JsonArray)step["inputs"])
                        .Aggregate(Inputs.None, (inputs, input) => inputs | Named<Inputs>(input)));
                    break;
                case "set_options": fitter.Options = Options<FitOptions>(step["options"]); break;
                case "get_options": Describe(fitter.Options, "", outputs); break;
                case "detector_set_options": detector.Options = Options<DetectorOptions>(step["options"]); break;
                case "detector_get_options": Describe(detector.Options, "", outputs); break;
                case "detector_set_fit_options": detector.FitOptions = Options<FitOptions>(step["options"]); break;
                case "detector_get_fit_options": Describe(detector.FitOptions, "", outputs); break;
                case "detector_cancel": detector.Cancel(); break;
                case "new_detector":
                    detector.Dispose();
                    detector = new Detector();
                    break;
                case "detect": detector.Detect(frame); break;
                case "detect_points": detector.DetectPoints(Cloud(step["points"])); break;
                case "detector_count": outputs["count"] = new[] { (double)detector.Detections().Length }; break;
                case "detector_detections": DescribeDetections(detector.Detections(), outputs); break;
                case "detector_get_result": DescribeResult(Detected(step).Result, false, outputs); break;
                case "detector_get_cylinder": DescribeResult(Detected(step).Result, true, outputs); break;
                case "detector_get_extent":
                    // The fitter says why there is none.
                    Describe(Detected(step).Extent ?? detector.MakeFitter(step["index"]).Extent(), "", outputs);
                    break;
                case "detector_labels": outputs["labels"] = Flatten(detector.Labels()); break;
                case "detector_indices": outputs["indices"] = Flatten(detector.Indices(step["index"])); break;
                case "detector_make_fitter":
                    Fitter made = detector.MakeFitter(step["index"]);
                    fitter.Dispose();
                    fitter = made;
                    break;
                case "set_intrinsics": fitter.Intrinsics = Camera(step["camera"]); break;
                case "set_start_model": fitter.SetStartModel(model); break;
                case "reserve": fitter.Reserve(step["points"], step["segments"]); break;
                case "clear": fitter.Clear(); break;
                case "cancel": fitter.Cancel(); break;
                case "push_points": fitter.PushPoints(Cloud(step["points"]), Mask(step)); break;
                case "push_depth": fitter.PushDepth(Depth(step), Mask(step)); break;
                case "push_image": fitter.PushImage(Image(step)); break;
                case "push_edges": fitter.PushEdges(Edges(step)); break;
                case "select_edges":
                    byte[] limbs = fitter.SelectEdges(Edges(step), model, Number(step, "reach", 0));
                    outputs["selected"] = limbs.Select(limb => (double)limb).ToArray();
                    break;
                case "counts": Describe(fitter.Counts(), "", outputs); break;
                case "fit": Describe(fitter.Fit(), "", outputs); break;
                case "get_result": DescribeResult(fitter.Result(), false, outputs); break;
                case "get_cylinder": DescribeResult(fitter.Result(), true, outputs); break;
                case "evaluate": Describe(fitter.Evaluate(model), "", outputs); break;
                case "residuals":
                    outputs["residuals"] = fitter.Residuals(Named<ResidualKind>(step["kind"]), model);
                    break;
                case "point_weights": Describe(fitter.PointWeights(), "", outputs); break;
                case "point_parts":
                    outputs["parts"] = fitter.PointParts(model).Select(part => (double)part).ToArray();
                    break;
                case "limbs": DescribeAll(fitter.Limbs(), outputs); break;
                case "limb_samples": DescribeAll(fitter.LimbSamples(), outputs); break;
                case "end_samples": DescribeAll(fitter.EndSamples(model, Mask(step)), outputs); break;
                case "diagnose": Describe(fitter.Diagnose(model), "", outputs); break;
                case "extent": Describe(fitter.Extent(model, Mask(step)), "", outputs); break;
                case "complete": Complete(step, model, outputs); break;
                case "complete_depth": CompleteDepth(step, model, outputs); break;
                case "distances": outputs["distances"] = model.Distances(Cloud(step["points"])); break;
                case "project": outputs["lines"] = Flatten(model.Project(Camera(step["camera"]))); break;
                case "intrinsics_project":
                    outputs["pixels"] = Flatten(Camera(step["camera"]).Project(Cloud(step["points"])));
                    break;
                case "intrinsics_unproject": outputs["rays"] = Flatten(Unproject(step)); break;
                case "compare": Describe(Cylinder(step, "a").Compare(Cylinder(step, "b")), "", outputs); break;
                default: throw new NotSupportedException($"unknown call {call}");
            }
            return outputs;
        }

        private double[,] Unproject(JsonValue step)
        {
            double[] numbers = ((JsonArray)step["pixels"]).SelectMany(Numbers).ToArray();
            var pixels = new double[numbers.Length / 2, 2];
            Buffer.BlockCopy(numbers, 0, pixels, 0, 8 * numbers.Length);
            return Camera(step["camera"]).Unproject(pixels);
        }

        private void Complete(JsonValue step, Cylinder model, Dictionary<string, double[]> outputs)
        {
            var layout = Named<Layout>(step["layout"]);
            if (step["scalar"] == "F64")
            {
                CompletedCloud<double> cloud = fitter.Complete(layout, model, Mask(step));
                Describe(cloud.Pixels, "", outputs);
                outputs["points"] = cloud.Coordinates;
            }
            else
            {
                CompletedCloud<float> cloud = fitter.CompleteSingle(layout, model, Mask(step));
                Describe(cloud.Pixels, "", outputs);
                outputs["points"] = Flatten(cloud.Coordinates);
            }
        }

        private void CompleteDepth(JsonValue step, Cylinder model, Dictionary<string, double[]> outputs)
        {
            double scale = Number(step["scale"]);
            if (step["format"] == "F32")
            {
                CompletedDepth<float> image = fitter.CompleteDepth(scale, model, Mask(step));
                Describe(image.Pixels, "", outputs);
                outputs["depth"] = Flatten(image.Depth);
            }
            else
            {
                CompletedDepth<ushort> image = fitter.CompleteDepthUInt16(scale, model, Mask(step));
                Describe(image.Pixels, "", outputs);
                outputs["depth"] = Flatten(image.Depth);
            }
        }

        // What goes in.

        /// <summary>A number; null stands for NaN.</summary>
        private static double Number(JsonValue value) => value == null ? double.NaN : (double)value;

        private static JsonValue Given(JsonValue step, string key) => step.ContainsKey(key) ? step[key] : null;

        private static RigidMotion Pose(JsonValue value)
        {
            if (value == null) return null;
            var rotation = new double[3, 3];
            Buffer.BlockCopy(Numbers(value["rotation"]), 0, rotation, 0, 72);
            return new RigidMotion(rotation, Vector(value["translation"]));
        }

        private static double Number(JsonValue step, string key, double otherwise) =>
            step.ContainsKey(key) ? Number(step[key]) : otherwise;

        private static double[] Numbers(JsonValue list) => ((JsonArray)list).Select(Number).ToArray();

        private static Vector Vector(JsonValue list)
        {
            double[] numbers = Numbers(list);
            return new Vector(numbers[0], numbers[1], numbers[2]);
        }

        private static T Named<T>(string name) => (T)Named(typeof(T), name);

        private static object Named(Type type, string name) => Enum.Parse(type, name.Replace("_", ""), true);

        private static Cylinder Cylinder(JsonValue step, string key)
        {
            JsonValue value = step.ContainsKey(key) ? step[key] : null;
            return value == null ? null
                : new Cylinder(Vector(value["point"]), Vector(value["direction"]), Number(value["radius"]));
        }

        private Intrinsics Camera(JsonValue name)
        {
            if (name == null) return null;
            JsonValue camera = file["cameras"][(string)name];
            return new Intrinsics(
                camera["width"], camera["height"], Number(camera["fx"]), Number(camera["fy"]), Number(camera["cx"]),
                Number(camera["cy"]),
                Named<DistortionModel>(camera["distortion_model"]), Numbers(camera["distortion"]));
        }

        private static T Options<T>(JsonValue given) where T : class, new()
        {
            var options = new T();
            foreach (KeyValuePair<string, JsonValue> setting in given)
            {
                PropertyInfo property = typeof(T).GetProperty(Names.OfCSharp(setting.Key));
                Type type = property.PropertyType;
                property.SetValue(options, type == typeof(Vector) ? Vector(setting.Value)
                    : type.IsEnum ? Named(type, setting.Value)
                    : Convert.ChangeType(Number(setting.Value), type));
            }
            return options;
        }

        /// <summary>An array of the file and its sizes, the slowest first.</summary>
        private (Array elements, int[] shape) Data(string name)
        {
            JsonValue array = file["arrays"][name];
            byte[] bytes = Convert.FromBase64String(array["data"]);
            int[] shape = Numbers(array["shape"]).Select(size => (int)size).ToArray();
            int count = shape.Aggregate(1, (product, size) => product * size);
            string type = array["type"];
            Array elements = type == "u8" ? new byte[count] : type == "u16" ? new ushort[count]
                : type == "f32" ? (Array)new float[count] : new double[count];
            Buffer.BlockCopy(bytes, 0, elements, 0, bytes.Length);
            return (elements, shape);
        }

        private static int Column(JsonValue part) => part.ContainsKey("column") ? (int)part["column"] : 0;

        private PointCloud Cloud(JsonValue points)
        {
            (Array elements, int[] shape) = Data(points["array"]);
            int channels = shape.Last(), width = shape[shape.Length - 2], height = shape.Length == 3 ? shape[0] : 1;
            PointCloud cloud = elements is double[] doubles
                ? PointCloud.From(doubles, width, height, Column(points), channels, width * channels)
                : PointCloud.From((float[])elements, width, height, Column(points), channels, width * channels);
            if (points.ContainsKey("weights"))
            {
                JsonValue part = points["weights"];
                (Array weights, int[] size) = Data(part["array"]);
                cloud = weights is double[] wide
                    ? cloud.WithWeights(wide, Column(part), size.Last(), width * size.Last())
                    : cloud.WithWeights((float[])weights, Column(part), size.Last(), width * size.Last());
            }
            if (points.ContainsKey("normals"))
            {
                JsonValue part = points["normals"];
                (Array normals, int[] size) = Data(part["array"]);
                cloud = normals is double[] wide
                    ? cloud.WithNormals(wide, Column(part), size.Last(), width * size.Last())
                    : cloud.WithNormals((float[])normals, Column(part), size.Last(), width * size.Last());
            }
            return cloud;
        }

        private Mask Mask(JsonValue step)
        {
            if (!step.ContainsKey("mask")) return null;
            (Array elements, int[] shape) = Data(step["mask"]);
            Mask mask = Cylfuse.Mask.From((byte[])elements, shape[1], shape[0]);
            mask.Label = (byte)Number(step, "label", 0);
            return mask;
        }

        private DepthImage Depth(JsonValue step)
        {
            (Array elements, int[] shape) = Data(step["depth"]);
            double scale = Number(step["scale"]);
            DepthImage depth = elements is ushort[] integers
                ? DepthImage.From(integers, shape[1], shape[0], scale)
                : DepthImage.From((float[])elements, shape[1], shape[0], scale);
            depth.MinDepth = Number(step, "min_depth", 0);
            depth.MaxDepth = Number(step, "max_depth", 0);
            return depth;
        }

        private Image Image(JsonValue step)
        {
            (Array elements, int[] shape) = Data(step["image"]);
            int width = shape[1], height = shape[0];
            Image image = shape.Length == 3
                ? Cylfuse.Image.From((byte[])elements, width, height, step.ContainsKey("format")
                    ? Named<ColourFormat>(step["format"])
                    : shape[2] == 3 ? ColourFormat.Rgb8 : ColourFormat.Rgba8)
                : elements is byte[] bytes ? Cylfuse.Image.From(bytes, width, height)
                : elements is ushort[] integers ? Cylfuse.Image.From(integers, width, height)
                : Cylfuse.Image.From((float[])elements, width, height);
            image.Gamma = Number(step, "gamma", 1);
            return image;
        }

        private static Segments Edges(JsonValue step)
        {
            double[] numbers = ((JsonArray)step["segments"]).SelectMany(Numbers).ToArray();
            Segments segments = Segments.From(numbers, numbers.Length / 4);
            return step.ContainsKey("weights") ? segments.WithWeights(Numbers(step["weights"])) : segments;
        }

        // What comes out.

        private Detection Detected(JsonValue step)
        {
            // The list knows no such error as the library.
            detector.Indices(step["index"]);
            return detector.Detections()[(int)step["index"]];
        }

        /// <summary>What a search has found.</summary>
        private static void DescribeDetections(Detection[] found, Dictionary<string, double[]> outputs)
        {
            outputs["score"] = found.Select(one => one.Score).ToArray();
            outputs["pixels"] = found.Select(one => (double)one.Pixels).ToArray();
            outputs["model.point"] = found.SelectMany(one => Numbers(one.Result.Model.Point)).ToArray();
            outputs["model.direction"] = found.SelectMany(one => Numbers(one.Result.Model.Direction)).ToArray();
            outputs["model.radius"] = found.Select(one => one.Result.Model.Radius).ToArray();
        }

        private static double[] Numbers(Vector vector) => new[] { vector.X, vector.Y, vector.Z };

        /// <summary>One of the two parts of a result, which come from two functions of C.</summary>
        private static void DescribeResult(FitResult result, bool ofCylinder, Dictionary<string, double[]> outputs)
        {
            var all = new Dictionary<string, double[]>();
            Describe(result, "", all);
            var cylinder = new HashSet<string>(typeof(Fitter).Assembly.GetType("Cylfuse.NativeCylinderEstimate")
                .GetFields(BindingFlags.NonPublic | BindingFlags.Instance).Select(field => field.Name));
            foreach (KeyValuePair<string, double[]> output in all)
                if (cylinder.Contains(output.Key.Split('.')[0]) == ofCylinder) outputs.Add(output.Key, output.Value);
        }

        /// <summary>A list for each property, over all elements.</summary>
        private static void DescribeAll<T>(T[] elements, Dictionary<string, double[]> outputs)
        {
            foreach (PropertyInfo property in typeof(T).GetProperties())
                outputs[Names.OfC(property.Name)] = elements.SelectMany(element =>
                    property.GetValue(element) is Array array ? Flatten(array)
                        : new[] { Convert.ToDouble(property.GetValue(element)) }).ToArray();
        }

        private static void Describe(object values, string prefix, Dictionary<string, double[]> outputs)
        {
            foreach (PropertyInfo property in values.GetType().GetProperties())
            {
                string name = prefix + Names.OfC(property.Name);
                // Times are no result.
                if (name.StartsWith("seconds_")) continue;
                object value = property.GetValue(values);
                if (value is Vector vector) outputs[name] = new[] { vector.X, vector.Y, vector.Z };
                else if (value is Cylinder) Describe(value, name + ".", outputs);
                else if (value is Array array) outputs[name] = Flatten(array);
                else outputs[name] = new[] { Convert.ToDouble(value) };
            }
        }

        private static double[] Flatten(IEnumerable numbers) =>
            numbers.Cast<object>().Select(Convert.ToDouble).ToArray();
    }
}

//! The golden cases: what is called, in which order. What comes out is added by running them.

#![allow(clippy::needless_pass_by_value, reason = "what is passed is written on the spot")]

use super::scene::{self, RADIUS, edges, truth};
use serde_json::{Value, json};

fn case(name: &str, about: &str, steps: Vec<Value>) -> Value {
    json!({"name": name, "about": about, "steps": steps})
}

fn call(name: &str) -> Value {
    json!({"call": name})
}

fn camera(name: &str) -> Value {
    json!({"call": "set_intrinsics", "camera": name})
}

fn options(options: Value) -> Value {
    json!({"call": "set_options", "options": options})
}

fn points(array: &str) -> Value {
    json!({"call": "push_points", "points": {"array": array}})
}

fn depth() -> Value {
    json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "mask"})
}

fn push_edges() -> Value {
    json!({"call": "push_edges", "segments": edges()})
}

fn image(array: &str) -> Value {
    json!({"call": "push_image", "image": array})
}

fn residuals(kind: &str) -> Value {
    json!({"call": "residuals", "kind": kind})
}

fn points_of_every_kind() -> Vec<Value> {
    let records = json!({"call": "push_points", "points": {
        "array": "records_f32", "column": 0,
        "weights": {"array": "records_f32", "column": 3}, "normals": {"array": "records_f32", "column": 4},
    }});
    let organised =
        json!({"call": "push_points", "points": {"array": "organised_f32"}, "mask": "organised_mask"});
    let weighted = json!({"call": "push_points", "points": {
        "array": "cloud_f64", "weights": {"array": "weights_f64"},
    }});
    vec![
        case(
            "points_f64",
            "a packed cloud and all that can be asked afterwards",
            vec![
                call("get_options"),
                points("cloud_f64"),
                call("counts"),
                call("fit"),
                call("get_result"),
                residuals("POINTS"),
                call("diagnose"),
                json!({"call": "diagnose", "model": truth()}),
                json!({"call": "residuals", "kind": "POINTS", "model": truth()}),
                json!({"call": "evaluate", "model": truth()}),
                call("limb_samples"),
            ],
        ),
        case("points_f32", "a packed float cloud", vec![points("cloud_f32"), call("fit")]),
        case(
            "points_strided",
            "points, weights and normals inside records; RANSAC uses the normals",
            vec![records.clone(), call("fit"), options(json!({"method": "RANSAC", "seed": 5})), call("fit")],
        ),
        case(
            "points_organised",
            "rows and columns with NaN and a mask",
            vec![organised, call("counts"), call("fit"), residuals("POINTS")],
        ),
        case("points_weighted", "weights of which some are 0", vec![weighted, call("counts"), call("fit")]),
        case(
            "points_twice",
            "two clouds one after the other, then the next frame on the same fitter",
            vec![
                json!({"call": "reserve", "points": 200, "segments": 4}),
                points("cloud_f64"),
                points("cloud_f32"),
                call("counts"),
                call("fit"),
                call("clear"),
                call("counts"),
                call("get_result"),
                points("cloud_f64"),
                call("fit"),
            ],
        ),
    ]
}

fn frames() -> Vec<Value> {
    let mut cases = vec![
        case(
            "depth_u16_edges",
            "a depth image with mask and two edges, and all that follows a fit",
            vec![
                camera("pinhole"),
                depth(),
                push_edges(),
                call("counts"),
                call("fit"),
                residuals("EDGES"),
                call("diagnose"),
                call("extent"),
                json!({"call": "extent", "model": truth()}),
                json!({"call": "extent", "mask": "mask"}),
            ],
        ),
        case(
            "depth_f32",
            "float depth with a range, without edges",
            vec![
                camera("pinhole"),
                json!({"call": "push_depth", "depth": "depth_f32", "scale": 1.0, "mask": "mask",
                "min_depth": 0.2, "max_depth": 0.6}),
                call("counts"),
                call("fit"),
                call("extent"),
            ],
        ),
        case(
            "depth_without_mask",
            "every measured pixel in range counts",
            vec![
                camera("pinhole"),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "max_depth": 0.6}),
                push_edges(),
                call("fit"),
                call("extent"),
                json!({"call": "extent", "mask": "mask"}),
            ],
        ),
        case(
            "one_edge",
            "one of the limbs only",
            vec![
                camera("pinhole"),
                depth(),
                json!({"call": "push_edges", "segments": [edges()[0]]}),
                call("fit"),
                call("extent"),
            ],
        ),
        case(
            "edges_weighted",
            "a list of segments in parts and with weights",
            vec![
                camera("pinhole"),
                depth(),
                json!({"call": "push_edges", "segments": edges(), "weights": [1.0, 2.0]}),
                json!({"call": "push_edges", "segments": [edges()[0]], "weights": [0.0]}),
                call("fit"),
                residuals("EDGES"),
            ],
        ),
        case(
            "no_edges_pushed",
            "an empty list of segments changes nothing",
            vec![
                camera("pinhole"),
                depth(),
                json!({"call": "push_edges", "segments": []}),
                call("fit"),
                residuals("EDGES"),
            ],
        ),
    ];
    for element in ["u8", "u16", "f32"] {
        let name = format!("image_{element}");
        cases.push(case(
            &name,
            "limbs located in a grey image",
            vec![
                camera("pinhole"),
                depth(),
                image(&name),
                push_edges(),
                call("fit"),
                call("limb_samples"),
                call("extent"),
            ],
        ));
    }
    cases.push(case(
        "image_as_given",
        "the edges are the measurement",
        vec![
            options(json!({"edge_use": "AS_GIVEN", "extent_rule": "EXTREMES"})),
            camera("pinhole"),
            depth(),
            image("image_u8"),
            push_edges(),
            call("fit"),
            call("extent"),
        ],
    ));
    for model in ["brown_conrady", "kannala_brandt"] {
        cases.push(case(
            model,
            "a lens with distortion",
            vec![
                camera(model),
                depth(),
                push_edges(),
                call("fit"),
                call("extent"),
                json!({"call": "project", "model": truth(), "camera": model}),
            ],
        ));
    }
    cases
}

/// Edges as a line detector finds them: those of the limbs, one across the image, one off the axis.
fn selection() -> Value {
    let mut detected = vec![[3.0, 3.0, 60.0, 4.0], [5.0, 40.0, 40.0, 5.0]];
    detected.splice(1..1, edges());
    let select = |arguments: Value| {
        let mut step = json!({"call": "select_edges", "segments": &detected});
        for (name, value) in arguments.as_object().into_iter().flatten() {
            step[name] = value.clone();
        }
        step
    };
    let steps = vec![
        select(json!({"model": truth()})),
        camera("pinhole"),
        select(json!({"model": truth()})),
        depth(),
        select(json!({})),
        select(json!({"model": truth()})),
        call("fit"),
        select(json!({})),
        select(json!({"reach": 0.125})),
        select(json!({"reach": -1.0})),
        json!({"call": "select_edges", "segments": []}),
        json!({"call": "select_edges", "segments": [[1.0, 2.0, 1.0, 2.0]]}),
    ];
    case("select_edges", "edges of a line detector on the limbs, and what it takes", steps)
}

fn settings() -> Vec<Value> {
    let with = |name: &str, about: &str, settings: Value| {
        let steps = vec![
            camera("pinhole"),
            options(settings),
            call("get_options"),
            depth(),
            push_edges(),
            call("fit"),
        ];
        case(name, about, steps)
    };
    let start = json!({"point": [0.0, 0.0, 0.52], "direction": [0.8, 0.4, 0.45], "radius": 0.03});
    let mut cases = vec![
        with("paper", "the paper's objective", json!({"objective": "PAPER"})),
        with(
            "paper_weight",
            "the paper's objective with another weight, in the local chart",
            json!({"objective": "PAPER", "edge_weight": 0.25, "chart": "LOCAL", "extent_rule": "LOCATED"}),
        ),
        with(
            "paper_edges_only",
            "an edge weight of 1: the scale is that of the start",
            json!({"objective": "PAPER", "edge_weight": 1.0}),
        ),
        with("known_radius", "a radius that is known", json!({"radius_min": 0.041, "radius_max": 0.041})),
        with(
            "radius_limit",
            "a limit that holds the radius",
            json!({"radius_min": 0.02, "radius_max": 0.039}),
        ),
        with(
            "axis_cone",
            "a cone that holds the axis",
            json!({"axis": [0.8, 0.36, 0.5], "axis_max_angle": 0.005}),
        ),
        with(
            "iterations",
            "too few iterations, other constants, one thread",
            json!({
                "max_iterations": 3, "max_threads": 1, "initial_lambda": 1.0, "lambda_factor": 2.0,
                "max_lambda": 1e6, "cost_tolerance": 1e-9, "start": "MOMENTS", "near_wall": "OFF",
            }),
        ),
        with("eberly", "Eberly's algebraic fit", json!({"method": "EBERLY"})),
        with("points_only", "points by plain least squares", json!({"method": "POINTS"})),
        with(
            "ransac",
            "random samples with a seed",
            json!({
                "method": "RANSAC", "seed": 7, "ransac_max_iterations": 200, "ransac_threshold": 0.002,
            }),
        ),
        with("start_ransac", "the start from random samples", json!({"start": "RANSAC", "near_wall": "ON"})),
    ];
    cases.push(case(
        "start_model",
        "a given start, then none",
        vec![
            camera("pinhole"),
            options(json!({"start": "MODEL"})),
            json!({"call": "set_start_model", "model": start}),
            depth(),
            push_edges(),
            call("fit"),
            json!({"call": "set_start_model", "model": null}),
            call("fit"),
        ],
    ));
    cases
}

fn completion() -> Vec<Value> {
    let complete = |layout: &str, scalar: &str| json!({"call": "complete", "layout": layout, "scalar": scalar, "model": truth(), "mask": "small_mask"});
    let depth = |format: &str, scale: f64| json!({"call": "complete_depth", "format": format, "scale": scale, "model": truth(), "mask": "small_mask"});
    let pipe = json!({"point": [0.0, 0.1, 0.0], "direction": [0.1, 0.0, 1.0], "radius": 0.5});
    vec![
        case(
            "complete",
            "points and depth of a given model in every form",
            vec![
                camera("small"),
                complete("PACKED", "F64"),
                complete("PACKED", "F32"),
                complete("ORGANISED", "F64"),
                complete("ORGANISED", "F32"),
                depth("F32", 1.0),
                depth("U16", 1e-3),
                depth("U16", 1e-6),
                json!({"call": "complete", "layout": "PACKED", "scalar": "F64", "model": pipe, "mask": "small_mask"}),
            ],
        ),
        case(
            "geometry",
            "what needs no fitter",
            vec![
                json!({"call": "distances", "model": truth(), "points": {"array": "cloud_f64"}}),
                json!({"call": "distances", "model": truth(), "points": {"array": "organised_f32"}}),
                json!({"call": "distances", "model": truth(), "points": {"array": "none"}}),
                json!({"call": "project", "model": truth(), "camera": "pinhole"}),
                json!({"call": "project", "model": pipe, "camera": "pinhole"}),
                json!({"call": "compare", "a": truth(), "b": pipe}),
                json!({"call": "compare", "a": truth(), "b": {"point": [0, 0, 0], "direction": [0, 0, 0], "radius": 1}}),
            ],
        ),
    ]
}

fn failures() -> Vec<Value> {
    let bad = |about: &str, value: Value| {
        let name = value.as_object().into_iter().flat_map(|o| o.keys()).next().cloned().unwrap_or_default();
        case(&format!("bad_{name}"), about, vec![options(value), call("get_options")])
    };
    let model = |direction: [i32; 3], radius: f64| json!({"call": "set_start_model", "model": {"point": [0, 0, 1], "direction": direction, "radius": radius}});
    let fit = |name: &str, about: &str, array: &str| case(name, about, vec![points(array), call("fit")]);
    vec![
        fit("too_few_points", "four points", "few"),
        fit("plane", "points on a plane", "plane"),
        fit("line", "points on a line", "line"),
        fit("no_usable_points", "no coordinate is finite", "not_finite"),
        case(
            "no_data",
            "a fit of nothing, and what needs a fit",
            vec![
                call("fit"),
                call("get_result"),
                residuals("POINTS"),
                call("diagnose"),
                call("limb_samples"),
                points("none"),
                call("fit"),
            ],
        ),
        bad("a weight beyond 1", json!({"edge_weight": 1.4})),
        bad("a negative damping", json!({"initial_lambda": -1.0})),
        bad("a limit below the other", json!({"radius_max": 0.01, "radius_min": 0.02})),
        bad("a tolerance that is not a number", json!({"cost_tolerance": null})),
        case(
            "bad_intrinsics",
            "the old camera stays",
            vec![
                camera("focal_length_nan"),
                camera("focal_length_negative"),
                depth(),
                camera("pinhole"),
                camera("focal_length_nan"),
                depth(),
                call("counts"),
            ],
        ),
        case(
            "no_intrinsics",
            "what needs a camera",
            vec![
                depth(),
                image("image_u8"),
                push_edges(),
                points("cloud_f64"),
                call("fit"),
                call("extent"),
                json!({"call": "complete", "layout": "PACKED", "scalar": "F64", "model": truth(), "mask": "mask"}),
            ],
        ),
        case(
            "sizes",
            "images that do not go together; nothing is added",
            vec![
                camera("pinhole"),
                json!({"call": "push_depth", "depth": "no_depth", "scale": 1e-4}),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "small_mask"}),
                json!({"call": "push_image", "image": "small_image_not_finite"}),
                json!({"call": "push_points", "points": {"array": "organised_f32"}, "mask": "small_mask"}),
                call("counts"),
            ],
        ),
        case(
            "images",
            "images without a usable pixel",
            vec![
                camera("small"),
                json!({"call": "push_depth", "depth": "no_depth", "scale": 1e-4}),
                image("small_image_not_finite"),
                camera("pinhole"),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "empty_mask"}),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 0.0}),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "min_depth": 0.5, "max_depth": 0.4}),
            ],
        ),
        case(
            "bad_data",
            "negative weights, edges that are not finite, bad models",
            vec![
                json!({"call": "push_points", "points": {
                    "array": "cloud_f64", "weights": {"array": "negative_weight"},
                }}),
                json!({"call": "push_edges", "segments": [[1.0, 2.0, null, 4.0]]}),
                json!({"call": "push_edges", "segments": [[1.0, 2.0, 3.0, 4.0]], "weights": [-1.0]}),
                model([0, 0, 0], 1.0),
                model([0, 0, 1], 0.0),
                model([0, 0, 1], -RADIUS),
                call("counts"),
            ],
        ),
        case(
            "paper_needs_two_edges",
            "the paper's objective with one edge",
            vec![
                options(json!({"objective": "PAPER"})),
                camera("pinhole"),
                depth(),
                json!({"call": "push_edges", "segments": [edges()[0]]}),
                call("fit"),
            ],
        ),
        case(
            "no_region",
            "completion without a model and without a mask",
            vec![
                camera("pinhole"),
                json!({"call": "complete", "layout": "PACKED", "scalar": "F64", "mask": "mask"}),
                json!({"call": "extent", "model": truth()}),
                json!({"call": "extent", "model": truth(), "mask": "empty_mask"}),
                json!({"call": "extent", "model": {"point": [0, 0, 1], "direction": [1, 0, 0], "radius": 0.001},
                "mask": "mask"}),
            ],
        ),
        case(
            "cancel",
            "a request before the fit stops it; clear takes it back",
            vec![
                points("cloud_f64"),
                call("cancel"),
                call("fit"),
                call("fit"),
                call("cancel"),
                call("clear"),
                points("cloud_f64"),
                call("fit"),
            ],
        ),
    ]
}

/// Everything but the outcomes.
pub fn file() -> Value {
    let mut cases = points_of_every_kind();
    cases.extend(frames());
    cases.push(selection());
    cases.extend(settings());
    cases.extend(completion());
    cases.extend(failures());
    json!({"arrays": scene::arrays(), "cameras": scene::cameras(), "cases": cases})
}

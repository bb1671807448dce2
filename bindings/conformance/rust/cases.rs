//! The golden cases: what is called, in which order. What comes out is added by running them.

#![allow(clippy::needless_pass_by_value, reason = "what is passed is written on the spot")]

use super::detectors::detectors;
use super::failures::failures;
use super::scene::{self, edges, truth};
use super::views::views;
use serde_json::{Value, json};

pub fn case(name: &str, about: &str, steps: Vec<Value>) -> Value {
    json!({"name": name, "about": about, "steps": steps})
}

pub fn call(name: &str) -> Value {
    json!({"call": name})
}

pub fn camera(name: &str) -> Value {
    json!({"call": "set_intrinsics", "camera": name})
}

pub fn options(options: Value) -> Value {
    json!({"call": "set_options", "options": options})
}

pub fn points(array: &str) -> Value {
    json!({"call": "push_points", "points": {"array": array}})
}

pub fn depth() -> Value {
    json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "mask"})
}

pub fn push_edges() -> Value {
    json!({"call": "push_edges", "segments": edges()})
}

pub fn image(array: &str) -> Value {
    json!({"call": "push_image", "image": array})
}

pub fn residuals(kind: &str) -> Value {
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
                call("get_cylinder"),
                residuals("POINTS"),
                call("point_weights"),
                call("limbs"),
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
        case(
            "points_weighted",
            "weights of which some are 0",
            vec![weighted, call("counts"), call("fit"), call("point_weights")],
        ),
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
            "point_parts",
            "what the points of a scene without a mask belong to",
            vec![
                camera("pinhole"),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4}),
                call("point_parts"),
                json!({"call": "point_parts", "model": truth()}),
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
                call("limbs"),
                call("limb_samples"),
                call("extent"),
                call("end_samples"),
            ],
        ));
    }
    cases.push(case(
        "image_color",
        "images in colour, with a gamma and an alpha that does not count",
        vec![
            camera("pinhole"),
            depth(),
            push_edges(),
            image("image_rgb"),
            call("fit"),
            json!({"call": "push_image", "image": "image_rgb", "format": "BGR8"}),
            call("fit"),
            json!({"call": "push_image", "image": "image_bgra", "format": "BGRA8", "gamma": 2.2}),
            call("fit"),
            json!({"call": "push_image", "image": "image_bgra", "gamma": 22.0}),
            call("end_samples"),
        ],
    ));
    cases.push(case(
        "mask_label",
        "the pixels of one label in a mask of labels",
        vec![
            camera("pinhole"),
            json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "mask", "label": 255}),
            call("counts"),
            json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4, "mask": "mask", "label": 7}),
        ],
    ));
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
        with(
            "noise",
            "what is known of the errors of the data",
            json!({
                "independent_points": 50.0, "depth_noise": 1e-3, "image_noise": 2.5, "edge_noise": 0.25,
                "mask_noise": 0.75, "image_blur": 0.5, "drawn_pixel": 1.5, "depth_shared": 0.004,
                "gradient_tolerance": 1e-6,
                "step_tolerance": 1e-7,
            }),
        ),
        with("points_share_nothing", "no errors that all points share", json!({"depth_shared": -2.0})),
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
    let pixels = json!([[48.0, 38.5], [0.0, 74.25], [-20.0, 3.0], [null, 3.0]]);
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
                json!({"call": "intrinsics_project", "camera": "pinhole", "points": {"array": "beside_f64"}}),
                json!({"call": "intrinsics_project", "camera": "brown_conrady", "points": {"array": "beside_f64"}}),
                json!({"call": "intrinsics_project", "camera": "kannala_brandt", "points": {"array": "beside_f64"}}),
                json!({"call": "intrinsics_project", "camera": "focal_length_nan", "points": {"array": "none"}}),
                json!({"call": "intrinsics_unproject", "camera": "pinhole", "pixels": pixels}),
                json!({"call": "intrinsics_unproject", "camera": "brown_conrady", "pixels": pixels}),
                json!({"call": "intrinsics_unproject", "camera": "kannala_brandt", "pixels": pixels}),
                json!({"call": "compare", "a": truth(), "b": pipe}),
                json!({"call": "compare", "a": truth(), "b": {"point": [0, 0, 0], "direction": [0, 0, 0], "radius": 1}}),
            ],
        ),
    ]
}

/// Everything but the outcomes.
pub fn file() -> Value {
    let mut cases = points_of_every_kind();
    cases.extend(frames());
    cases.extend(views());
    cases.push(selection());
    cases.extend(settings());
    cases.extend(completion());
    cases.extend(detectors());
    cases.extend(failures());
    json!({"arrays": scene::arrays(), "cameras": scene::cameras(), "cases": cases})
}

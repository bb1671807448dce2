//! Cases of calls that fail.

use super::cases::{call, camera, case, depth, image, options, points, push_edges, residuals};
use super::scene::{RADIUS, edges, truth};
use serde_json::{Value, json};

pub fn failures() -> Vec<Value> {
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
            "a request while no call is running does nothing",
            vec![points("cloud_f64"), call("cancel"), call("fit")],
        ),
    ]
}

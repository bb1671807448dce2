//! The golden cases of detectors.

#![allow(clippy::needless_pass_by_value, reason = "what is passed is written on the spot")]

use super::cases::{call, case};
use serde_json::{Value, json};

fn options(options: Value) -> Value {
    json!({"call": "detector_set_options", "options": options})
}

fn frame(with_image: bool) -> Vec<Value> {
    let mut steps = vec![
        json!({"call": "frame_set_intrinsics", "camera": "pair"}),
        json!({"call": "frame_set_depth", "depth": "pair_depth", "scale": 1e-4}),
    ];
    if with_image {
        steps.push(json!({"call": "frame_set_image", "image": "pair_image"}));
    }
    steps
}

fn about(index: usize) -> Vec<Value> {
    let calls = ["detector_get_result", "detector_get_cylinder", "detector_get_extent", "detector_indices"];
    calls.iter().map(|call| json!({"call": call, "index": index})).collect()
}

/// The steps after a frame.
fn of_frame(with_image: bool, steps: Vec<Value>) -> Vec<Value> {
    let mut all = frame(with_image);
    all.extend(steps);
    all
}

fn everything() -> Vec<Value> {
    let mut steps = of_frame(
        true,
        vec![
            call("detector_get_options"),
            call("detector_get_fit_options"),
            call("detect"),
            call("detector_count"),
            call("detector_detections"),
            call("detector_labels"),
        ],
    );
    steps.extend(about(0));
    steps.extend(about(1));
    steps.push(json!({"call": "detector_make_fitter", "index": 1}));
    steps.extend(["get_options", "counts", "get_result", "get_cylinder", "limbs", "fit"].map(call));
    steps
}

fn cloud() -> Vec<Value> {
    let mut steps = vec![
        json!({"call": "detect_points", "points": {"array": "pair_cloud"}}),
        call("detector_detections"),
        call("detector_labels"),
    ];
    steps.extend(about(0));
    steps.push(json!({"call": "detector_make_fitter", "index": 0}));
    steps.push(call("counts"));
    steps
}

pub fn detectors() -> Vec<Value> {
    let fits = |options: Value| json!({"call": "detector_set_fit_options", "options": options});
    let (detect, detections) = (call("detect"), call("detector_detections"));
    vec![
        case("detector_frame", "all cylinders of a frame and all that can be asked of them", everything()),
        case("detector_depth", "without an image", of_frame(false, vec![detect.clone(), detections.clone()])),
        case("detector_cloud", "all cylinders of an organised cloud", cloud()),
        case(
            "detector_options",
            "options of the search and of the fits; the reference frame",
            of_frame(
                true,
                vec![
                    options(json!({
                        "image_use": "IGNORE", "max_threads": 2, "max_count": 1, "min_pixels": 200,
                        "min_score": 0.25, "radius_min": 0.03, "radius_max": 0.1, "axis": [0, 2, 0],
                        "axis_max_angle": 0.5,
                    })),
                    call("detector_get_options"),
                    fits(json!({"depth_noise": 0.001})),
                    call("detector_get_fit_options"),
                    detect.clone(),
                    detections.clone(),
                    json!({"call": "frame_set_pose", "pose": super::scene::second_pose()}),
                    call("new_detector"),
                    call("detector_get_options"),
                    detect.clone(),
                    detections.clone(),
                    call("detector_cancel"),
                ],
            ),
        ),
        case(
            "detector_failures",
            "what is refused, and scenes without anything",
            vec![
                call("detector_count"),
                detect.clone(),
                json!({"call": "frame_set_intrinsics", "camera": "small"}),
                detect.clone(),
                options(json!({"min_score": 1.5})),
                options(json!({"radius_min": 2.0, "radius_max": 1.0})),
                fits(json!({"start": "LIMBS"})),
                fits(json!({"radius_max": 1.0})),
                fits(json!({"max_threads": 2})),
                json!({"call": "frame_set_depth", "depth": "no_depth", "scale": 1e-4}),
                detect,
                call("detector_count"),
                detections,
                call("detector_labels"),
                json!({"call": "detector_get_result", "index": 0}),
                json!({"call": "detector_indices", "index": 3}),
                json!({"call": "detector_make_fitter", "index": 0}),
                json!({"call": "detect_points", "points": {"array": "none"}}),
                json!({"call": "detect_points", "points": {"array": "not_finite"}}),
                call("detector_count"),
                json!({"call": "detect_points", "points": {
                    "array": "cloud_f64", "weights": {"array": "negative_weight"},
                }}),
            ],
        ),
    ]
}

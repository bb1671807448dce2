//! Cases of several views, of a depth camera of its own, and of frames.

use super::cases::{call, camera, case, depth, image, points, push_edges, residuals};
use super::scene::{depth_pose, second_pose, truth};
use serde_json::{Value, json};

fn select(index: usize) -> Value {
    json!({"call": "select_view", "index": index})
}

fn second_depth() -> Value {
    json!({"call": "push_depth", "depth": "second_depth", "scale": 1e-4, "mask": "second_mask"})
}

fn own_depth(of: &str) -> Value {
    json!({"call": format!("{of}set_depth_camera"), "camera": "own_depth", "pose": depth_pose()})
}

fn clear(inputs: &[&str]) -> Value {
    json!({"call": "clear_input", "inputs": inputs})
}

fn use_frame() -> Value {
    json!({"call": "use_frame", "mask": "mask"})
}

pub fn views() -> Vec<Value> {
    let pose = |call: &str| json!({"call": call, "pose": second_pose()});
    let turned = [[1, 0, 0], [0, 1, 0], [0, 0, -1]].concat();
    vec![
        case(
            "views",
            "one cylinder in two views, each with its own data",
            vec![
                camera("pinhole"),
                depth(),
                image("image_u8"),
                push_edges(),
                select(1),
                call("view_count"),
                camera("pinhole"),
                pose("set_pose"),
                second_depth(),
                image("second_image"),
                call("counts"),
                call("fit"),
                call("limbs"),
                call("limb_samples"),
                residuals("POINTS"),
                residuals("EDGES"),
                call("extent"),
                call("end_samples"),
                json!({"call": "extent", "model": truth()}),
                select(0),
                call("limb_samples"),
                residuals("EDGES"),
                json!({"call": "evaluate", "model": truth()}),
                call("clear"),
                call("view_count"),
                call("counts"),
            ],
        ),
        case(
            "view_moved",
            "one view away from the reference frame; a bad pose changes nothing",
            vec![
                camera("small"),
                pose("set_pose"),
                json!({"call": "set_pose", "pose": {"rotation": turned, "translation": [0, 0, 0]}}),
                json!({"call": "set_pose", "pose": {"rotation": [1, 0, 0, 0, 1, 0, 0, 0, 1], "translation": [0, null, 0]}}),
                json!({"call": "complete", "layout": "PACKED", "scalar": "F64", "model": truth(), "mask": "small_mask"}),
                json!({"call": "complete_depth", "format": "F32", "scale": 1.0, "model": truth(), "mask": "small_mask"}),
                points("cloud_f64"),
                call("fit"),
                residuals("POINTS"),
            ],
        ),
        case(
            "depth_camera",
            "depth that is not registered to the colour image",
            vec![
                camera("pinhole"),
                own_depth(""),
                json!({"call": "push_depth", "depth": "depth_u16", "scale": 1e-4}),
                json!({"call": "push_depth", "depth": "own_depth", "scale": 1e-4, "mask": "mask"}),
                image("image_u8"),
                call("counts"),
                call("fit"),
                call("extent"),
                clear(&["POINTS", "DEPTH"]),
                json!({"call": "set_depth_camera", "camera": null}),
                depth(),
                call("fit"),
            ],
        ),
        case(
            "clear_input",
            "some of the data go, the rest stays",
            vec![
                camera("pinhole"),
                depth(),
                image("image_u8"),
                push_edges(),
                clear(&["IMAGE", "EDGES"]),
                call("counts"),
                call("fit"),
                clear(&["POINTS"]),
                call("counts"),
                call("fit"),
                points("cloud_f64"),
                call("fit"),
                call("extent"),
                clear(&["DEPTH"]),
                call("extent"),
            ],
        ),
        case(
            "frame",
            "a frame that two fitters take their data from, one after the other, and another frame",
            vec![
                json!({"call": "frame_set_depth", "depth": "depth_u16", "scale": 1e-4}),
                json!({"call": "frame_set_intrinsics", "camera": "focal_length_nan"}),
                json!({"call": "frame_set_intrinsics", "camera": "pinhole"}),
                json!({"call": "frame_set_depth", "depth": "own_depth", "scale": 1e-4}),
                json!({"call": "frame_set_depth", "depth": "depth_u16", "scale": 1e-4, "max_depth": 0.8}),
                json!({"call": "frame_set_image", "image": "image_rgb"}),
                use_frame(),
                call("counts"),
                call("fit"),
                call("new_fitter"),
                json!({"call": "use_frame", "mask": "small_mask"}),
                json!({"call": "use_frame", "mask": "empty_mask"}),
                use_frame(),
                push_edges(),
                call("new_frame"),
                call("fit"),
                call("extent"),
                select(1),
                json!({"call": "frame_set_intrinsics", "camera": "pinhole"}),
                pose("frame_set_pose"),
                json!({"call": "frame_set_depth", "depth": "second_depth", "scale": 1e-4}),
                json!({"call": "use_frame", "mask": "second_mask"}),
                call("fit"),
            ],
        ),
        case(
            "frame_depth_camera",
            "a frame with a depth camera of its own",
            vec![
                json!({"call": "frame_set_intrinsics", "camera": "pinhole"}),
                own_depth("frame_"),
                json!({"call": "frame_set_depth", "depth": "own_depth", "scale": 1e-4}),
                use_frame(),
                call("counts"),
                call("fit"),
            ],
        ),
    ]
}

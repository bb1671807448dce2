//! The errors of the default fit on the frames of the tests: they must not double.
#![allow(clippy::unwrap_used)]

#[path = "support/frames.rs"]
mod frames;

use frames::{Inputs, cylinder, json};
use std::path::Path;

/// What figures may grow to.
const LIMIT: f64 = 2.0;

/// Errors below these are noise of a single frame: no limit is less than twice as much. E_o in degrees, E_p in mm, E_r and
/// E_l in %.
const FLOORS: [f64; 4] = [0.05, 0.1, 0.05, 0.05];

const NAMES: [&str; 4] = ["E_o", "E_p", "E_r", "E_l"];

/// A frame, whether its edges are given, and the errors of today.
const FIGURES: [(&str, bool, [f64; 4]); 6] = [
    ("r40_a20_f0", true, [0.150, 0.167, 0.356, 0.010]),
    ("r40_a20_f0", false, [0.147, 0.222, 0.144, 0.014]),
    ("w004", true, [0.259, 0.302, 0.074, 0.261]),
    ("w004", false, [0.203, 0.271, 0.038, 0.208]),
    ("w022", true, [0.025, 0.767, 0.061, 0.139]),
    ("w022", false, [0.029, 0.964, 0.063, 0.187]),
];

/// The angle between the axes, the distance of the centres of the visible pieces, and the relative errors of radius and
/// length, of the default fit with the image.
fn errors(frame: &str, with_edges: bool) -> [f64; 4] {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames").join(frame);
    let truth = json(&folder.join("truth.json"));
    let (expected, length) = (cylinder(&truth, "center", "axis"), truth["length"].as_f64().unwrap());
    let inputs = Inputs::read(&folder);
    let mut fitter = inputs.fitter();
    inputs.push_image(&mut fitter);
    if with_edges {
        fitter.push_edges(&inputs.edges).unwrap();
    }
    let found = fitter.fit().unwrap().cylinder;
    let extent = fitter.extent(None, None).unwrap();
    let difference = expected.compare(&found);
    [
        difference.angle.to_degrees(),
        (extent.center - expected.axis.point).norm() * 1e3,
        difference.radius_relative.abs() * 100.0,
        (extent.length / length - 1.0).abs() * 100.0,
    ]
}

#[test]
fn the_errors_of_the_default_have_not_doubled() {
    let mut worse = Vec::new();
    for (frame, with_edges, figures) in FIGURES {
        let found = errors(frame, with_edges);
        println!("(\"{frame}\", {with_edges}, {found:.3?}),");
        for k in 0..4 {
            let limit = LIMIT * figures[k].max(FLOORS[k]);
            // NaN is worse, too.
            if !(found[k] <= limit) {
                let edges = if with_edges { "with" } else { "without" };
                worse.push(format!("{frame} {edges} edges: {} {:.3} > {limit:.3}", NAMES[k], found[k]));
            }
        }
    }
    assert!(worse.is_empty(), "{worse:#?}");
}

//! Tables of frames whose errors the points share (time of flight, recorded frames) or the image has (compression).

use crate::Sets;
use crate::disturbance::Disturbance;
use crate::frame::{Case, Edges, Frame};
use crate::rows::fit_all;
use crate::table::{Summary, Target, print_head, print_row, print_targets};

/// The default, without the edges.
fn no_edges() -> Case {
    Case { edges: Edges::None, ..Case::default() }
}

/// Time of flight: rounded profiles, flying pixels, an offset.
pub fn tof(sets: &Sets) {
    let targets = [
        Target::mean(0.12),
        Target::NONE,
        Target { mean: 0.20, worst: 0.8, ..Target::NONE },
        Target::mean(0.3),
    ];
    print_head("frames/tof");
    print_targets(&targets);
    let rows = [
        ("image and edges", Case::default(), targets),
        ("image, no edges", no_edges(), [Target::NONE; 4]),
        ("edges, no image", Case { image: false, ..Case::default() }, [Target::NONE; 4]),
        ("neither", Case { image: false, ..no_edges() }, [Target::NONE; 4]),
    ];
    for (name, case, targets) in rows {
        print_row(name, &fit_all(sets, name, &sets.tof, &case), &targets);
    }
}

/// Images that were compressed.
pub fn compressed(sets: &Sets) {
    let targets =
        [Target::NONE, Target::NONE, Target { mean: 0.22, worst: 1.2, ..Target::NONE }, Target::NONE];
    print_head("JPEG of quality 80, image and mask, no edges");
    print_targets(&targets);
    let case = Case { disturbance: Disturbance::Jpeg(80), ..no_edges() };
    print_row("frames/paper", &fit_all(sets, "JPEG", &sets.paper, &case), &targets);
    print_row("frames/wild", &fit_all(sets, "JPEG", &sets.wild, &case), &[Target::NONE; 4]);
}

/// Error of the radius and its stated standard deviation, in percent of the radius.
fn stated(frame: &Frame, case: &Case) -> Option<(f64, f64)> {
    let (fitter, model) = frame.fit(case).ok()?;
    let radius = frame.truth.radius;
    let deviation = fitter.result()?.uncertainty?.radius();
    Some(((model.radius / radius - 1.0) * 100.0, deviation / radius * 100.0))
}

/// The radii of recorded frames with their stated deviations.
pub fn real(sets: &Sets) {
    println!("\n### recorded frames, radius error ± stated deviation (%)\n");
    println!("In brackets: frames whose radius is known only from the frame itself.\n");
    println!("| frame | image and edges | image, no edges | neither |\n|---|---|---|---|");
    let cases =
        [Case::default(), no_edges(), Case { image: false, ..no_edges() }].map(|case| (case, Vec::new()));
    let mut columns = cases;
    for frame in sets.real.iter().chain(&sets.real2) {
        let has_edges = !frame.inputs.edges.is_empty();
        let texts: Vec<String> = columns
            .iter_mut()
            .enumerate()
            .map(|(k, (case, errors))| {
                if k == 0 && !has_edges {
                    return "–".into();
                }
                let Some((error, deviation)) = stated(frame, case) else { return "failed".into() };
                if frame.radius_known && !has_edges {
                    errors.push(error.abs());
                }
                format!("{error:+.2} ± {deviation:.2}")
            })
            .collect();
        let name = if frame.radius_known { frame.name.clone() } else { format!("({})", frame.name) };
        println!("| {name} | {} |", texts.join(" | "));
    }
    for (name, k) in [("image, no edges", 1), ("neither", 2)] {
        let Summary { median, worst, .. } = Summary::new(columns[k].1.clone());
        println!("\nreal2, radius known, {name}: median {median:.2} %, worst {worst:.2} % (targets 2 and 8)");
    }
}

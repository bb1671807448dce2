//! The tables, one function each. The targets are those of the project's accuracy goals.

use crate::Sets;
use crate::disturbance::Disturbance;
use crate::frame::{Case, Edges, Errors, Frame, GIVEN};
use crate::parallel::map;
use crate::scaled::{SAME, Scale};
use crate::shared_errors;
use crate::table::{Summary, Target, columns, print_head, print_row, print_targets};
use cylfuse::fitter::{Method, ObjectiveKind, Options, StartKind};

/// Seeds of the disturbed endpoints.
const SEEDS: [u64; 3] = [1, 2, 3];

/// Parts by which a result may be worse than the reference of its row.
const AS_GOOD_AS_GIVEN: f64 = 1.25;
const NEVER_WORSE: f64 = 1.05;

/// Pixels by which a wrong edge is moved.
const WRONG_EDGE: f64 = 20.0;

/// Pixels beside the limbs where people set the edges of a mask at worst.
const REAL_GROWTH: i32 = 3;

pub fn fit_all(sets: &Sets, name: &str, frames: &[Frame], case: &Case) -> Vec<Option<Errors>> {
    let all = map(frames, |frame| frame.errors_of(case));
    list(sets, name, frames, &all);
    all
}

/// Prints the errors of single frames, where they are asked for.
fn list(sets: &Sets, name: &str, frames: &[Frame], all: &[Option<Errors>]) {
    for (frame, errors) in frames.iter().zip(all).filter(|_| sets.list) {
        let text = errors.map_or("failed".into(), |e| e.map(|x| format!("{x:7.3}")).join(" "));
        eprintln!("{name:24} {:12} {text}", frame.name);
    }
}

/// frames/paper with image and edges, the reference of the rows with worse inputs.
const FIRST_ROW: [Target; 4] = [
    Target { mean: 0.25, ninety: 0.5, worst: 1.0, ..Target::NONE },
    Target { mean: 0.45, ninety: 0.8, worst: 2.0, ..Target::NONE },
    Target { mean: 0.20, ninety: 0.45, worst: 1.0, ..Target::NONE },
    Target { mean: 0.60, ninety: 1.2, worst: 4.0, ..Target::NONE },
];

pub fn given(sets: &Sets) {
    print_head("frames/paper, image and given edges");
    print_targets(&FIRST_ROW);
    print_row("given", &fit_all(sets, "given", &sets.paper, &Case::default()), &FIRST_ROW);
}

pub fn wild(sets: &Sets) {
    let targets = [
        Target { median: 0.20, ninety: 0.8, worst: 3.0, ..Target::NONE },
        Target { median: 0.40, ninety: 1.0, ..Target::NONE },
        Target { median: 0.15, ninety: 0.6, worst: 3.0, ..Target::NONE },
        Target { median: 0.5, ninety: 2.0, ..Target::NONE },
    ];
    print_head("frames/wild, image and given edges");
    print_targets(&targets);
    print_row("given", &fit_all(sets, "wild", &sets.wild, &Case::default()), &targets);
}

/// Targets of rows that are compared with the first one as it is measured.
fn near_first_row(sets: &Sets) -> [Target; 4] {
    let first = fit_all(sets, "given", &sets.paper, &Case::default());
    columns(&first).map(|column| Target::mean(column.mean * AS_GOOD_AS_GIVEN))
}

pub fn no_edges(sets: &Sets) {
    let mut targets = near_first_row(sets);
    print_head("frames/paper, image and mask, no edges");
    print_targets(&targets);
    for (name, grow) in [("as given", 0), ("dilated 2 px", 2), ("eroded 2 px", -2)] {
        if grow != 0 {
            // Centre and length are asked for with the mask as given only.
            targets[1] = Target::NONE;
            targets[3] = Target::NONE;
        }
        let case = Case { edges: Edges::None, grow, ..Case::default() };
        print_row(name, &fit_all(sets, name, &sets.paper, &case), &targets);
    }
    for image in [true, false] {
        let case = Case { edges: Edges::None, image, of_depth: true, ..Case::default() };
        let name = if image { "pixels with depth" } else { "pixels with depth, no image" };
        print_row(name, &fit_all(sets, name, &sets.paper, &case), &[Target::NONE; 4]);
    }
    let case = Case { edges: Edges::None, image: false, ..Case::default() };
    print_row("no image", &fit_all(sets, "no image", &sets.paper, &case), &[Target::NONE; 4]);
    let case = Case { edges: Edges::None, mask: false, ..Case::default() };
    print_row("no mask", &fit_all(sets, "no mask", &sets.paper, &case), &[Target::NONE; 4]);
    let case = Case { edges: Edges::None, ..Case::default() };
    print_row("frames/wild", &fit_all(sets, "no edges", &sets.wild, &case), &[Target::NONE; 4]);
}

pub fn no_image(sets: &Sets) {
    let targets = [0.40, 0.8, 0.85, 2.0].map(Target::mean);
    print_head("frames/paper, given edges, no image");
    print_targets(&targets);
    let case = Case { image: false, ..Case::default() };
    print_row("no image", &fit_all(sets, "no image", &sets.paper, &case), &targets);
}

/// The errors with disturbed endpoints, of all seeds.
fn with_noise(sets: &Sets, frames: &[Frame], noise: f64, case: &Case) -> Vec<Option<Errors>> {
    let fit = |seed: &u64| {
        let case = Case { edges: Edges::Both { noise, seed: *seed }, ..*case };
        fit_all(sets, &format!("noise {noise} seed {seed}"), frames, &case)
    };
    SEEDS.iter().flat_map(fit).collect()
}

pub fn disturbed(sets: &Sets) {
    let targets = near_first_row(sets);
    print_head("frames/paper, image and bad edges");
    print_targets(&targets);
    for noise in [0.0, 1.0, 2.0, 3.0, 4.0] {
        // The last one is not asked for here.
        let targets = if noise <= 3.0 { targets } else { [Target::NONE; 4] };
        let all = with_noise(sets, &sets.paper, noise, &Case::default());
        print_row(&format!("endpoints disturbed by {noise} px"), &all, &targets);
    }
    let others = [
        ("first edge 20 px out or in", Edges::OneWrong { which: 0, shift: WRONG_EDGE }),
        ("the same, to the other side", Edges::OneWrong { which: 0, shift: -WRONG_EDGE }),
        ("second edge 20 px out or in", Edges::OneWrong { which: 1, shift: WRONG_EDGE }),
        ("the same, to the other side", Edges::OneWrong { which: 1, shift: -WRONG_EDGE }),
        ("first edge alone", Edges::One(0)),
        ("second edge alone", Edges::One(1)),
        ("first limb twice", Edges::Twice(0)),
    ];
    for (name, edges) in others {
        let case = Case { edges, ..Case::default() };
        print_row(name, &fit_all(sets, name, &sets.paper, &case), &[Target::NONE; 4]);
    }
    let none = [Target::NONE; 4];
    for noise in [1.0, 3.0] {
        let all = with_noise(sets, &sets.wild, noise, &Case::default());
        print_row(&format!("frames/wild, {noise} px"), &all, &none);
    }
}

/// Images as cameras and files deliver them, and the gamma that the fit is told.
pub fn images(sets: &Sets) {
    let rows = [
        ("as given", Disturbance::None, 1.0),
        ("sRGB", Disturbance::Srgb, 2.2),
        ("to the power of 0.45", Disturbance::Power(0.45), 1.0 / 0.45),
        ("to the power of 0.6", Disturbance::Power(0.6), 1.0 / 0.6),
        ("to the power of 0.8", Disturbance::Power(0.8), 1.0 / 0.8),
        ("to the power of 1.5", Disturbance::Power(1.5), 1.0 / 1.5),
        ("JPEG, quality 80", Disturbance::Jpeg(80), 1.0),
        ("corners darker by 50 %", Disturbance::Vignetting(0.5), 1.0),
        ("exposed 2 times, white cut", Disturbance::Exposed(2.0), 1.0),
        ("Bayer pattern, noise", Disturbance::Bayer, 1.0),
        ("sharpened by 0.5", Disturbance::Sharpened(0.5), 1.0),
        ("sharpened by 1", Disturbance::Sharpened(1.0), 1.0),
        ("half the size and back", Disturbance::Halved, 1.0),
        ("sRGB, sharpened by 1, JPEG", Disturbance::Telephone, 2.2),
    ];
    let coded = [Target::NONE, Target::NONE, Target::mean(0.18), Target::NONE];
    for (set, frames) in [("frames/paper", &sets.paper), ("frames/wild", &sets.wild)] {
        print_head(&format!("{set}, images as cameras and files deliver them"));
        for (name, disturbance, gamma) in rows {
            let case = Case { disturbance, ..Case::default() };
            print_row(name, &fit_all(sets, name, frames, &case), &[Target::NONE; 4]);
            if gamma != 1.0 {
                let name = format!("{name}, gamma told");
                let of_curve = set == "frames/paper" && disturbance != Disturbance::Telephone;
                let targets = if of_curve { coded } else { [Target::NONE; 4] };
                print_row(&name, &fit_all(sets, &name, frames, &Case { gamma, ..case }), &targets);
            }
        }
    }
    if sets.real.is_empty() {
        return;
    }
    println!("\n### real frames, radius error (%) by the gamma that the fit is told\n");
    print_real_head(sets, "");
    for (edges, name) in [(GIVEN, "image and edges"), (Edges::None, "image, no edges")] {
        for gamma in [1.0, 2.2] {
            let errors = radius_errors(sets, &Case { edges, gamma, ..Case::default() });
            print_real_row(&format!("{name}, gamma {gamma}"), &errors, "");
        }
    }
}

/// The same frames on other grids of pixels: errors may grow by a factor only.
pub fn scaled(sets: &Sets) {
    print_head("frames/paper, enlarged and reduced");
    let mut same = [f64::NAN; 4];
    let rows = [
        ("as given", SAME, f64::INFINITY),
        ("half the size", Scale { of_new: 1, of_old: 2 }, f64::INFINITY),
        ("twice the size", Scale { of_new: 2, of_old: 1 }, 1.15),
        ("four times the size", Scale { of_new: 4, of_old: 1 }, 1.3),
    ];
    for (name, scale, factor) in rows {
        let errors = |frame: &Frame| scale.applied(frame).errors_of(&Case::default());
        let all = map(&sets.paper, errors);
        list(sets, name, &sets.paper, &all);
        let targets =
            same.map(|mean| if factor.is_finite() { Target::mean(factor * mean) } else { Target::NONE });
        let columns = print_row(name, &all, &targets);
        if scale == SAME {
            same = columns.map(|column| column.mean);
        }
    }
}

/// Standard deviations of axis (degrees), centre (mm), radius (%) and length (%) over the captures of each scene,
/// root mean square over the scenes.
fn spread(sets: &Sets, case: &Case) -> [f64; 4] {
    let fits = map(&sets.repeat, |frame| {
        let (fitter, model) = frame.fit(case).unwrap();
        let extent = fitter.extent(Some(&model), None).unwrap();
        (model, extent)
    });
    let mut scenes: Vec<(&str, Vec<usize>)> = Vec::new();
    for (index, frame) in sets.repeat.iter().enumerate() {
        let scene = frame.name.rsplit_once(['_', '-']).map_or(&frame.name[..], |parts| parts.0);
        match scenes.last_mut().filter(|last| last.0 == scene) {
            Some(last) => last.1.push(index),
            None => scenes.push((scene, vec![index])),
        }
    }
    let mut variances = [0.0; 4];
    for (_, members) in &scenes {
        let count = members.len() as f64;
        let mean = |value: &dyn Fn(usize) -> f64| members.iter().map(|&k| value(k)).sum::<f64>() / count;
        let direction = |k: usize| {
            let d = fits[k].0.axis.direction;
            d * d.dot(&fits[members[0]].0.axis.direction).signum()
        };
        let axis = members.iter().map(|&k| direction(k)).sum::<nalgebra::Vector3<f64>>() / count;
        let center = members.iter().map(|&k| fits[k].1.center).sum::<nalgebra::Vector3<f64>>() / count;
        let (radius, length) = (mean(&|k| fits[k].0.radius), mean(&|k| fits[k].1.length));
        let squares = |value: &dyn Fn(usize) -> f64| {
            members.iter().map(|&k| value(k).powi(2)).sum::<f64>() / (count - 1.0) / scenes.len() as f64
        };
        variances[0] += squares(&|k| (direction(k) - axis).norm().to_degrees());
        variances[1] += squares(&|k| (fits[k].1.center - center).norm() * 1e3);
        variances[2] += squares(&|k| (fits[k].0.radius / radius - 1.0) * 100.0);
        variances[3] += squares(&|k| (fits[k].1.length / length - 1.0) * 100.0);
    }
    variances.map(f64::sqrt)
}

pub fn repeat(sets: &Sets) {
    if sets.repeat.is_empty() {
        return;
    }
    println!("\n### frames/repeat, standard deviation over the captures of a scene\n");
    println!("| row | axis (deg) | centre (mm) | radius (%) | length (%) |\n|---|---|---|---|---|");
    let paper = spread(sets, &Case { image: false, options: paper_options(), ..Case::default() });
    let default = spread(sets, &Case::default());
    let print = |name: &str, values: [f64; 4]| {
        println!("| {name} | {} |", values.map(|value| format!("{value:.3}")).join(" | "));
    };
    print("*target: ratio*", [0.5; 4]);
    print("paper's objective", paper);
    print("default", default);
    print("ratio", [0, 1, 2, 3].map(|k| default[k] / paper[k]));
}

/// Signed radius error in percent.
fn radius_errors(sets: &Sets, case: &Case) -> Vec<f64> {
    map(&sets.real, |frame| {
        let fit = frame.fit(case);
        fit.map_or(f64::INFINITY, |(_, model)| (model.radius / frame.truth.radius - 1.0) * 100.0)
    })
}

/// Prints the head of a table of recorded frames, with further columns in Markdown, and gives the names of the frames.
fn print_real_head<'a>(sets: &'a Sets, more: &str) -> Vec<&'a str> {
    let names: Vec<&str> = sets.real.iter().map(|frame| &frame.name[..]).collect();
    println!("| row | {} | median | worst |{more}", names.join(" | "));
    println!("|---|{}---|---|{}", "---|".repeat(names.len()), "---|".repeat(more.matches('|').count()));
    names
}

fn print_real_row(name: &str, errors: &[f64], more: &str) -> Summary {
    let summary = Summary::new(errors.iter().map(|error| error.abs()).collect());
    let texts: Vec<String> = errors.iter().map(|error| format!("{error:+.2}")).collect();
    let Summary { median, worst, .. } = summary;
    println!("| {name} | {} | {median:.2} | {worst:.2} |{more}", texts.join(" | "));
    summary
}

pub fn real(sets: &Sets) {
    if sets.real.is_empty() {
        return;
    }
    println!("\n### real frames, radius error (%) against the radius in the scale of the sensor\n");
    let names = print_real_head(sets, " missed |");
    for (mask, grow) in [("mask as given", 0), ("mask dilated 3 px", REAL_GROWTH)] {
        let print = |name: &str, errors: &[f64], missed: &str| {
            print_real_row(&format!("{mask}: {name}"), errors, &format!(" {missed} |"))
        };
        let case = Case { grow, ..Case::default() };
        let paper = radius_errors(sets, &Case { image: false, options: paper_options(), ..case });
        let paper = print("paper's objective", &paper, "").median;
        let edges = radius_errors(sets, &Case { image: false, ..case });
        print("edges as given", &edges, "");
        for (name, edges_given) in [("image and edges", GIVEN), ("image, no edges", Edges::None)] {
            let errors = radius_errors(sets, &Case { edges: edges_given, ..case });
            let mut missed: Vec<String> = Vec::new();
            let summary = Summary::new(errors.iter().map(|error| error.abs()).collect());
            if summary.median > paper {
                missed.push("median".into());
            }
            for (k, error) in errors.iter().enumerate() {
                if error.abs() > 5.0 {
                    missed.push(format!("{} over 5 %", names[k]));
                }
                if error.abs() > edges[k].abs() + 1.5 {
                    missed.push(format!("{} worse than the edges", names[k]));
                }
            }
            print(name, &errors, &missed.join(", "));
        }
    }
    shared_errors::real(sets);
}

/// The default against points alone and limbs with the scale vote alone.
pub fn never_worse(sets: &Sets) {
    println!(
        "\n### frames/paper, never worse\n\nmean; default / points alone / limbs with the scale vote alone\n"
    );
    println!("| edges | image | {} | missed |\n|---|---|---|---|---|---|---|", crate::table::HEAD);
    let alone = Case { edges: Edges::None, image: false, mask: false, ..Case::default() };
    let points = columns(&fit_all(sets, "points alone", &sets.paper, &alone));
    let mut cases: Vec<(String, Vec<Edges>)> = [0.0, 1.0, 2.0, 3.0, 4.0]
        .iter()
        .map(|&noise| {
            (format!("disturbed by {noise} px"), SEEDS.map(|seed| Edges::Both { noise, seed }).to_vec())
        })
        .collect();
    let wrong = |which| [1.0, -1.0].map(|sign| Edges::OneWrong { which, shift: sign * WRONG_EDGE });
    cases.push(("one 20 px off".into(), [wrong(0), wrong(1)].concat()));
    cases.push(("none".into(), vec![Edges::None]));
    for (name, edges) in cases {
        let limbs_alone: Vec<Option<Errors>> =
            edges.iter().flat_map(|&edges| map(&sets.paper, |frame| limb_start(frame, edges))).collect();
        let limbs = columns(&limbs_alone);
        for image in [true, false] {
            let fit =
                |&edges: &Edges| fit_all(sets, &name, &sets.paper, &Case { edges, image, ..Case::default() });
            let default = columns(&edges.iter().flat_map(fit).collect::<Vec<_>>());
            let mut missed = Vec::new();
            let texts = [0, 1, 2, 3].map(|k| {
                let (own, points, limbs) = (default[k].mean, points[k].mean, limbs[k].mean);
                // Without edges there are no limbs to compare with: the minimum leaves NaN out.
                if !(own <= NEVER_WORSE * points.min(limbs)) {
                    missed.push(["E_o", "E_p", "E_r", "E_l"][k]);
                }
                format!("{own:.2} / {points:.2} / {limbs:.2}")
            });
            let image = if image { "yes" } else { "no" };
            println!("| {name} | {image} | {} | {} |", texts.join(" | "), missed.join(", "));
        }
    }
}

/// The errors of the start from the limbs and the scale vote of the points.
fn limb_start(frame: &Frame, edges: Edges) -> Option<Errors> {
    // The paper's objective takes the edges as they are.
    let options = Options { start: StartKind::Limbs, ..paper_options() };
    let mut fitter = frame.fitter(&Case { edges, image: false, ..Case::default() });
    fitter.set_options(options).ok()?;
    let start = fitter.fit().ok()?.start;
    // The extent by the rule of the default.
    fitter.set_options(Case::default().options).ok()?;
    frame.errors(&fitter, &start).ok()
}

fn paper_options() -> Options {
    Options { objective: ObjectiveKind::Paper, ..Case::default().options }
}

pub fn methods(sets: &Sets) {
    let alone = |method| Options { method, ..Case::default().options };
    let paper = Case { image: false, options: paper_options(), ..Case::default() };
    let robust = Case::default();
    let rows = [
        ("paper, w_L = 0.6", paper),
        ("points, w_L = 0", Case { options: alone(Method::Points), ..paper }),
        ("RANSAC", Case { options: alone(Method::Ransac), ..paper }),
        ("Eberly", Case { options: alone(Method::Eberly), ..paper }),
        ("robust with image", robust),
        ("robust", Case { image: false, ..robust }),
        ("robust, no edges", Case { edges: Edges::None, ..robust }),
        ("robust, mask alone", Case { edges: Edges::None, image: false, ..robust }),
        ("robust, points alone", Case { edges: Edges::None, image: false, mask: false, ..robust }),
    ];
    for (set, frames) in
        [("frames/paper", &sets.paper), ("frames/wild", &sets.wild), ("frames/repeat", &sets.repeat)]
    {
        if frames.is_empty() {
            continue;
        }
        print_head(&format!("{set}: {} frames, all methods", frames.len()));
        for (name, case) in rows {
            print_row(name, &fit_all(sets, name, frames, &case), &[Target::NONE; 4]);
        }
    }
}

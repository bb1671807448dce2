//! Masks of whole objects: caps, lids, rims, inner walls and things in front are in the mask.

use crate::Sets;
use crate::frame::{Case, Edges, Frame};
use crate::parallel::map;
use crate::table::{Target, print_head, print_row, print_targets};
use cylfuse::error::Error;
use cylfuse::fitter::FitResult;

/// What a chi-square of five degrees of freedom, and a normal deviation, exceed once in 20 times.
const REGION: f64 = 11.070;
const INTERVAL: f64 = 1.960;

/// What a fit to one frame gave.
struct Outcome {
    /// E_o (degrees), E_p (mm), E_r (%), E_l (%); NaN where the truth is not known.
    errors: [f64; 4],
    /// Whether the 95 % regions hold all five numbers, the radius, and the length where it is known.
    held: [Option<bool>; 3],
    text: String,
}

fn outcome(frame: &Frame, case: &Case) -> Result<Outcome, Error> {
    let mut fitter = frame.fitter(case);
    fitter.set_options(case.options)?;
    let result: FitResult = fitter.fit()?;
    let extent = fitter.extent(None, None)?;
    let difference = frame.truth.compare(&result.cylinder);
    let length = frame.length.filter(|_| frame.ends_seen);
    let errors = [
        difference.angle.to_degrees(),
        if frame.ends_seen { (extent.center - frame.truth.axis.point).norm() * 1e3 } else { f64::NAN },
        difference.radius_relative.abs() * 100.0,
        length.map_or(f64::NAN, |length| (extent.length / length - 1.0).abs() * 100.0),
    ];
    // A fit that does not know its uncertainty holds no truth.
    let of_fit = result.uncertainty.as_ref();
    let held =
        [
            Some(of_fit.is_some_and(|u| u.squared_distance(&frame.truth) <= REGION)),
            Some(of_fit.is_some_and(|u| {
                (result.cylinder.radius - frame.truth.radius).abs() <= INTERVAL * u.radius()
            })),
            length.map(|length| {
                extent.uncertainty.is_some_and(|u| (extent.length - length).abs() <= INTERVAL * u.length)
            }),
        ];
    let deviation = of_fit.map_or(f64::NAN, |u| u.radius() / frame.truth.radius * 100.0);
    let limbs = fitter.limbs().map_or(0, |limbs| limbs.iter().filter(|limb| limb.line.is_ok()).count());
    // The ends in the order of the true axis, by how far they lie outside of the true ones.
    let [mut first, mut last] = [
        (extent.start, extent.start_state, extent.start_source),
        (extent.end, extent.end_state, extent.end_source),
    ];
    let along = |p: &nalgebra::Vector3<f64>| frame.truth.axis.position_of(p);
    if along(&first.0) > along(&last.0) {
        std::mem::swap(&mut first, &mut last);
    }
    let half = 0.5 * frame.length.unwrap_or(f64::NAN);
    let text = format!(
        "σ_r {deviation:5.2} % limbs {limbs} used {} ends {:+6.1} {:?} {:?}, {:+6.1} {:?} {:?} {:?}",
        result.limbs_located,
        (-half - along(&first.0)) * 1e3,
        first.1,
        first.2,
        (along(&last.0) - half) * 1e3,
        last.1,
        last.2,
        result.flags,
    );
    Ok(Outcome { errors, held, text })
}

type Outcomes = Vec<Option<Outcome>>;

fn fit_all(sets: &Sets, title: &str, frames: &[Frame], case: &Case) -> Outcomes {
    let all: Outcomes = map(frames, |frame| outcome(frame, case).ok());
    for (frame, outcome) in frames.iter().zip(&all).filter(|_| sets.list) {
        let text = outcome.as_ref().map_or("failed".into(), |outcome| {
            let errors = outcome.errors.map(|error| format!("{error:8.3}")).join(" ");
            format!("{errors} {}", outcome.text)
        });
        eprintln!("{title:16} {:20} {text}", frame.name);
    }
    all
}

fn print(title: &str, all: &[&Option<Outcome>], targets: &[Target; 4]) {
    let errors: Vec<_> = all.iter().map(|outcome| outcome.as_ref().map(|outcome| outcome.errors)).collect();
    print_row(title, &errors, targets);
    let [region, radius, length] = [0, 1, 2].map(|k| {
        let known: Vec<bool> = all.iter().filter_map(|outcome| outcome.as_ref()?.held[k]).collect();
        100.0 * known.iter().filter(|held| **held).count() as f64 / known.len().max(1) as f64
    });
    println!(
        "| {title}, held (%) | all five: {region:.0} | | radius: {radius:.0} | length: {length:.0} | | |"
    );
}

/// Masks that cover the whole object, without edges; the frames of even and of odd number apart, too.
pub fn objects(sets: &Sets) {
    let with_image = [
        Target { median: 0.20, ninety: 0.8, worst: 5.0, ..Target::NONE },
        Target { median: 0.6, ninety: 2.0, ..Target::NONE },
        Target { median: 0.30, ninety: 1.5, worst: 5.0, ..Target::NONE },
        Target { median: 0.6, ninety: 3.0, ..Target::NONE },
    ];
    let without_image = [
        Target { ninety: 1.5, ..Target::NONE },
        Target::NONE,
        Target { median: 2.0, ninety: 6.0, ..Target::NONE },
        Target { median: 2.0, ninety: 6.0, ..Target::NONE },
    ];
    for (image, targets) in [(true, with_image), (false, without_image)] {
        let name = if image { "image and mask" } else { "mask alone" };
        print_head(&format!("objects, {name}"));
        print_targets(&targets);
        let case = Case { edges: Edges::None, image, ..Case::default() };
        let all = fit_all(sets, name, &sets.objects, &case);
        let half = |odd: usize| all.iter().skip(odd).step_by(2).collect::<Vec<_>>();
        print(&format!("{name}, even"), &half(0), &targets);
        print(&format!("{name}, odd"), &half(1), &targets);
        print(name, &all.iter().collect::<Vec<_>>(), &targets);
    }
    print_head("objects, mask of the pixels that have depth");
    for (image, name) in [(true, "image and mask"), (false, "mask alone")] {
        let case = Case { edges: Edges::None, image, of_depth: true, ..Case::default() };
        let all = fit_all(sets, name, &sets.objects, &case);
        print(name, &all.iter().collect::<Vec<_>>(), &[Target::NONE; 4]);
    }
    print_head("real2, mask of the whole object");
    for (image, name) in [(true, "image and mask"), (false, "mask alone")] {
        let case = Case { edges: Edges::None, image, ..Case::default() };
        let all = fit_all(sets, name, &sets.real2, &case);
        print(name, &all.iter().collect::<Vec<_>>(), &[Target::NONE; 4]);
    }
}

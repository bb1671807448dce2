//! Fits to points alone that may lie on more than one surface, or on none of a cylinder, as a table:
//! `cargo run --release --example surfaces`; `-- wall flange` those whose names contain one of the words. `-- search` in place of fits what a
//! search of the cloud finds.
//!
//! With the feature `sensitivity`, words of names of constants as arguments (`-- points_alone::`) print how the results change when
//! each of them is 20 % smaller or larger.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/parallel.rs"]
mod parallel;
#[cfg(feature = "sensitivity")]
mod scaled;
#[path = "../tests/support/mod.rs"]
mod support;

use cylfuse::fitter::{FitResult, Flags, Uncertainty};
use cylfuse::observations::PointsView;
use cylfuse::scene::Detector;
use nalgebra::{Rotation3, Vector3};
use parallel::map;
use std::f64::consts::PI;
use support::{Noise, fitter_with};

/// Clouds of each kind, every second one in the frame of its sensor, the others moved.
const CLOUDS: u64 = 16;

/// Points of a cloud.
const POINTS: usize = 3000;

/// How far the sensor is from the axis, in radii of the body.
const DISTANCE: f64 = 6.0;

type Points = Vec<Vector3<f64>>;

/// Clouds of one kind. The body that is asked for has radius 1, the axis z, and turns its side at x = 1 to the sensor.
struct Kind {
    name: String,
    /// Whether there is such a body.
    has_body: bool,
    make: Box<dyn Fn(&mut Noise) -> Points + Sync>,
}

/// A number from −1 to 1.
fn between(noise: &mut Noise) -> f64 {
    2.0 * noise.uniform() - 1.0
}

/// Points whose distance from the axis, by the angle and the place along it, is `radius`: on an arc about x, 4 long.
fn round(
    noise: &mut Noise,
    count: usize,
    degrees: f64,
    radius: impl Fn(f64, f64, &mut Noise) -> f64,
) -> Points {
    let point = |_| {
        let (angle, z) = (degrees.to_radians() / 2.0 * between(noise), 2.0 * between(noise));
        let radius = radius(angle, z, noise);
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z)
    };
    (0..count).map(point).collect()
}

/// Points of a cylinder with noise, as a part of the radius.
fn arc(noise: &mut Noise, count: usize, degrees: f64, deviation: f64) -> Points {
    round(noise, count, degrees, |_, _, noise| 1.0 + deviation * noise.normal())
}

/// Points of the part of a plane across an axis of coordinates, with noise of 0.01.
fn plane(noise: &mut Noise, count: usize, across: usize, middle: [f64; 3], half: [f64; 3]) -> Points {
    let point = |_| {
        let mut point = Vector3::from_fn(|k, _| middle[k] + half[k] * between(noise));
        point[across] = middle[across] + 0.01 * noise.normal();
        point
    };
    (0..count).map(point).collect()
}

/// Points of a ring about z, with noise of 0.01.
fn ring(noise: &mut Noise, count: usize, degrees: f64, z: f64, outer: f64) -> Points {
    let point = |_| {
        let angle = degrees.to_radians() / 2.0 * between(noise);
        let radius = 1.0 + (outer - 1.0) * noise.uniform();
        Vector3::new(radius * angle.cos(), radius * angle.sin(), z + 0.01 * noise.normal())
    };
    (0..count).map(point).collect()
}

/// Points of something beside an arc of a body.
fn beside(noise: &mut Noise, what: &str, count: usize, degrees: f64) -> Points {
    match what {
        "wall behind" => plane(noise, count, 0, [-1.2, 0.0, 0.0], [0.0, 3.0, 2.0]),
        "strip far behind" => plane(noise, count, 0, [-8.0, 3.0, 0.0], [0.0, 0.6, 3.0]),
        "wall to the side" => plane(noise, count, 1, [0.0, 1.2, 0.0], [1.5, 0.0, 2.0]),
        "floor it lies on" => plane(noise, count, 1, [0.0, -1.0, 0.0], [1.5, 0.0, 2.0]),
        "ground at its foot" => ring(noise, count, 180.0, -2.0, 3.0),
        "flange" => ring(noise, count, degrees, 2.0, 1.6),
        _ => {
            let mut points = arc(noise, count, degrees, 0.01);
            points.iter_mut().for_each(|point| point.y += 2.2);
            points
        }
    }
}

fn kinds() -> Vec<Kind> {
    let mut kinds = Vec::new();
    let mut add = |name: String, has_body: bool, make: Box<dyn Fn(&mut Noise) -> Points + Sync>| {
        kinds.push(Kind { name, has_body, make });
    };
    for (degrees, deviation) in [(60.0, 0.01), (150.0, 0.01), (360.0, 0.01), (150.0, 0.06), (360.0, 0.06)] {
        let name = format!("{degrees}° alone, noise of {} %", 100.0 * deviation);
        add(name, true, Box::new(move |noise| arc(noise, POINTS, degrees, deviation)));
    }
    let heavy = |_, _, noise: &mut Noise| {
        // Student's t of two degrees of freedom.
        1.0 + 0.02 * noise.normal() / (1.0 - noise.uniform()).ln().abs().sqrt()
    };
    add("150° alone, heavy tails".into(), true, Box::new(move |noise| round(noise, POINTS, 150.0, heavy)));
    let outliers = |noise: &mut Noise| {
        let mut points = arc(noise, POINTS * 7 / 10, 150.0, 0.01);
        let stray = |_| {
            Vector3::new(between(noise), between(noise), between(noise))
                .component_mul(&Vector3::new(2.0, 2.0, 4.0))
        };
        points.extend((0..POINTS * 3 / 10).map(stray));
        points
    };
    add("150°, outliers 30 %".into(), true, Box::new(outliers));
    for what in [
        "wall behind",
        "strip far behind",
        "wall to the side",
        "floor it lies on",
        "ground at its foot",
        "flange",
        "pipe of the same size",
    ] {
        for degrees in [60.0, 150.0] {
            for percent in [30, 50, 60] {
                let others = POINTS * percent / 100;
                let make = move |noise: &mut Noise| {
                    let mut points = arc(noise, POINTS - others, degrees, 0.01);
                    points.extend(beside(noise, what, others, degrees));
                    points
                };
                add(format!("{degrees}°, {what} {percent} %"), true, Box::new(make));
            }
        }
    }
    for (what, of_step) in [
        ("a shaft with a step", 0.8),
        ("a shaft with a step of 5 %", 0.95),
        ("a collar of a third of the length", 1.3),
    ] {
        let radius = move |_, z: f64, noise: &mut Noise| {
            let of_place = if z > 0.66 { of_step } else { 1.0 };
            of_place + 0.01 * noise.normal()
        };
        add(format!("150°, {what}"), true, Box::new(move |noise| round(noise, POINTS, 150.0, radius)));
    }
    for (degrees, oval) in [(360.0, 0.03), (180.0, 0.03), (360.0, 0.12), (180.0, 0.12)] {
        let radius =
            move |angle: f64, _, noise: &mut Noise| 1.0 + oval * (2.0 * angle).cos() + 0.005 * noise.normal();
        let make = move |noise: &mut Noise| {
            let mut points = round(noise, POINTS * 17 / 20, degrees, radius);
            points.extend(ring(noise, POINTS * 3 / 20, degrees, -2.0, 2.5));
            points
        };
        add(format!("{degrees}°, oval by {} %, on the ground", 100.0 * oval), oval < 0.1, Box::new(make));
    }
    for taper in [0.03, 0.12] {
        let radius = move |_, z: f64, noise: &mut Noise| 1.0 - taper * z + 0.01 * noise.normal();
        let name = format!("150°, tapers by {} % a radius", 100.0 * taper);
        add(name, taper < 0.1, Box::new(move |noise| round(noise, POINTS, 150.0, radius)));
    }
    let cone = |_, z: f64, noise: &mut Noise| 0.5 * (z + 2.5) + 0.01 * noise.normal();
    add("cone".into(), false, Box::new(move |noise| round(noise, POINTS, 150.0, cone)));
    let prism = |angle: f64, _, noise: &mut Noise| {
        let beside_edge = (angle.rem_euclid(PI / 3.0)) - PI / 6.0;
        (PI / 6.0).cos() / beside_edge.cos() + 0.01 * noise.normal()
    };
    add("prism of six sides".into(), false, Box::new(move |noise| round(noise, POINTS, 360.0, prism)));
    let ball = |noise: &mut Noise| {
        let point = |_| noise.vector().normalize() * (1.0 + 0.01 * noise.normal());
        (0..POINTS).map(point).collect()
    };
    add("sphere".into(), false, Box::new(ball));
    let corner = |noise: &mut Noise| {
        let mut points = plane(noise, POINTS / 2, 0, [0.0; 3], [0.0, 1.0, 1.0]);
        points.extend(plane(noise, POINTS / 2, 1, [1.0, 1.0, 0.0], [1.0, 0.0, 1.0]));
        points
    };
    add("two sides of a box".into(), false, Box::new(corner));
    kinds
}

/// What is asked of a cloud.
#[derive(Clone, Copy)]
enum Measure {
    Fit,
    /// The cylinder that a search finds whose radius is best.
    Search,
}

/// What a fit to a cloud came to.
struct Outcome {
    /// Error of the radius and its stated deviation (%); infinite where the fit failed.
    error: f64,
    stated: f64,
    warned: bool,
}

impl Outcome {
    const NONE: Self = Self { error: f64::INFINITY, stated: f64::INFINITY, warned: true };

    fn of(fit: &FitResult) -> Self {
        let stated = fit.uncertainty.as_ref().map_or(f64::INFINITY, Uncertainty::radius);
        Self {
            error: 100.0 * (fit.cylinder.radius - 1.0).abs(),
            stated: 100.0 * stated,
            warned: fit.flags.intersects(Flags::POOR_FIT | Flags::WEAK_RADIUS | Flags::UNCERTAINTY_UNKNOWN),
        }
    }

    /// Whether the radius is wrong by three stated deviations, or there is none, and nothing says so.
    fn is_silent(&self, has_body: bool) -> bool {
        !self.warned && (!has_body || self.error > 3.0 * self.stated)
    }
}

fn outcome(kind: &Kind, seed: u64, measure: Measure) -> Outcome {
    let noise = &mut Noise::new(seed);
    let mut points = (kind.make)(noise);
    points.iter_mut().for_each(|point| point.x -= DISTANCE);
    if seed % 2 == 1 {
        let turn = Rotation3::new(noise.vector());
        let shift = 5.0 * noise.vector();
        points.iter_mut().for_each(|point| *point = turn * *point + shift);
    }
    let points: Vec<[f64; 3]> = points.into_iter().map(Into::into).collect();
    match measure {
        Measure::Fit => fitter_with(&points).fit().map_or(Outcome::NONE, |fit| Outcome::of(&fit)),
        Measure::Search => {
            let scene = Detector::new().detect_points(&PointsView::from_f64(&points)).unwrap();
            let found = scene.cylinders.iter().map(|found| Outcome::of(&found.result));
            found.min_by(|a, b| a.error.total_cmp(&b.error)).unwrap_or(Outcome::NONE)
        }
    }
}

/// The outcomes of all clouds of each kind.
fn outcomes(kinds: &[Kind], measure: Measure) -> Vec<Vec<Outcome>> {
    let clouds: Vec<(usize, u64)> =
        (0..kinds.len()).flat_map(|k| (0..CLOUDS).map(move |seed| (k, seed))).collect();
    let mut all = map(&clouds, |&(k, seed)| outcome(&kinds[k], seed, measure)).into_iter();
    kinds.iter().map(|_| all.by_ref().take(CLOUDS as usize).collect()).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn count(outcomes: &[Outcome], is_meant: impl Fn(&Outcome) -> bool) -> usize {
    outcomes.iter().filter(|outcome| is_meant(outcome)).count()
}

fn print(kinds: &[Kind], measure: Measure) {
    println!("{CLOUDS} clouds of {POINTS} points each.\n");
    println!("| points | E_r median (%) | worst | stated, median (%) | silently wrong | with a warning |");
    println!("|---|---|---|---|---|---|");
    for (kind, outcomes) in kinds.iter().zip(outcomes(kinds, measure)) {
        let errors: Vec<f64> = outcomes.iter().map(|outcome| outcome.error).collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        let numbers = match kind.has_body {
            true => {
                let stated = median(outcomes.iter().map(|outcome| outcome.stated).collect());
                format!("{:.2} | {worst:.2} | {stated:.2}", median(errors))
            }
            false => "– | – | –".into(),
        };
        let silent = count(&outcomes, |outcome| outcome.is_silent(kind.has_body));
        let warned = count(&outcomes, |outcome| outcome.warned);
        println!("| {} | {numbers} | {silent} | {warned} |", kind.name);
    }
}

/// Over all kinds: the mean of E_r where there is a body, no error counting for more than 100 %; how many clouds are silently wrong; how
/// many have a warning, with a body and without.
#[cfg(feature = "sensitivity")]
fn summary(kinds: &[Kind]) -> [f64; 4] {
    let (mut sums, mut bodies) = ([0.0; 4], 0.0);
    for (kind, outcomes) in kinds.iter().zip(outcomes(kinds, Measure::Fit)) {
        let warned = count(&outcomes, |outcome| outcome.warned) as f64;
        sums[1] += count(&outcomes, |outcome| outcome.is_silent(kind.has_body)) as f64;
        sums[if kind.has_body { 2 } else { 3 }] += warned;
        if kind.has_body {
            sums[0] += outcomes.iter().map(|outcome| outcome.error.min(100.0)).sum::<f64>();
            bodies += outcomes.len() as f64;
        }
    }
    sums[0] /= bodies;
    sums
}

#[cfg(feature = "sensitivity")]
fn print_changes(kinds: &[Kind], words: &[String]) {
    let constants = scaled::constants(cylfuse::fitter::constants(), words);
    let shown =
        |[error, silent, bodies, others]: [f64; 4]| format!("{error:.3} | {silent} | {bodies} | {others}");
    println!(
        "| constant | value | unit | factor | E_r mean (%) | silently wrong | warnings: bodies | others |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    println!("| none | | | 1 | {} |", shown(summary(kinds)));
    for constant in constants {
        for factor in [0.8, 1.2] {
            let after = scaled::with_scaled(constant, factor, || summary(kinds));
            println!("{}", scaled::row(&constant, &[factor.to_string(), shown(after)]));
        }
    }
}

fn main() {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let searches = words.iter().position(|word| word == "search").map(|k| words.remove(k)).is_some();
    let mut kinds = kinds();
    #[cfg(feature = "sensitivity")]
    if !words.is_empty() {
        return print_changes(&kinds, &words);
    }
    kinds.retain(|kind| words.is_empty() || words.iter().any(|word| kind.name.contains(word)));
    print(&kinds, if searches { Measure::Search } else { Measure::Fit });
}

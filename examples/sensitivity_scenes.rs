//! How much each judged constant of the detection of whole scenes matters: how many cylinders are found, rightly and wrongly, in
//! scenes of the twin, with the image and by depth alone, when it is 20 % smaller or larger.
//! `cargo run --release --features twin,sensitivity --example sensitivity_scenes` prints all that scenes reach as a table, which
//! takes two hours on one core; `-- score:: REACH` those whose names contain one of the words, `-- --image 4 --depth 2` in every
//! fourth scene with the image and in every second one by depth, 0 for none, `-- --seeds 9001` in scenes from another seed on,
//! `-- --noise 1` in the same scenes with other noise, `-- --factors 0.5,2` by other factors.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/parallel.rs"]
mod parallel;
#[path = "scenes/taken.rs"]
mod taken;
#[allow(dead_code, reason = "shared with the command bench, which uses all of it")]
#[path = "../src/bin/cylfuse/bench/experiments/truths.rs"]
mod truths;

use cylfuse::constant::Constant;
use cylfuse::detection::{DetectionOptions, Detections, detect};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::Frame;
use cylfuse::scene::{Detector, DetectorOptions};
use cylfuse::twin::{DepthSensor, Kind, StructuredLight};
use taken::taken;
use truths::{Hits, Truths};

/// Kinds of scenes, and how many of each.
const KINDS: [(Kind, u64); 3] = [(Kind::Table, 24), (Kind::Pipes, 12), (Kind::NoCylinders, 6)];

/// What no frame of a whole scene reaches: clouds, and masks.
const ELSEWHERE: [&str; 4] = ["::cloud::", "::regions::", "::region::", "::caps::"];

/// What counts after the search as well: where it finds the same as before, the rest is not the same for that.
const AFTER_SEARCH: [&str; 4] = ["::score::", "::scene::", "::limb_pairs::", "::LIMBS_TURN"];

/// The least score of a search: less than the least before a fit that leads to anything.
const LEAST_SCORE: f64 = 0.02;

/// What to measure.
struct Arguments {
    words: Vec<String>,
    /// Of the scenes every how many are looked at with the image, and by depth alone; 0 for none.
    every: [usize; 2],
    seeds: u64,
    noise: u64,
    factors: [f64; 2],
}

impl Arguments {
    fn read() -> Self {
        let mut read = Self { words: Vec::new(), every: [1; 2], seeds: 8001, noise: 0, factors: [0.8, 1.2] };
        let mut arguments = std::env::args().skip(1);
        while let Some(argument) = arguments.next() {
            let mut number = || arguments.next().expect("an option takes a number");
            match argument.as_str() {
                "--image" => read.every[0] = number().parse().unwrap(),
                "--depth" => read.every[1] = number().parse().unwrap(),
                "--seeds" => read.seeds = number().parse().unwrap(),
                "--noise" => read.noise = number().parse().unwrap(),
                "--factors" => {
                    let factors: Vec<f64> =
                        number().split(',').map(|factor| factor.parse().unwrap()).collect();
                    read.factors = factors.try_into().expect("--factors takes two numbers");
                }
                _ => read.words.push(argument),
            }
        }
        read
    }

    /// Whether a scene is looked at, with the image or by depth alone.
    fn asks(&self, index: usize, use_image: bool) -> bool {
        let every = self.every[usize::from(!use_image)];
        every > 0 && index.is_multiple_of(every)
    }

    /// The scenes that are looked at, by their numbers.
    fn scenes(&self) -> Vec<(usize, Frame, Truths)> {
        let light = DepthSensor::StructuredLight(StructuredLight::default());
        let all = KINDS.into_iter().flat_map(|(kind, count)| (0..count).map(move |k| (kind, k)));
        let jobs: Vec<_> = all
            .enumerate()
            .filter(|(index, _)| [true, false].iter().any(|how| self.asks(*index, *how)))
            .collect();
        parallel::map(&jobs, |(index, (kind, k))| {
            let seed = self.seeds + k;
            let (frame, truths) = taken(*kind, light, seed, seed + 1000 * self.noise);
            (*index, frame, truths)
        })
    }

    fn constants(&self) -> Vec<Constant> {
        let mut constants = [cylfuse::detection::constants(), cylfuse::scene::constants()].concat();
        constants.retain(|constant| match self.words.as_slice() {
            [] => !ELSEWHERE.iter().any(|word| constant.name.contains(word)),
            words => words.iter().any(|word| constant.name.contains(word)),
        });
        constants
    }
}

/// A scene and how it is looked at.
struct Case<'a> {
    frame: &'a Frame,
    truths: &'a Truths,
    use_image: bool,
}

impl Case<'_> {
    /// What the search finds.
    fn search(&self) -> Detections {
        let search = DetectionOptions { min_score: LEAST_SCORE, ..DetectionOptions::default() };
        let image = self.frame.image().filter(|_| self.use_image);
        detect(self.frame.camera().unwrap(), self.frame.depth_on_image().unwrap(), image, &search).unwrap()
    }

    /// What is found after the fits.
    fn detect(&self) -> Vec<Cylinder> {
        let use_image = self.use_image;
        let mut detector = Detector::new();
        detector.set_options(DetectorOptions { use_image, ..DetectorOptions::default() }).unwrap();
        detector.detect(self.frame).unwrap().cylinders.iter().map(|found| found.result.cylinder).collect()
    }
}

/// What is found in a scene by the constants as they are.
struct Baseline<'a> {
    case: Case<'a>,
    seen: Detections,
    found: Vec<Cylinder>,
}

impl<'a> Baseline<'a> {
    fn new(case: Case<'a>) -> Self {
        Self { seen: case.search(), found: case.detect(), case }
    }

    /// What is found with a constant that is scaled now: what takes most of the time is left where nothing can have changed.
    fn again(&self, constant: &Constant) -> Vec<Cylinder> {
        let is_same = |seen: &Detections| {
            (&seen.cylinders, &seen.labels, seen.shift)
                == (&self.seen.cylinders, &self.seen.labels, self.seen.shift)
        };
        match AFTER_SEARCH.iter().any(|word| constant.name.contains(word)) || !is_same(&self.case.search()) {
            true => self.case.detect(),
            false => self.found.clone(),
        }
    }
}

/// What was found in all scenes, and how that compares with what is there.
struct Outcome {
    found: Vec<Vec<Cylinder>>,
    hits: Hits,
}

impl Outcome {
    fn new(cases: &[Baseline<'_>], found: Vec<Vec<Cylinder>>) -> Self {
        let hits: Vec<Hits> =
            cases.iter().zip(&found).map(|(baseline, found)| baseline.case.truths.score(found)).collect();
        Self { found, hits: Hits::together(&hits) }
    }

    /// The mean error of the radius of what was found rightly, in %.
    fn radius(&self) -> f64 {
        self.hits.found.iter().map(|[_, radius]| radius).sum::<f64>() / self.hits.found.len() as f64
    }

    /// What changed since another one: right, wrong, the error of the radius in %; "·" where all is the same to the last bit.
    fn changes(&self, before: &Self) -> [String; 3] {
        if self.found == before.found {
            return ["·", "·", "·"].map(String::from);
        }
        let change = |after: usize, before: usize| match after as i64 - before as i64 {
            0 => "0".into(),
            change => format!("{change:+}"),
        };
        let radius = (self.radius() / before.radius() - 1.0) * 100.0;
        [
            change(self.hits.found.len(), before.hits.found.len()),
            change(self.hits.wrong, before.hits.wrong),
            format!("{radius:+.0}"),
        ]
    }
}

/// What was found with a constant that is so many times as large.
fn scaled(cases: &[Vec<Baseline<'_>>; 2], constant: Constant, factor: f64) -> [Outcome; 2] {
    constant.scale(factor);
    let outcomes = cases.each_ref().map(|cases| {
        let found = parallel::map(cases, |baseline| baseline.again(&constant));
        Outcome::new(cases, found)
    });
    Constant::reset();
    outcomes
}

/// Whether what was found is the same to the last bit.
fn is_same(before: &[Outcome; 2], after: &[Outcome; 2]) -> bool {
    before.iter().zip(after).all(|(before, after)| before.found == after.found)
}

fn short(constant: &Constant) -> &'static str {
    constant.name.trim_start_matches("cylfuse::")
}

fn main() {
    let arguments = Arguments::read();
    let scenes = arguments.scenes();
    let cases = [true, false].map(|use_image| {
        let some = scenes.iter().filter(|(index, ..)| arguments.asks(*index, use_image));
        let cases: Vec<_> = some.collect();
        parallel::map(&cases, |(_, frame, truths)| Baseline::new(Case { frame, truths, use_image }))
    });
    let before = cases.each_ref().map(|cases| {
        let found = cases.iter().map(|baseline| baseline.found.clone());
        Outcome::new(cases, found.collect())
    });
    for ((outcome, cases), how) in before.iter().zip(&cases).zip(["with the image", "by depth alone"]) {
        let Hits { found, missed, wrong } = &outcome.hits;
        let all = found.len() + missed;
        println!(
            "{} scenes {how}: {} of {all} found, {wrong} wrong, mean E_r {:.2} %",
            cases.len(),
            found.len(),
            outcome.radius()
        );
    }
    let constants = arguments.constants();
    if constants.is_empty() {
        return;
    }
    let [less, more] = arguments.factors;
    println!("\nChanges, constant × {less} / × {more}\n");
    println!("| constant | value | unit | image: right | wrong | E_r (%) | depth: right | wrong | E_r (%) |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut idle = Vec::new();
    for constant in constants {
        let [less, more] = arguments.factors.map(|factor| scaled(&cases, constant, factor));
        if is_same(&before, &less) && is_same(&before, &more) {
            idle.push(constant);
            continue;
        }
        let columns = (0..2).flat_map(|k| {
            let (less, more) = (less[k].changes(&before[k]), more[k].changes(&before[k]));
            less.into_iter().zip(more).map(|(less, more)| format!("{less} / {more}"))
        });
        let columns: Vec<String> = columns.collect();
        println!(
            "| {} | {} | {} | {} |",
            short(&constant),
            constant.value,
            constant.unit,
            columns.join(" | ")
        );
    }
    let names = |constants: &[Constant]| constants.iter().map(short).collect::<Vec<_>>().join(", ");
    println!("\nNo change to the last bit: {}", names(&idle));
    idle.retain(|constant| {
        [0.5, 2.0].into_iter().all(|factor| is_same(&before, &scaled(&cases, *constant, factor)))
    });
    println!("\nNor × 0.5 / × 2: {}", names(&idle));
}

//! How much each judged constant of the detection of whole scenes matters: how many cylinders are found, rightly and wrongly, in
//! scenes of the twin, with the image and by depth alone, when it is 20 % smaller or larger.
//! `cargo run --release --features twin,sensitivity --example sensitivity_scenes` prints all that scenes reach as a table, which
//! takes two hours on one core; `-- score:: REACH` those whose names contain one of the words, `-- --image 4 --depth 2` in every
//! fourth scene with the image and in every second one by depth, 0 for none (there are no columns for these then), `-- --seeds 9001` in scenes from another seed on,
//! `-- --noise 1` in the same scenes with other noise, `-- --factors 0.5,2` by other factors.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/parallel.rs"]
mod parallel;
mod scaled;
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
use scaled::{name, row, with_scaled};
use taken::capture_frame;
use truths::{Hits, Truths};

/// Kinds of scenes, and how many of each.
const KINDS: [(Kind, u64); 3] = [(Kind::Table, 24), (Kind::Pipes, 12), (Kind::NoCylinders, 6)];

/// What no frame of a whole scene reaches: clouds, and masks.
const ELSEWHERE: [&str; 4] = ["::cloud::", "::regions::", "::region::", "::caps::"];

/// What counts after the search as well: where it finds the same as before, the rest is not the same for that.
const AFTER_SEARCH: [&str; 5] = ["::score::", "::scene::", "::limb_pairs::", "::edges::", "::LIMBS_TURN"];

/// How scenes are looked at.
const HOW: [&str; 2] = ["with the image", "by depth alone"];

/// The mean error of the radius changes by this much or more, in %, where a constant matters, though the same number is found.
const MATTERS: f64 = 3.0;

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
        assert!(read.every != [0; 2], "nothing is looked at: --image or --depth has to be more than 0");
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
            let (frame, truths) = capture_frame(*kind, light, seed, seed + 1000 * self.noise);
            (*index, frame, truths)
        })
    }

    fn constants(&self) -> Vec<Constant> {
        let mut all = [cylfuse::detection::constants(), cylfuse::scene::constants()].concat();
        if self.words.is_empty() {
            all.retain(|constant| !ELSEWHERE.iter().any(|word| constant.name.contains(word)));
        }
        scaled::constants(all, &self.words)
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

    /// What changed since another one; `None` where all is the same to the last bit.
    fn change(&self, before: &Self) -> Option<Change> {
        (self.found != before.found).then(|| Change {
            right: self.hits.found.len() as i64 - before.hits.found.len() as i64,
            wrong: self.hits.wrong as i64 - before.hits.wrong as i64,
            radius: (self.radius() / before.radius() - 1.0) * 100.0,
        })
    }
}

/// How many more are found rightly and wrongly, and by how much the mean error of the radius changes, in %.
struct Change {
    right: i64,
    wrong: i64,
    radius: f64,
}

impl Change {
    fn matters(&self) -> bool {
        self.right != 0 || self.wrong != 0 || !(self.radius.round().abs() < MATTERS)
    }

    /// As columns.
    fn shown(change: Option<&Self>) -> [String; 3] {
        let signed = |number: i64| if number == 0 { "0".into() } else { format!("{number:+}") };
        match change {
            None => ["·", "·", "·"].map(String::from),
            Some(Self { right, wrong, radius }) => [signed(*right), signed(*wrong), format!("{radius:+.0}")],
        }
    }
}

/// The scenes that are looked at in one way, and what is found in them by the constants as they are.
struct Look<'a> {
    how: &'static str,
    cases: Vec<Baseline<'a>>,
    before: Outcome,
}

impl<'a> Look<'a> {
    /// `None` where no scene is looked at in this way.
    fn new(arguments: &Arguments, scenes: &'a [(usize, Frame, Truths)], how: &'static str) -> Option<Self> {
        let use_image = how == HOW[0];
        let some: Vec<_> = scenes.iter().filter(|(index, ..)| arguments.asks(*index, use_image)).collect();
        let cases =
            parallel::map(&some, |(_, frame, truths)| Baseline::new(Case { frame, truths, use_image }));
        let found = cases.iter().map(|baseline| baseline.found.clone()).collect();
        let before = Outcome::new(&cases, found);
        (!cases.is_empty()).then_some(Self { how, cases, before })
    }

    fn print(&self) {
        let Hits { found, missed, wrong } = &self.before.hits;
        let (count, all, radius) = (self.cases.len(), found.len() + missed, self.before.radius());
        let (how, found) = (self.how, found.len());
        println!("{count} scenes {how}: {found} of {all} found, {wrong} wrong, mean E_r {radius:.2} %");
    }

    /// What changes with a constant that is scaled now.
    fn change(&self, constant: &Constant) -> Option<Change> {
        let found = parallel::map(&self.cases, |baseline| baseline.again(constant));
        Outcome::new(&self.cases, found).change(&self.before)
    }
}

/// What changes with a constant that is so many times as large, by the way of looking.
fn changes(looks: &[Look<'_>], constant: Constant, factor: f64) -> Vec<Option<Change>> {
    with_scaled(constant, factor, || looks.iter().map(|look| look.change(&constant)).collect())
}

/// Prints the rows of those that matter, and returns which change something all the same, and which nothing.
fn print_rows(looks: &[Look<'_>], constants: &[Constant], factors: [f64; 2]) -> [Vec<Constant>; 2] {
    let [mut slight, mut idle] = [Vec::new(), Vec::new()];
    for constant in constants {
        let [less, more] = factors.map(|factor| changes(looks, *constant, factor));
        let mut all = less.iter().chain(&more).flatten().peekable();
        if all.peek().is_none() {
            idle.push(*constant);
        } else if all.any(Change::matters) {
            let columns = less.iter().zip(&more).flat_map(|(less, more)| {
                let [less, more] = [less, more].map(|change| Change::shown(change.as_ref()));
                less.into_iter().zip(more).map(|(less, more)| format!("{less} / {more}"))
            });
            println!("{}", row(constant, &columns.collect::<Vec<_>>()));
        } else {
            slight.push(*constant);
        }
    }
    [slight, idle]
}

fn main() {
    let arguments = Arguments::read();
    let constants = arguments.constants();
    let scenes = arguments.scenes();
    let looks: Vec<Look<'_>> = HOW.iter().filter_map(|how| Look::new(&arguments, &scenes, how)).collect();
    looks.iter().for_each(Look::print);
    let [less, more] = arguments.factors;
    println!("\nChanges, constant × {less} / × {more}; E_r: relative change of its mean\n");
    let columns = looks.iter().map(|look| format!("{}: right | wrong | E_r (%) |", look.how));
    println!("| constant | value | unit | {}", columns.collect::<Vec<_>>().join(" "));
    println!("|---|---|---|{}", "---|---|---|".repeat(looks.len()));
    let [slight, mut idle] = print_rows(&looks, &constants, arguments.factors);
    let names = |constants: &[Constant]| {
        constants.iter().map(|one| format!("`{}`", name(one))).collect::<Vec<_>>().join(", ")
    };
    println!("\nNeither right nor wrong changes, and E_r by less than {MATTERS} %: {}", names(&slight));
    println!("\nNo change to the last bit: {}", names(&idle));
    idle.retain(|constant| {
        [0.5, 2.0].iter().all(|factor| changes(&looks, *constant, *factor).iter().all(Option::is_none))
    });
    println!("\nNor × 0.5 / × 2: {}", names(&idle));
}

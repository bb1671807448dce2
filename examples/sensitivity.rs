//! How much each judged constant matters: the change of the mean errors of frames/paper and frames/wild, image and given
//! edges, when it is 20 % smaller or larger. `cargo run --release --features sensitivity --example sensitivity` prints
//! all as a table; `-- arc refine::` those whose names contain one of the words, `-- --every 4` from every fourth frame,
//! `-- --shared FOLDER` from frames elsewhere.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../tests/support/frames.rs"]
mod frames;
#[path = "../tests/support/parallel.rs"]
mod parallel;
#[path = "../tests/support/mod.rs"]
mod support;

#[allow(dead_code, reason = "shared with the example accuracy, which uses all of it")]
#[path = "accuracy/disturbance.rs"]
mod disturbance;
#[allow(dead_code, reason = "shared with the example accuracy, which uses all of it")]
#[path = "accuracy/frame.rs"]
mod frame;
mod scaled;

use frame::{Case, Frame, read_set};
use parallel::map;
use scaled::{constants, row, with_scaled};
use std::path::{Path, PathBuf};

/// The mean errors of a set, and how many fits failed.
struct Means {
    errors: [f64; 4],
    failed: usize,
}

fn means(frames: &[Frame]) -> Means {
    let all = map(frames, |frame| frame.errors_of(&Case::default()));
    let good: Vec<_> = all.iter().flatten().collect();
    let mean = |k: usize| good.iter().map(|errors| errors[k]).sum::<f64>() / good.len() as f64;
    Means { errors: [0, 1, 2, 3].map(mean), failed: all.len() - good.len() }
}

/// Changes in percent, "·" for none.
fn changes(before: &Means, after: [&Means; 2]) -> String {
    let change = |k: usize, after: &Means| {
        let percent = (after.errors[k] / before.errors[k] - 1.0) * 100.0;
        if after.errors[k] == before.errors[k] { "·".into() } else { format!("{percent:+.0}") }
    };
    let column = |k: usize| format!("{} / {}", change(k, after[0]), change(k, after[1]));
    let mut text = [0, 1, 2, 3].map(column).join(" | ");
    let failed = after[0].failed + after[1].failed;
    if failed > 2 * before.failed {
        text += &format!(" ({failed} failed)");
    }
    text
}

fn main() {
    let mut shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let (mut every, mut words) = (1, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--shared" => shared = PathBuf::from(arguments.next().expect("--shared takes a folder")),
            "--every" => every = arguments.next().unwrap().parse().expect("--every takes a number"),
            _ => words.push(argument),
        }
    }
    let all = [
        cylfuse::noise::constants(),
        cylfuse::parts::constants(),
        cylfuse::limb_location::constants(),
        cylfuse::end_location::constants(),
    ];
    let constants = constants(all.concat(), &words);
    let sets = ["frames/paper", "frames/wild"].map(|set| {
        let frames = read_set(&shared, set);
        frames.into_iter().step_by(every).collect::<Vec<_>>()
    });
    let before = sets.each_ref().map(|frames| means(frames));
    println!(
        "{} and {} frames; changes of the mean errors in %, constant − 20 % / + 20 %",
        sets[0].len(),
        sets[1].len()
    );
    println!("\n| constant | value | unit | paper E_o | E_p | E_r | E_l | wild E_o | E_p | E_r | E_l |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for constant in constants {
        let [less, more] = [0.8, 1.2]
            .map(|factor| with_scaled(constant, factor, || sets.each_ref().map(|frames| means(frames))));
        let of_sets: Vec<String> = (0..2).map(|k| changes(&before[k], [&less[k], &more[k]])).collect();
        println!("{}", row(&constant, &of_sets));
    }
}

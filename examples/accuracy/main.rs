//! Errors of the fit against the truth of the frames in ../shared, as tables with the targets beside them:
//! `cargo run --release --example accuracy` prints all, `-- given real` some, `-- --shared FOLDER` those of frames
//! elsewhere, `-- --frames given` also each frame.
#![allow(clippy::unwrap_used)] // A measurement that can't run should stop.

#[path = "../../tests/support/frames.rs"]
mod frames;
#[path = "../../tests/support/parallel.rs"]
mod parallel;
#[path = "../../tests/support/mod.rs"]
mod support;

mod disturbance;
mod frame;
mod objects;
mod rows;
mod scaled;
mod shared_errors;
mod table;
mod views;

use frame::{Frame, read_set};
use std::path::{Path, PathBuf};

/// The sets of frames, and whether to list single ones.
struct Sets {
    paper: Vec<Frame>,
    wild: Vec<Frame>,
    repeat: Vec<Frame>,
    tof: Vec<Frame>,
    real: Vec<Frame>,
    objects: Vec<Frame>,
    /// Recorded frames with masks of whole objects.
    real2: Vec<Frame>,
    views: Vec<views::Views>,
    list: bool,
}

type Row = (&'static str, fn(&Sets));

/// The tables by name.
const ROWS: [Row; 15] = [
    ("given", rows::given),
    ("wild", rows::wild),
    ("no-edges", rows::no_edges),
    ("no-image", rows::no_image),
    ("disturbed", rows::disturbed),
    ("images", rows::images),
    ("scaled", rows::scaled),
    ("repeat", rows::repeat),
    ("tof", shared_errors::tof),
    ("compressed", shared_errors::compressed),
    ("real", rows::real),
    ("never-worse", rows::never_worse),
    ("methods", rows::methods),
    ("views", views::views),
    ("objects", objects::objects),
];

fn main() {
    let mut shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let (mut list, mut wanted) = (false, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--shared" => shared = PathBuf::from(arguments.next().expect("--shared takes a folder")),
            "--frames" => list = true,
            name if ROWS.iter().any(|row| row.0 == name) => wanted.push(argument),
            other => {
                let names = ROWS.map(|row| row.0).join(", ");
                eprintln!(
                    "{other} is no table; there are {names}, and the options --shared FOLDER, --frames"
                );
                std::process::exit(2);
            }
        }
    }
    let sets = Sets {
        paper: read_set(&shared, "frames/paper"),
        wild: read_set(&shared, "frames/wild"),
        repeat: read_set(&shared, "frames/repeat"),
        tof: read_set(&shared, "frames/tof"),
        real: read_set(&shared, "real"),
        objects: read_set(&shared, "objects"),
        real2: read_set(&shared, "real2"),
        views: views::read_views(&shared),
        list,
    };
    for (name, print) in ROWS {
        if wanted.is_empty() || wanted.iter().any(|row| row == name) {
            print(&sets);
        }
    }
}

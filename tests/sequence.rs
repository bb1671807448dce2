//! Fits that go on from the last one of a sequence.
#![allow(clippy::unwrap_used, reason = "a test program")]

#[path = "support/frames.rs"]
mod frames;

use cylfuse::fitter::{FitResult, Fitter, Inputs, Options, StartKind};
use cylfuse::observations::{DepthRange, DepthView, ImageView, MaskView};
use std::path::Path;

/// A frame of a can, as it is and moved.
struct Frames {
    inputs: frames::Inputs,
}

impl Frames {
    fn read() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/frames/r40_a20_f0");
        Self { inputs: frames::Inputs::read(&folder) }
    }

    /// The frame after its pixels moved to the right, in a fitter that is cleared before.
    fn push(&self, fitter: &mut Fitter, shift: usize) {
        let frames::Inputs { size, depth_scale, .. } = self.inputs;
        fitter.clear();
        fitter.set_intrinsics(self.inputs.intrinsics).unwrap();
        let depth = shifted(&self.inputs.depth, size.0, shift);
        let mask = shifted(&self.inputs.mask, size.0, shift);
        let image = shifted(&self.inputs.image, size.0, shift);
        let depth = DepthView::from_u16(&depth, size, depth_scale).unwrap();
        let mask = MaskView::from_u8(&mask, size).unwrap();
        fitter.push_depth(&depth, Some(&mask), &DepthRange::default()).unwrap();
        fitter.push_image(&ImageView::from_u8(&image, size).unwrap()).unwrap();
    }

    /// The same frame where a lamp went out.
    fn in_other_light(mut self) -> Self {
        self.inputs.image.iter_mut().for_each(|value| *value = (0.7 * f64::from(*value)).round() as u8);
        self
    }

    fn fit(&self, fitter: &mut Fitter, shift: usize) -> FitResult {
        self.push(fitter, shift);
        fitter.fit().unwrap()
    }
}

fn shifted<T: Copy>(values: &[T], width: usize, shift: usize) -> Vec<T> {
    let row = |row: &[T]| {
        let mut row = row.to_vec();
        row.rotate_right(shift);
        row
    };
    values.chunks(width).flat_map(row).collect()
}

fn fitter(start: StartKind) -> Fitter {
    let mut fitter = Fitter::new();
    fitter.set_options(Options { start, threads: 1, ..Options::default() }).unwrap();
    fitter
}

/// Whether two fits agree to a part of what they state.
fn agree(first: &FitResult, second: &FitResult, part: f64) {
    let deviation = first.uncertainty.unwrap().radius();
    let difference = first.cylinder.compare(&second.cylinder);
    let radius = (first.cylinder.radius - second.cylinder.radius).abs();
    assert!(radius < part * deviation, "{radius} {deviation}");
    assert!(difference.axis_distance < part * deviation, "{difference:?} {deviation}");
}

#[test]
fn the_first_fit_is_from_scratch_and_the_next_ones_agree_with_it() {
    let frames = Frames::read();
    let scratch = frames.fit(&mut fitter(StartKind::Auto), 0);
    let mut sequence = fitter(StartKind::Last);
    let first = frames.fit(&mut sequence, 0);
    assert_eq!(first.cylinder, scratch.cylinder);
    assert_eq!(first.uncertainty, scratch.uncertainty);
    for _ in 0..3 {
        let next = frames.fit(&mut sequence, 0);
        assert_eq!(next.start_kind, StartKind::Last);
        assert_eq!(next.limbs_located, 2);
        agree(&scratch, &next, 0.3);
    }
}

#[test]
fn a_cylinder_that_moves_is_followed_and_one_that_jumps_is_searched() {
    let frames = Frames::read();
    let mut sequence = fitter(StartKind::Last);
    for shift in [0, 2, 4, 8, 60, 0] {
        let next = frames.fit(&mut sequence, shift);
        let scratch = frames.fit(&mut fitter(StartKind::Auto), shift);
        println!(
            "{shift}: {:?} {:?} {}",
            scratch.cylinder,
            next.cylinder,
            scratch.uncertainty.unwrap().radius()
        );
        assert!(next.limbs_located >= scratch.limbs_located);
        agree(&scratch, &next, 1.0);
    }
}

#[test]
fn the_same_calls_give_the_same_bits_for_any_number_of_threads() {
    let frames = Frames::read();
    let fits = |threads: usize| {
        let mut sequence = fitter(StartKind::Last);
        sequence.set_options(Options { threads, ..*sequence.options() }).unwrap();
        [0, 1, 2, 40, 41].map(|shift| frames.fit(&mut sequence, shift).cylinder)
    };
    assert_eq!(fits(1), fits(1));
    assert_eq!(fits(1), fits(3));
}

#[test]
fn what_a_fit_left_changes_no_fit_that_does_not_ask_for_it() {
    let frames = Frames::read();
    let mut fitter = fitter(StartKind::Last);
    frames.fit(&mut fitter, 0);
    fitter.set_options(Options { start: StartKind::Auto, ..*fitter.options() }).unwrap();
    let after = frames.fit(&mut fitter, 3);
    let scratch = frames.fit(&mut self::fitter(StartKind::Auto), 3);
    assert_eq!((after.cylinder, after.start_kind), (scratch.cylinder, scratch.start_kind));
}

#[test]
fn a_limb_that_is_covered_is_not_taken_from_the_last_image() {
    let frames = Frames::read();
    let mut sequence = fitter(StartKind::Last);
    frames.fit(&mut sequence, 0);
    frames.push(&mut sequence, 0);
    let flat = vec![100; frames.inputs.image.len()];
    sequence.push_image(&ImageView::from_u8(&flat, frames.inputs.size).unwrap()).unwrap();
    assert_eq!(sequence.fit().unwrap().limbs_located, 0);
    // Without an image there is nothing to go on from but the cylinder.
    sequence.clear_inputs(Inputs::IMAGE);
    assert_eq!(sequence.fit().unwrap().limbs_located, 0);
    // And the next image is searched.
    assert_eq!(frames.fit(&mut sequence, 1).limbs_located, 2);
}

#[test]
fn in_another_light_the_limbs_are_searched() {
    let mut sequence = fitter(StartKind::Last);
    Frames::read().fit(&mut sequence, 0);
    let frames = Frames::read().in_other_light();
    let next = frames.fit(&mut sequence, 0);
    assert_ne!(next.start_kind, StartKind::Last);
    agree(&frames.fit(&mut fitter(StartKind::Auto), 0), &next, 0.3);
    // From there it goes on.
    assert_eq!(frames.fit(&mut sequence, 0).start_kind, StartKind::Last);
}

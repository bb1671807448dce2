//! The pieces of a mask, and which of them are specks.

use super::Mask;
use crate::memory::List;
use std::ops::Range;

/// A piece with less than one in so many of the pixels of the largest is a speck, marked by mistake. What is seen of a body beside
/// something in front may be one in sixty.
const SPECK: usize = 200;

/// Pixels of a row side by side.
struct Run {
    row: usize,
    columns: Range<usize>,
}

impl Mask {
    /// The mask without its specks; `None` where it has none.
    pub(super) fn find_without_specks(&self) -> Option<Self> {
        let runs = self.runs();
        let pieces = pieces(&runs);
        let mut sizes = List::filled(0, runs.len());
        runs.iter().zip(&pieces).for_each(|(run, &piece)| sizes[piece] += run.columns.len());
        let largest = sizes.iter().copied().max()?;
        let is_speck = |piece: usize| SPECK * sizes[piece] < largest;
        if !pieces.iter().any(|&piece| is_speck(piece)) {
            return None;
        }
        let mut kept = List::filled(false, self.width() * self.height());
        for (run, _) in runs.iter().zip(&pieces).filter(|(_, piece)| !is_speck(**piece)) {
            let start = run.row * self.width();
            kept[start + run.columns.start..start + run.columns.end].fill(true);
        }
        self.chosen(|column, row| kept[row * self.width() + column])
    }

    /// Its runs, row by row.
    fn runs(&self) -> List<Run> {
        let (columns, rows) = self.bounds();
        let mut runs = List::new();
        for row in rows {
            let pixels = self.pixels_by_index(row * self.width()..(row + 1) * self.width());
            let mut column = columns.start;
            let length = |from: usize, set: bool| {
                let rest = &pixels[from..columns.end];
                rest.iter().position(|&pixel| pixel != set).unwrap_or(rest.len())
            };
            while column < columns.end {
                let start = column + length(column, false);
                column = start + length(start, true);
                if column > start {
                    runs.push(Run { row, columns: start..column });
                }
            }
        }
        runs
    }
}

/// For each run the first one of its piece. Runs that touch, at a corner at least, are one piece.
fn pieces(runs: &[Run]) -> List<usize> {
    let mut parents: List<usize> = (0..runs.len()).collect();
    let first = |parents: &mut List<usize>, mut k: usize| {
        while parents[k] != k {
            parents[k] = parents[parents[k]];
            k = parents[k];
        }
        k
    };
    let mut above = 0;
    for (k, run) in runs.iter().enumerate() {
        let is_over = |other: &Run| {
            other.row + 1 < run.row || other.row + 1 == run.row && other.columns.end < run.columns.start
        };
        while is_over(&runs[above]) {
            above += 1;
        }
        let touching = runs[above..k]
            .iter()
            .take_while(|other| other.row < run.row && other.columns.start <= run.columns.end);
        for (other, _) in (above..).zip(touching) {
            let [a, b] = [k, other].map(|k| first(&mut parents, k));
            parents[a.max(b)] = a.min(b);
        }
    }
    (0..runs.len()).map(|k| first(&mut parents, k)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::MaskView;
    use super::*;

    fn mask(rows: &[&str]) -> Mask {
        let memory: Vec<u8> =
            rows.iter().flat_map(|row| row.bytes().map(|byte| u8::from(byte == b'#'))).collect();
        Mask::copy(&MaskView::from_u8(&memory, (rows[0].len(), rows.len())).unwrap()).unwrap()
    }

    #[test]
    fn runs_that_touch_are_one_piece() {
        let mask = mask(&["#.#..#", "#.#.#.", "###...", "......", ".##.##"]);
        assert_eq!(pieces(&mask.runs()).to_vec(), [0, 0, 2, 0, 0, 2, 0, 7, 8]);
    }

    #[test]
    fn specks_are_left_out() {
        let body = ".####################".repeat(20);
        let rows: Vec<&str> =
            body.as_bytes().chunks(21).map(|row| std::str::from_utf8(row).unwrap()).collect();
        assert_eq!(mask(&rows).without_specks(), None);
        let [empty, two, one] = [".....................", "##...................", "....................#"];
        // Two pixels are as many as one in 200, one is not.
        let with_both = mask(&[&[two, empty], &rows[..], &[empty, one]].concat());
        let without = with_both.without_specks().unwrap();
        assert_eq!((without.count(), without.bounds()), (402, (0..21, 0..22)));
        assert!(without.contains(0, 0) && !without.contains(20, 23));
        assert_eq!(without.without_specks(), None);
    }
}

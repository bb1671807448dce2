//! A region of the image, owned.

use super::size::check_same_size;
use super::views::MaskView;
use crate::error::{Error, Result, reserve};
use crate::memory::List;
use pulp::Arch;
use std::ops::Range;
use std::sync::OnceLock;

/// The pixels of the image that show a cylinder: its lateral surface alone, or the whole object with caps, lids and handles.
/// Its boundary is a hint, never a measurement of the limbs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    width: usize,
    height: usize,
    pixels: List<bool>,
    /// The columns and rows beyond which no pixel is set: most of most masks is empty.
    columns: Range<usize>,
    rows: Range<usize>,
    remembered: Remembered,
}

/// What follows from a mask once it was asked for: many fits may share a mask, and each asks several times.
#[derive(Debug, Clone, Default)]
struct Remembered {
    outline: OnceLock<Vec<(usize, usize)>>,
    without_specks: OnceLock<Option<Box<Mask>>>,
}

impl PartialEq for Remembered {
    /// What is remembered is no difference.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Eq for Remembered {}

impl Mask {
    /// Copies a mask.
    ///
    /// # Errors
    /// `EmptyMask` when no pixel is set, `OutOfMemory`.
    pub fn copy(view: &MaskView<'_>) -> Result<Self> {
        let (width, height) = (view.width(), view.height());
        if width == 0 || height == 0 {
            return Err(Error::EmptyMask { width, height });
        }
        let mut pixels = List::new();
        reserve(&mut pixels, width * height, "the mask")?;
        // With the widest instructions of the machine.
        Arch::new().dispatch(|| (0..height).for_each(|row| view.read_row(row, &mut pixels)));
        let (mut columns, mut rows) = (width..0, height..0);
        for (row, pixels) in pixels.chunks_exact(width).enumerate() {
            // Most of most masks is empty: looked through many pixels at a time.
            if !any(pixels) {
                continue;
            }
            rows = rows.start.min(row)..row + 1;
            if any(&pixels[..columns.start]) {
                columns.start = first(pixels).unwrap_or(columns.start);
            }
            if any(&pixels[columns.end..]) {
                columns.end = last(pixels).map_or(columns.end, |last| last + 1);
            }
        }
        if rows.is_empty() {
            return Err(Error::EmptyMask { width, height });
        }
        Ok(Self { width, height, pixels, columns, rows, remembered: Remembered::default() })
    }

    /// Columns.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Whether a pixel belongs to the cylinder; false outside the image.
    #[must_use]
    pub fn contains(&self, column: usize, row: usize) -> bool {
        column < self.width && row < self.height && self.pixels[row * self.width + column]
    }

    /// Whether a pixel that is counted row by row belongs to the cylinder.
    #[inline]
    pub(super) fn contains_index(&self, index: usize) -> bool {
        self.pixels[index]
    }

    /// Which of some pixels, counted row by row, belong to the cylinder.
    #[inline]
    pub(super) fn pixels_by_index(&self, pixels: Range<usize>) -> &[bool] {
        &self.pixels[pixels]
    }

    /// How many pixels are set.
    #[must_use]
    pub fn count(&self) -> usize {
        let rows = self.pixels[self.rows.start * self.width..].chunks(self.width).take(self.rows.len());
        let count = |row: &[bool]| row[self.columns.clone()].iter().map(|&set| u32::from(set)).sum::<u32>();
        rows.map(|row| count(row) as usize).sum()
    }

    /// The set pixels as (column, row), row by row.
    pub fn set_pixels(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.set_pixels_of_grid(1)
    }

    /// The set pixels in every `stride`-th row and column, row by row.
    pub fn set_pixels_of_grid(&self, stride: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let first = |range: &Range<usize>| range.start.next_multiple_of(stride);
        let columns = first(&self.columns)..self.columns.end;
        (first(&self.rows)..self.rows.end).step_by(stride).flat_map(move |row| {
            let pixels = &self.pixels[row * self.width..(row + 1) * self.width];
            columns.clone().step_by(stride).filter(|&column| pixels[column]).map(move |column| (column, row))
        })
    }

    /// The set pixels with a neighbour that is unset or outside the image, row by row.
    #[must_use]
    pub fn outline(&self) -> &[(usize, usize)] {
        self.remembered.outline.get_or_init(|| {
            let mut outline = List::new();
            // A loop over an iterator of iterators is slow to be asked one by one.
            self.find_outline().for_each(|pixel| outline.push(pixel));
            // It outlives the call, whose memory the list has.
            outline.to_vec()
        })
    }

    /// The mask without pieces so small that they are marked by mistake; `None` where it has none.
    #[must_use]
    pub fn without_specks(&self) -> Option<&Self> {
        self.remembered.without_specks.get_or_init(|| self.find_without_specks().map(Box::new)).as_deref()
    }

    fn find_outline(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let columns = self.columns.clone().step_by(EIGHT);
        self.rows.clone().flat_map(move |row| {
            let line = |row: usize| self.pixels.get(row * self.width..(row + 1) * self.width);
            let lines = [row.checked_sub(1).and_then(line), line(row), line(row + 1)];
            columns.clone().flat_map(move |first| {
                let [above, here, below] = lines.map(|line| eight(line, first));
                let left = first.checked_sub(1).map_or(here << 8, |before| eight(lines[1], before));
                let edge = here & !(left & eight(lines[1], first + 1) & above & below);
                // Most have none.
                let looked_at = if edge == 0 { 0 } else { EIGHT };
                (0..looked_at).filter(move |k| (edge >> (8 * k)) & 1 != 0).map(move |k| (first + k, row))
            })
        })
    }

    /// The pixels that are not set beside one that is, row by row.
    pub fn surroundings(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let wider =
            |range: &Range<usize>, end: usize| range.start.saturating_sub(1)..(range.end + 1).min(end);
        let (columns, rows) = (wider(&self.columns, self.width), wider(&self.rows, self.height));
        let beside = |column: usize, row: usize| {
            let set = |column, row| self.contains(column, row);
            // Left of the first column and above the first row lies outside.
            set(column.wrapping_sub(1), row)
                || set(column + 1, row)
                || set(column, row.wrapping_sub(1))
                || set(column, row + 1)
        };
        rows.flat_map(move |row| columns.clone().map(move |column| (column, row)))
            .filter(move |&(column, row)| !self.contains(column, row) && beside(column, row))
    }

    /// The mask with the pixels (column, row) of the image that belong to it, too: at most `reach` beyond its first and last column and row.
    #[must_use]
    pub fn extended(&self, reach: usize, belongs: impl Fn((usize, usize)) -> bool) -> Self {
        let mut extended = Self {
            width: self.width,
            height: self.height,
            pixels: self.pixels.clone(),
            columns: self.columns.clone(),
            rows: self.rows.clone(),
            remembered: Remembered::default(),
        };
        let wider = |range: &Range<usize>, end: usize| {
            range.start.saturating_sub(reach)..range.end.saturating_add(reach).min(end)
        };
        let (columns, rows) = (wider(&self.columns, self.width), wider(&self.rows, self.height));
        for (column, row) in rows.flat_map(|row| columns.clone().map(move |column| (column, row))) {
            if !self.contains(column, row) && belongs((column, row)) {
                extended.pixels[row * self.width + column] = true;
                extended.columns = extended.columns.start.min(column)..extended.columns.end.max(column + 1);
                extended.rows = extended.rows.start.min(row)..extended.rows.end.max(row + 1);
            }
        }
        extended
    }

    /// The columns and rows beyond which no pixel is set.
    #[must_use]
    pub fn bounds(&self) -> (Range<usize>, Range<usize>) {
        (self.columns.clone(), self.rows.clone())
    }

    /// The mask of the set pixels (column, row) that are chosen; `None` when there are none.
    #[must_use]
    pub fn chosen(&self, choose: impl Fn(usize, usize) -> bool) -> Option<Self> {
        let (width, height) = (self.width, self.height);
        let mut pixels = List::filled(false, self.pixels.len());
        let (mut columns, mut rows) = (width..0, height..0);
        for (column, row) in self.set_pixels().filter(|&(column, row)| choose(column, row)) {
            pixels[row * width + column] = true;
            columns = columns.start.min(column)..columns.end.max(column + 1);
            rows = rows.start.min(row)..row + 1;
        }
        let remembered = Remembered::default();
        (!rows.is_empty()).then_some(Self { width, height, pixels, columns, rows, remembered })
    }

    /// Checks that the mask lies on the grid of another image, which has the given columns and rows.
    ///
    /// # Errors
    /// `SizeMismatch`.
    pub fn check_size(&self, other: &'static str, size: (usize, usize)) -> Result<()> {
        check_same_size("mask", (self.width, self.height), other, size, "scale the mask")
    }
}

/// Pixels that are looked at at a time.
const MANY: usize = 64;

/// As many as a number has bytes.
const EIGHT: usize = 8;

/// The pixels of a row from a column on, a byte each; those outside the image are not set.
fn eight(row: Option<&[bool]>, first: usize) -> u64 {
    let pixels = row.and_then(|row| row.get(first..)).unwrap_or_default();
    u64::from_le_bytes(match pixels.first_chunk::<EIGHT>() {
        Some(pixels) => pixels.map(u8::from),
        None => std::array::from_fn(|k| u8::from(pixels.get(k) == Some(&true))),
    })
}

/// Whether any of some pixels is set.
fn any(pixels: &[bool]) -> bool {
    let (chunks, rest) = pixels.as_chunks::<MANY>();
    let any = |pixels: &[bool; MANY]| pixels.iter().fold(0, |any, &set| any | u8::from(set)) != 0;
    chunks.iter().any(any) || rest.contains(&true)
}

/// The first of some pixels that is set.
fn first(pixels: &[bool]) -> Option<usize> {
    let start = MANY * pixels.chunks(MANY).position(any)?;
    pixels[start..].iter().position(|&set| set).map(|k| start + k)
}

/// The last of some pixels that is set.
fn last(pixels: &[bool]) -> Option<usize> {
    let start = MANY * pixels.chunks(MANY).rposition(any)?;
    pixels[start..].iter().rposition(|&set| set).map(|k| start + k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn set_pixels_are_listed_row_by_row() {
        let memory = [0, 7, 0, 255, 0, 1];
        let mask = Mask::copy(&MaskView::from_u8(&memory, (3, 2)).unwrap()).unwrap();
        assert_eq!(mask.set_pixels().collect::<Vec<_>>(), [(1, 0), (0, 1), (2, 1)]);
        assert_eq!(mask.set_pixels_of_grid(2).collect::<Vec<_>>(), []);
        assert_eq!(mask.count(), 3);
        assert_eq!(mask.outline(), [(1, 0), (0, 1), (2, 1)]);
        let whole = Mask::copy(&MaskView::from_u8(&[1; 12], (4, 3)).unwrap()).unwrap();
        assert_eq!((whole.count(), whole.outline().len()), (12, 10));
        assert_eq!(whole.surroundings().count(), 0);
        assert_eq!(mask.surroundings().collect::<Vec<_>>(), [(0, 0), (2, 0), (1, 1)]);
        let extended = mask.extended(9, |(column, row)| column + row == 3);
        assert_eq!(extended.set_pixels().collect::<Vec<_>>(), [(1, 0), (0, 1), (2, 1)]);
        let extended = mask.extended(9, |(column, row)| column + row < 2);
        assert_eq!(extended.set_pixels().collect::<Vec<_>>(), [(0, 0), (1, 0), (0, 1), (2, 1)]);
        assert_eq!(extended.bounds(), (0..3, 0..2));
        let first = Mask::copy(&MaskView::from_u8(&[1, 0, 0, 0, 0], (5, 1)).unwrap()).unwrap();
        assert_eq!(first.extended(2, |_| true).bounds(), (0..3, 0..1));
        assert!(mask.contains(1, 0) && !mask.contains(1, 1) && !mask.contains(3, 0));
        let error = mask.check_size("depth image", (3, 3)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "mask is 3 x 2 but depth image is 3 x 3; both must have the same size: scale the mask"
        );
    }

    #[test]
    fn the_outline_is_that_of_pixels_looked_at_one_by_one() {
        let mut state = 1_u64;
        for (width, height) in [(1, 1), (1, 9), (7, 5), (8, 8), (9, 3), (40, 23)] {
            for density in [1, 2, 7] {
                let memory: Vec<u8> = (0..width * height)
                    .map(|_| {
                        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
                        u8::from((state >> 40) % 8 <= density)
                    })
                    .collect();
                let Ok(mask) = Mask::copy(&MaskView::from_u8(&memory, (width, height)).unwrap()) else {
                    continue;
                };
                let set = |column: usize, row: usize| mask.contains(column, row);
                let inner = |column: usize, row: usize| {
                    set(column.wrapping_sub(1), row)
                        && set(column + 1, row)
                        && set(column, row.wrapping_sub(1))
                        && set(column, row + 1)
                };
                let expected: Vec<_> =
                    mask.set_pixels().filter(|&(column, row)| !inner(column, row)).collect();
                assert_eq!(mask.outline(), expected);
            }
        }
    }

    #[test]
    fn an_empty_mask_is_an_error_of_its_own() {
        let view = MaskView::from_u8(&[0; 6], (3, 2)).unwrap();
        assert_eq!(Mask::copy(&view), Err(Error::EmptyMask { width: 3, height: 2 }));
        // Memory for the rows of no pixels would be asked for: there are none, however many rows there are.
        for (width, height) in [(0, 0), (0, 5), (5, 0), (0, usize::MAX), (usize::MAX, 0)] {
            let view = MaskView::from_u8(&[], (width, height)).unwrap();
            assert_eq!(Mask::copy(&view), Err(Error::EmptyMask { width, height }));
        }
    }
}

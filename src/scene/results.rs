//! What was found in a scene.

use super::check_memory;
use super::labels::{indices_of, mask_of, renumber};
use crate::detection::{Evidence, Looks};
use crate::error::{Error, Result};
use crate::extent::{ArcSample, Extent};
use crate::fitter::{FitResult, Fitter, LimbObservation, Options};
use crate::observations::{Mask, MaskView, moved};

/// A cylinder of a scene.
#[derive(Debug, Clone)]
pub struct Found {
    /// The probability that there is a cylinder.
    pub score: f64,
    /// What speaks for it.
    pub evidence: Evidence,
    /// Pixels of its region; points for a cloud.
    pub pixels: usize,
    /// The fit of its region. Of a depth image without a grey image, and where no fit covers the limbs better than the search did or
    /// none is near what that found, it is the cylinder of the search, with [`crate::fitter::Flags::NOT_CONVERGED`]; how far the
    /// minimum of the data lies from it is part of its stated uncertainty. Of a cloud that was seen from its origin and whose
    /// neighbouring points share errors, the fit takes the points within 0.7 radii of the axis alone: next to limbs sensors draw
    /// them out.
    pub result: FitResult,
    /// Its visible piece; of a cloud that of its points.
    pub extent: Result<Extent>,
    /// The samples in the image on the arcs of start and end; empty for an end that the image does not show.
    pub arcs: [Vec<ArcSample>; 2],
    /// The fit, without its mask: the labels have that.
    pub(super) fitter: Fitter,
    /// The points of the body of a cloud, by their numbers in its looks; of no use once they have their label.
    pub(super) region: Vec<u32>,
    /// Likewise all of a body that bends or tapers, of which the region is a piece: later looks see none of it.
    pub(super) body: Vec<u32>,
}

impl Found {
    /// The options of the fit: those of the detector with its limits and the start.
    #[must_use]
    pub fn fit_options(&self) -> &Options {
        self.fitter.options()
    }

    /// What the fit saw of the two limbs in the image; `None` when it did not look.
    #[must_use]
    pub fn limbs(&self) -> Option<&[LimbObservation; 2]> {
        self.fitter.limbs()
    }
}

/// All cylinders of a frame or a cloud.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The cylinders by falling score.
    pub cylinders: Vec<Found>,
    /// For each pixel or point, row by row, the number of its cylinder in the order of `cylinders` from 1 on, or 0.
    pub labels: Vec<u16>,
    /// Columns and rows of the labels.
    pub size: (usize, usize),
    /// Whether all of it was looked at. The work of a search with its fits is bounded, for a cloud that of each look at it, so that
    /// no input takes much longer than any other of its size. Where one has more in it than that, cylinders may be missing. One for whose fit there was no
    /// work left is what the search found, with [`crate::fitter::Flags::NOT_CONVERGED`].
    pub complete: bool,
    /// The columns and rows by which the depth image was moved to where the image shows the same bodies: where its registration is off
    /// by pixels, edges beside limbs would be taken for these. Then each result has
    /// [`crate::fitter::Flags::DEPTH_SHIFTED`], and its fitter has the moved depth; labels are those of the depth as it was
    /// given. Zeros otherwise, for a cloud, and with a depth camera of its own.
    pub depth_moved: [i32; 2],
}

impl Scene {
    /// The pixels or points of a cylinder, counted from 0 row by row.
    pub fn indices(&self, index: usize) -> impl Iterator<Item = usize> + Clone + '_ {
        indices_of(&self.labels, index)
    }

    /// The fitter of a cylinder as its fit left it, with frame, mask, start and result: for residuals, completion and all
    /// else that can be asked of a fit.
    ///
    /// # Errors
    /// `InvalidArgument` when there is no such cylinder, `OutOfMemory`.
    pub fn fitter(&self, index: usize) -> Result<Fitter> {
        let Some(found) = self.cylinders.get(index) else {
            let requirement = format!("be less than the number of cylinders, {}", self.cylinders.len());
            return Err(Error::argument("index", index, requirement));
        };
        check_memory("the fitter", self.labels.len().max(found.fitter.cloud().len()))?;
        let mut fitter = found.fitter.clone();
        if fitter.depth().is_some() {
            let mask = moved(&self.mask(index), self.size, self.depth_moved)?;
            fitter.swap_mask(Some(Mask::copy(&MaskView::from_u8(&mask, self.size)?)?));
        }
        Ok(fitter)
    }

    fn mask(&self, index: usize) -> Vec<u8> {
        mask_of(&self.labels, index)
    }

    /// Adds what another look has shown at the points that have no label yet. A body most of whose points others have is a part of
    /// one of these.
    pub(super) fn add(&mut self, other: Self, looks: &mut Looks) {
        for mut found in other.cylinders {
            let [region, body] = [&mut found.region, &mut found.body].map(std::mem::take);
            let own = region.iter().filter(|&&k| self.labels[looks.given(k)] == 0).count();
            // Labels have 16 bits.
            let Ok(label) = u16::try_from(self.cylinders.len() + 1) else {
                self.complete = false;
                break;
            };
            if 2 * own < region.len() {
                continue;
            }
            found.pixels = own;
            self.cylinders.push(found);
            region.into_iter().for_each(|k| {
                let given = looks.given(k);
                if self.labels[given] == 0 {
                    self.labels[given] = label;
                }
                looks.remove(k);
            });
            body.into_iter().for_each(|k| looks.remove(k));
        }
        self.complete &= other.complete;
    }

    /// Puts the cylinders into the order of their scores, and leaves out those beyond the most.
    pub(super) fn order(&mut self, most: usize) {
        let mut cylinders: Vec<(u16, Found)> = (1..).zip(std::mem::take(&mut self.cylinders)).collect();
        cylinders.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
        cylinders.truncate(most);
        renumber(&mut self.labels, cylinders.iter().map(|(label, _)| *label));
        self.cylinders = cylinders.into_iter().map(|(_, found)| found).collect();
    }
}

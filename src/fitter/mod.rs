//! The fitter: takes observations, finds a start, minimises, and says how far to trust the result.
//!
//! [`Fitter`] holds what was pushed, by view. A fit reads it as immutable `Data` and runs through stages, each a function
//! from the data and the value of the stage before to a new value; `fit.rs` shows them from top to bottom, `attempts.rs` the fits of a call.

mod along_rays;
mod among_pixels;
mod among_points;
mod arcs;
mod attempts;
mod background;
mod batch;
mod body;
mod conformity;
mod constraints;
mod continued;
mod correlation;
mod covered;
mod data;
mod describe;
mod edges;
mod fit;
mod guided;
mod guides;
mod inputs;
mod lack_of_fit;
mod located;
mod minimum;
mod objective;
mod options;
mod other_body;
mod outlier;
mod outline;
mod plane_beside;
mod points_alone;
mod queries;
mod ranges;
mod result;
mod rims;
mod run;
mod scales;
mod selection;
mod silhouette;
mod start;
mod stepped;
mod subsample;
mod taper;
mod two_planes;
mod two_walls;
mod uncertainty;
mod unmasked;
mod view;
mod words;

pub use crate::limb_location::{LimbLine, LimbObservation, LimbSample, NotVisible};
pub use crate::parts::Part;
pub use crate::solver::{Iteration, IterationLimits, Rank, Termination};
pub(crate) use among_points::contradict;
pub(crate) use batch::each;
pub use batch::fit_all;
pub use conformity::{Conformity, Tolerance};
pub use describe::{Diagnosis, ResidualKind};
pub use inputs::Inputs;
pub use options::{ChartChoice, EdgeUse, ExtentRule, Method, NearWall, ObjectiveKind, Options, StartKind};
pub(crate) use plane_beside::off_planes;
pub(crate) use points_alone::is_as_good;
pub use result::{FitResult, Flags, Seconds};
pub use taper::Taper;
pub(crate) use uncertainty::larger_deviation;
pub use uncertainty::{ImageShift, RadiusComparison, Uncertainty};
pub(crate) use view::View;

#[cfg(feature = "sensitivity")]
/// The constants of fits that go on from the last one, and of fits to points alone.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    [continued::CONSTANTS, among_points::CONSTANTS, plane_beside::CONSTANTS, points_alone::CONSTANTS].concat()
}

use crate::error::{Error, Result};
use crate::geometry::Cylinder;
#[cfg(doc)]
use crate::geometry::LimbFrame;
use crate::memory::{List, Memory, is_there};
use constraints::Constraints;
use continued::Last;
use data::Data;
use run::Run;
use std::ops::ControlFlow;

/// Bytes a point for which a fit has room at the same time, beside the points: coordinates, normals and distances for
/// random samples, or positions, cells and residuals for the correlation.
const BYTES_OF_FIT: usize = 96;

/// The same for a diagnosis: rows of six numbers, gathered, stacked, and factorised in place of a copy.
const BYTES_OF_DIAGNOSIS: usize = 320;

/// So much memory is not asked for before a call: where it is not there nothing else is.
const ALWAYS_THERE: usize = 4 << 20;

/// Estimates one cylinder from one view or several. Set intrinsics, push observations, call [`Fitter::fit`]; whatever
/// fails leaves everything as it was.
///
/// A fitter begins with one view at the identity. [`Fitter::select_view`] adds others and chooses the one that what
/// follows is about; options, start model, fit and result are about all.
///
/// A fitter keeps the memory of its calls for the next ones, 2 to 4 MB after a fit of an image of 640 × 480 pixels, and
/// frees it when it is dropped: a call like the ones before asks for none, but for a search of points alone.
#[derive(Debug, Clone)]
pub struct Fitter {
    options: Options,
    start: Option<Cylinder>,
    views: Vec<View>,
    /// The view that is set, pushed to and asked about.
    selected: usize,
    /// What the last fit was made with.
    made_with: Option<MadeWith>,
    result: Option<FitResult>,
    /// What the last fit left to the next one of a sequence.
    last: Option<Last>,
    memory: Memory,
}

/// What a fit was made with.
#[derive(Debug, Clone)]
struct MadeWith {
    /// The constraints of the cylinder beside the points.
    constraints: Constraints,
    /// By view: what was fitted of it, where that is not all that was pushed.
    bodies: List<Option<View>>,
}

/// A fit that was made.
#[derive(Debug, Clone)]
struct Fitted {
    made_with: MadeWith,
    result: FitResult,
    /// What the next one may go on from.
    last: Last,
}

impl Default for Fitter {
    fn default() -> Self {
        Self {
            options: Options::default(),
            start: None,
            views: vec![View::default()],
            selected: 0,
            made_with: None,
            result: None,
            last: None,
            memory: Memory::default(),
        }
    }
}

impl Fitter {
    /// A fitter with default options and no data.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// Replaces the options.
    ///
    /// # Errors
    /// `InvalidArgument`; the old options stay then.
    pub fn set_options(&mut self, options: Options) -> Result<()> {
        options.check()?;
        self.options = options;
        self.made_with = None;
        Ok(())
    }

    /// Sets or takes away the start model, in the reference frame. Of points alone that hold several bodies [`StartKind::Auto`] and
    /// [`StartKind::Last`] fit the one near it.
    pub fn set_start(&mut self, start: Option<Cylinder>) {
        self.start = start;
    }

    /// The last successful fit.
    #[must_use]
    pub fn result(&self) -> Option<&FitResult> {
        self.result.as_ref()
    }

    /// What the last fit saw of the two limbs in the image of the selected view, in the order of
    /// [`LimbFrame::limb_lines`]: lines, samples used and refused. `None` when the image was not searched: without an
    /// image, for edges as given, and for other objectives than the robust one.
    #[must_use]
    pub fn limbs(&self) -> Option<&[LimbObservation; 2]> {
        self.limbs_of(self.selected)
    }

    /// What the last fit saw of the two limbs in the image of a view, as [`Fitter::limbs`] gives it of the selected one.
    #[must_use]
    pub fn limbs_of(&self, view: usize) -> Option<&[LimbObservation; 2]> {
        self.made_with.as_ref()?.constraints.view(view)?.limbs.as_ref()
    }

    /// Whether the last fit knows the limbs in a view to a fraction of a pixel: one was located in its image.
    #[must_use]
    pub fn limbs_known(&self, view: usize) -> bool {
        let made_with = self.made_with.as_ref();
        made_with
            .and_then(|made_with| made_with.constraints.view(view))
            .is_some_and(|constraints| constraints.located > 0)
    }

    /// Estimates the cylinder.
    ///
    /// # Errors
    /// The data do not determine a cylinder (`TooFewPoints`, `PlanarPoints`, `CollinearPoints`, `NoStart`), or do not go
    /// with the options (`Unsupported`, `BadState`, `EdgeGeometry`, and `InvalidArgument` where the least radius is far
    /// larger than the points reach). `Numerical` where numbers overflow, `OutOfMemory`.
    pub fn fit(&mut self) -> Result<FitResult> {
        self.fit_with(&mut |_| ControlFlow::Continue(()))
    }

    /// Estimates the cylinder, as [`Fitter::fit`] does. `report` is called before every iteration, and with the last one again
    /// while a start is searched and limbs and ends are located, and may stop the fit.
    ///
    /// # Errors
    /// Those of [`Fitter::fit`], and `Cancelled`. The last result stays then.
    pub fn fit_with(&mut self, report: &mut dyn FnMut(&Iteration) -> ControlFlow<()>) -> Result<FitResult> {
        self.fit_run(&mut Run::new(report))
    }

    /// The same for a caller who takes the reports for a measure of the work, and tries several starts. `poll_cancel` is asked
    /// where nothing is to be measured; `known` are the first fits from the other starts, to which this one's is added.
    ///
    /// # Errors
    /// Those of [`Fitter::fit_with`], and `NoStart` where the first fit is known.
    pub(crate) fn fit_counted(
        &mut self,
        report: &mut dyn FnMut(&Iteration) -> ControlFlow<()>,
        poll_cancel: &dyn Fn() -> ControlFlow<()>,
        known: &mut Vec<Cylinder>,
    ) -> Result<FitResult> {
        self.fit_run(&mut Run::counted(report, poll_cancel, known))
    }

    fn fit_run(&mut self, run: &mut Run<'_>) -> Result<FitResult> {
        let memory = std::mem::take(&mut self.memory);
        let result = memory.lend(|| self.fit_in_memory(run));
        self.memory = memory;
        result
    }

    /// Frees the memory that the next call would use again, where none is to come soon.
    pub(crate) fn free_memory(&mut self) {
        self.memory = Memory::default();
    }

    /// The memory that a call uses again.
    pub(crate) fn memory(&self) -> &Memory {
        &self.memory
    }

    /// Refuses a call for which there is no memory for lists over all points.
    fn check_memory(&self, bytes_of_point: usize) -> Result<()> {
        let points = self.views.iter().map(|view| view.cloud.len()).sum::<usize>();
        let bytes = points.saturating_mul(bytes_of_point);
        if bytes <= ALWAYS_THERE || is_there(bytes) {
            return Ok(());
        }
        Err(Error::OutOfMemory { what: "the lists over the points", bytes })
    }

    /// What the last fit left, where the next one is to go on from it.
    fn continued(&self) -> Option<&Last> {
        self.last.as_ref().filter(|_| self.options.start == StartKind::Last)
    }

    /// Where the cylinder is about, from the fit before or the caller.
    fn known_cylinder(&self) -> Option<&Cylinder> {
        self.continued().map(|last| &last.cylinder).or(self.start.as_ref())
    }

    /// A view as the last fit took it.
    pub(crate) fn fitted_view(&self, view: usize) -> &View {
        let of_fit = self.made_with.as_ref().and_then(|made_with| made_with.bodies.get(view)?.as_ref());
        of_fit.unwrap_or(&self.views[view])
    }

    /// The data of the last fit, or of everything that was pushed.
    fn data(&self) -> Result<Data<'_>> {
        self.data_of(self.made_with.as_ref().map_or(&[], |made_with| &made_with.bodies))
    }

    /// The data of all views, of some only what was fitted of them.
    fn data_of<'a>(&'a self, bodies: &'a [Option<View>]) -> Result<Data<'a>> {
        Data::new(&self.options, self.views_or(bodies), self.start.as_ref())
    }

    /// The views, or others in their places where there are any.
    fn views_or<'a>(&'a self, others: &'a [Option<View>]) -> impl Iterator<Item = &'a View> + Clone {
        let other = |index: usize| others.get(index).and_then(Option::as_ref);
        self.views.iter().enumerate().map(move |(index, view)| other(index).unwrap_or(view))
    }

    /// The constraints of the last fit, or the given segments.
    fn constraints(&self, data: &Data<'_>) -> Constraints {
        self.made_with
            .as_ref()
            .map_or_else(|| Constraints::as_given(data), |made_with| made_with.constraints.clone())
    }
}

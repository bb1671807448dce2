//! What constrains a cylinder beside the points.

use super::data::{Data, ViewData};
use super::result::Flags;
use super::scales::Scales;
use crate::end_location::LastArc;
use crate::geometry::Cylinder;
use crate::limb_location::{Appearance, LimbObservation};
use crate::memory::List;
use crate::residuals::{ArcTerm, LimbTerm, PixelSegment, PixelTerm, Rim};
use nalgebra::Vector3;

/// What constrains the cylinder of a fit beside the points, and what the fit found out about that. A value: every stage makes a
/// new one.
#[derive(Debug, Clone, Default)]
pub(super) struct Constraints {
    pub views: List<ViewConstraints>,
    /// Warnings about the edges.
    pub flags: Flags,
    /// w_L: 0 where no edges count.
    pub edge_weight: f64,
    /// Whether the lines are final. Only then do the errors that points share count.
    pub settled: bool,
}

/// The constraints of one view.
#[derive(Debug, Clone, Default)]
pub(super) struct ViewConstraints {
    /// Which view of the fitter it is.
    pub index: usize,
    /// The lines that constrain the limbs.
    pub lines: Option<PixelTerm>,
    /// How many of them are given segments.
    pub given: usize,
    /// How many of them were located in the image.
    pub located: usize,
    /// Scale of the point residuals where lines did not contest what the points say; `None` where it is not known. What
    /// points share is bounded by it.
    pub point_scale: Option<f64>,
    /// The arcs of the ends.
    pub arcs: ArcTerm,
    /// Where the arcs were located.
    pub ends: [Option<EndPosition>; 2],
    /// What the image shows of the limbs; `None` where it was not searched.
    pub limbs: Option<[LimbObservation; 2]>,
    /// What the next image of a sequence need not be asked again.
    pub appearance: Option<Appearance>,
}

impl Constraints {
    /// The given segments as they are.
    pub fn as_given(data: &Data<'_>) -> Self {
        let view = |view: &ViewData<'_>| ViewConstraints::new(view, &view.edges.segments, 0, 0);
        let flags = data.views.iter().fold(Flags::empty(), |flags, view| flags | view.edges.flags);
        let mut constraints = Self {
            views: data.views.iter().map(view).collect(),
            flags,
            edge_weight: data.edge_weight,
            settled: true,
        };
        let counted = !data.options.has_edge_weight() || data.edge_weight > 0.0;
        for (constraints, view) in constraints.views.iter_mut().zip(&data.views) {
            constraints.given = if counted { view.edges.segments.len() } else { 0 };
        }
        constraints
    }

    /// Without any edges, for a reason.
    pub fn without_edges(data: &Data<'_>, reason: Flags) -> Self {
        let flags = Self::as_given(data).flags | reason | Flags::EDGES_IGNORED;
        let views = data.views.iter().map(|view| ViewConstraints::new(view, &[], 0, 0)).collect();
        Self { views, flags, edge_weight: 0.0, settled: true }
    }

    /// From here on lines contest what the points say, whose scales are those without.
    pub fn settle(&mut self, scales: &Scales) {
        self.settled = true;
        for (view, scales) in self.views.iter_mut().zip(&scales.views) {
            view.point_scale = Some(scales.point);
        }
    }

    /// The constraints of a view of the fitter.
    pub fn view(&self, index: usize) -> Option<&ViewConstraints> {
        self.views.iter().find(|view| view.index == index)
    }

    /// Given segments that count.
    pub fn segments_used(&self) -> usize {
        self.views.iter().map(|view| view.given).sum()
    }

    /// Limb lines that were located in an image and count.
    pub fn limbs_located(&self) -> usize {
        self.views.iter().map(|view| view.located).sum()
    }

    /// Whether something that was seen in an image tells of the limbs: a mask is a hint only.
    pub fn has_limbs(&self) -> bool {
        self.limbs_located() + self.segments_used() > 0
    }

    /// Whether lines tell of the radius beside the points: limbs, or the sides of a mask.
    pub fn has_lines(&self) -> bool {
        self.views.iter().any(|view| view.lines.is_some())
    }

    /// The paper's edge terms, by view.
    pub fn limb_terms(&self, data: &Data<'_>) -> impl Iterator<Item = Option<LimbTerm>> {
        let counts = self.edge_weight > 0.0;
        data.views.iter().map(move |view| view.limb_term().filter(|_| counts))
    }
}

/// Where an arc was located.
#[derive(Debug, Clone, Copy)]
pub(super) struct EndPosition {
    /// The middle of its circle, in the reference frame.
    middle: Vector3<f64>,
    blur: f64,
}

impl EndPosition {
    /// Of an arc on a cylinder in the reference frame.
    pub fn new(arc: &LastArc, cylinder: &Cylinder) -> Self {
        Self { middle: cylinder.axis.at(arc.position), blur: arc.blur }
    }

    /// The arc on another cylinder.
    pub fn on(&self, cylinder: &Cylinder) -> LastArc {
        LastArc { position: cylinder.axis.position_of(&self.middle), blur: self.blur }
    }
}

impl ViewConstraints {
    /// Whether the mask holds the body alone: such a mask gives arcs without far rims, and it does so about a cylinder that
    /// turned a little, too.
    pub fn is_whole(&self) -> bool {
        let mut ends = self.arcs.ends.iter().flatten();
        !self.arcs.ends.is_empty() && ends.all(|sample| sample.rim == Rim::Near)
    }

    /// Lines, of which some are given segments and some were located in the image.
    pub fn new(view: &ViewData<'_>, lines: &[PixelSegment], given: usize, located: usize) -> Self {
        let camera = view.camera().filter(|_| !lines.is_empty());
        let lines = camera.map(|camera| PixelTerm::new(lines.iter().copied(), camera.line_projection()));
        Self { index: view.index, lines, given, located, ..Self::default() }
    }
}

impl ViewData<'_> {
    /// The paper's edge term, where exactly two segments are usable.
    pub fn limb_term(&self) -> Option<LimbTerm> {
        let pair = self.edges.limb_pair()?;
        Some(LimbTerm::new(pair, self.camera()?.line_projection(), self.noise.endpoint))
    }
}

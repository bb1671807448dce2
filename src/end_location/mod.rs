//! Where the visible surface of a cylinder ends along its axis, and what its ends look like.
//!
//! The paper takes the extreme points completed over the mask, so that one stray pixel of the mask moves an end.
//! Here an end is located from all generators (lines of the surface along the axis) together, in three steps:
//!
//! 1. in the mask: where each generator leaves it, robustly averaged, and freed of the mask's bias, which shows
//!    at the limbs (`silhouette`);
//! 2. in the depth image: what lies beyond, from which the state of the end follows (`surroundings`);
//! 3. in the grey image: the arc of the end circle that bounds the visible surface (`arc`).
//!
//! Where the image shows an arc, both are joined by their variances.

mod arc;
mod border;
mod ending;
mod points;
mod silhouette;
mod surface;
mod surroundings;

use crate::camera::Camera;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::noise::ImageNoise;
use crate::observations::{DepthImage, GreyImage, Mask, PointCloud};
use crate::parts::{self, Parts};
use crate::statistics::{DEVIATION_OF_MEDIAN, median_absolute};
pub use arc::ArcSample;
use ending::Ending;
use nalgebra::Vector3;
pub use points::ends_of_points;
use silhouette::Silhouette;
pub(crate) use silhouette::contains;
use std::ops::ControlFlow;
use surface::Surface;
use surroundings::Surroundings;

#[cfg(feature = "sensitivity")]
/// The constants of the location of ends.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    let files = [
        CONSTANTS,
        arc::CONSTANTS,
        border::CONSTANTS,
        points::CONSTANTS,
        silhouette::CONSTANTS,
        surroundings::CONSTANTS,
    ];
    files.concat()
}

/// What an end of the visible cylinder is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndState {
    /// The surface ends there: what lies beyond is farther than the surface would be.
    Seen,
    /// The border of the image cuts the cylinder off.
    Cut,
    /// Something nearer than the surface covers what lies beyond.
    Hidden,
    /// No depth was measured beyond the end, or nothing tells what lies beyond.
    Unknown,
}

/// What the position of an end was taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EndSource {
    /// The extreme point completed over the mask: by the rule of the extremes, or where no generator ends in the mask.
    Extreme,
    /// Where the generators leave the mask, or where within the mask the depth shows that the body ends: at a cap, an opening, a
    /// shoulder or a narrower part. Also where the image shows an arc that is less certain than that.
    Mask,
    /// Mostly the arc of the end circle in the grey image: it is joined with mask and depth by the variances, and is the
    /// more certain.
    Image,
    /// The last of the surface inside the border of the image.
    Border,
    /// The points on the surface, where there is no mask, and from inside a pipe.
    Points,
}

/// What is known of what a mask holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MaskContent {
    /// Perhaps more than the lateral surface; the depth tells.
    Anything,
    /// The lateral surface alone.
    Body,
    /// The lateral surface alone, as a search found it: regions end at lids as well as at caps, so that far rims tell little.
    Region,
}

/// Where ends are looked for.
#[derive(Debug, Clone, Copy)]
pub struct EndSearch<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The mask of the visible surface.
    pub mask: &'a Mask,
    /// What is known of it.
    pub content: MaskContent,
    /// Whether it was drawn in the image, by a person or a network, and not made of the depth.
    pub drawn: bool,
    /// The depth image, which tells what an end is.
    pub depth: Option<&'a DepthImage>,
    /// The grey image, on the grid of the mask.
    pub image: Option<&'a GreyImage>,
    /// Depth differences up to this are noise, see [`depth_tolerance`].
    pub tolerance: f64,
    /// Whether the limbs of the cylinder are good to a fraction of a pixel, so that the bias of the mask may be
    /// read off at them.
    pub limbs_known: bool,
    /// What is known of mask and image.
    pub noise: ImageNoise,
    /// The blur of the grey image in pixels, where limbs show it.
    pub blur: Option<f64>,
    /// Where the arcs were in the last image of a sequence, against and along the direction of the axis: they are looked
    /// for there first.
    pub last: [Option<LastArc>; 2],
}

/// An end as it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct End {
    /// Position along the axis, from the axis point of the cylinder.
    pub position: f64,
    /// Standard deviation of the position, for a cylinder without error; `None` for an extreme.
    pub deviation: Option<f64>,
    /// What the end is.
    pub state: EndState,
    /// What the position was taken from.
    pub source: EndSource,
    /// Whether its circle may be wider than the body: the mask goes on beyond it, over a cap or an inner wall, or a lid or rim ends there.
    pub rim: bool,
    /// The samples of the arc in the grey image; none where the image did not show it.
    pub samples: List<ArcSample>,
    /// Samples on the far rim of the end, where mask or depth show the cap or the inner wall that it bounds.
    pub far_rim: List<ArcSample>,
    /// The arc by itself; `None` where the image did not show it.
    pub arc: Option<LastArc>,
    /// Of an end that the points alone show, the middle of the part of its circle beside which they lie, in the coordinates of the view.
    pub middle: Option<Vector3<f64>>,
}

/// An arc as the image shows it, from which the search in the next image of a sequence starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LastArc {
    /// Its position along the axis, from the axis point of the cylinder.
    pub position: f64,
    /// The blur with which the image shows it, in pixels of the image.
    pub blur: f64,
}

constants! {
    /// Stride over the rows and columns of the mask when bounding the search for the ends.
    BOUNDS_STRIDE = 2.0, "px";

    /// About how many points tell the noise of the depth.
    TOLERANCE_POINTS = 2000.0, "";

    /// A step of this part of the radius is a bead or a lid, not something in front of the cylinder.
    LEAST_TOLERANCE = 0.1, "radius";
}

/// The depth differences that are noise about a cylinder: three standard deviations, from the median so that
/// background among the points does not count.
#[must_use]
pub fn depth_tolerance(cloud: &PointCloud, cylinder: &Cylinder) -> f64 {
    let stride = cloud.len() / TOLERANCE_POINTS.count() + 1;
    let points = || (0..cloud.len()).step_by(stride).map(|index| cloud.point(index));
    let Cylinder { axis, radius } = cylinder;
    let least = LEAST_TOLERANCE.get() * radius;
    // Mostly more than half of them are so near that the median does not matter, short of rounding.
    let near = (1.0 - 1e-9) * least / (3.0 * DEVIATION_OF_MEDIAN);
    let [low, high] = [(radius - near).max(0.0), radius + near].map(|distance| distance * distance);
    let is_near = |point: &Vector3<f64>| {
        let distance = (point - axis.point).cross(&axis.direction).norm_squared();
        (low..=high).contains(&distance)
    };
    let enough = points().len() / 2;
    if points().filter(is_near).nth(enough).is_some() {
        return least;
    }
    let median = median_absolute(points().map(|point| cylinder.distance(&point)));
    (3.0 * DEVIATION_OF_MEDIAN * median).max(least)
}

/// The ends against and along the direction of the axis, located from all generators. From inside a pipe, which
/// shows no end circle, and on a mask without extent or ends along the axis they are the extremes. `None` when no ray of
/// the mask meets the cylinder. `check` is asked between the steps whether to go on.
pub fn locate_ends(
    search: &EndSearch<'_>,
    cylinder: &Cylinder,
    check: &mut dyn FnMut() -> ControlFlow<()>,
) -> ControlFlow<(), Option<[End; 2]>> {
    let at_extremes = |search| ControlFlow::Continue(extreme_ends(search, cylinder));
    let Some(surface) = Surface::new(search.camera, cylinder) else { return at_extremes(search) };
    let parts = search.depth.filter(|_| search.content == MaskContent::Anything).and_then(|depth| {
        Parts::new(search.camera, depth, search.mask, cylinder, &search.noise)
            .filter(|parts| !parts.all_body())
    });
    check()?;
    // Without an end all of it is.
    let ended = parts.as_ref().filter(|parts| parts.ends.iter().any(Option::is_some));
    let shown = ended.and_then(|parts| parts.shown(search.camera, search.mask, Parts::within));
    let whole = search.mask;
    let search = &EndSearch { mask: shown.as_ref().unwrap_or(whole), ..*search };
    let (told, collars) = parts.map_or_else(Default::default, |parts| (parts.ends, parts.collars));
    let Some(extremes) = rough_extremes(search, cylinder) else { return at_extremes(search) };
    check()?;
    // A region has the pixels that see the surface, which none beyond the limbs do.
    let has_bias = search.limbs_known && search.content != MaskContent::Region;
    let silhouette = Silhouette::new(surface, search.mask, extremes, search.noise, has_bias);
    let body = Ending { search, whole, surroundings: surroundings(search, cylinder), silhouette };
    let mut end = |k: usize| {
        check()?;
        let (told, last, outward) = (told[k].as_ref(), search.last[k], [-1.0, 1.0][k]);
        // What closes the body ends in a wider circle.
        let wider = collars.iter().find(|collar| collar.closes(k));
        let wider = wider.map(|collar| Cylinder { radius: collar.radius, ..*cylinder });
        let of_collar = wider.as_ref().and_then(|wider| {
            let surface = Surface::new(search.camera, wider)?;
            let silhouette = body.silhouette.wider(surface, rough_extremes(search, wider)?);
            Some(Ending { surroundings: surroundings(search, wider), silhouette, ..body })
        });
        let end = of_collar.as_ref().unwrap_or(&body).locate(told, outward, last);
        ControlFlow::Continue(End { rim: end.rim || wider.is_some(), ..end })
    };
    let ends = [end(0)?, end(1)?];
    // Ends that have passed each other are none: a mask of scattered pixels has no boundary across the axis.
    if ends[0].position < ends[1].position { ControlFlow::Continue(Some(ends)) } else { at_extremes(search) }
}

/// The paper's rule: the extreme positions along the axis of the points completed over the mask. `None` when no ray
/// of the mask meets the cylinder.
#[must_use]
pub fn extreme_ends(search: &EndSearch<'_>, cylinder: &Cylinder) -> Option<[End; 2]> {
    let (low, high) = extremes(search, cylinder, 1)?;
    let surroundings = surroundings(search, cylinder);
    Some([(low, -1.0), (high, 1.0)].map(|(position, outward)| extreme(position, outward, &surroundings)))
}

fn extreme(position: f64, outward: f64, surroundings: &Surroundings<'_>) -> End {
    End::new(position, None, surroundings.state(position, outward), EndSource::Extreme)
}

impl End {
    /// One without a rim, of which no image showed anything.
    fn new(position: f64, deviation: Option<f64>, state: EndState, source: EndSource) -> Self {
        let (samples, far_rim) = (List::new(), List::new());
        Self { position, deviation, state, source, rim: false, samples, far_rim, arc: None, middle: None }
    }
}

fn surroundings<'a>(search: &EndSearch<'a>, cylinder: &'a Cylinder) -> Surroundings<'a> {
    let EndSearch { camera, mask, drawn, depth, tolerance, noise, .. } = *search;
    Surroundings { camera, mask, depth, cylinder, tolerance, noise, drawn }
}

/// The least and the greatest position along the axis of the points completed over every `stride`-th row and
/// column of the mask.
fn extremes(search: &EndSearch<'_>, cylinder: &Cylinder, stride: usize) -> Option<(f64, f64)> {
    let pixels = search.mask.set_pixels_of_grid(stride);
    let [low, high] = parts::extremes(search.camera, cylinder, pixels);
    low.is_finite().then_some((low, high))
}

/// The extremes between which generators are followed, which need not be exact; `None` where there is no length.
fn rough_extremes(search: &EndSearch<'_>, cylinder: &Cylinder) -> Option<(f64, f64)> {
    extremes(search, cylinder, BOUNDS_STRIDE.count()).filter(|(low, high)| low < high)
}

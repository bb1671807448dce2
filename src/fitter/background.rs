//! Points that lie on a cylinder by chance.
//!
//! Outliers all about the axis of a narrow arc tell a radius of their own: a wrong cylinder that passes through a few of them, far from
//! the arc, costs the arc little. A surface is denser than what lies beside it. Sectors about the axis where the points on the cylinder
//! are not are background, and the fit is done again without them.

use super::view::View;
use crate::geometry::{Cylinder, LocalFrame};
use crate::observations::{ENOUGH_POINTS_TO_FIT, spread};
use crate::residuals::TUKEY_EFFICIENT;
use nalgebra::{Vector2, Vector3};

/// Sectors about an axis.
const SECTORS: usize = 72;

/// So many sectors to either side tell how dense the background of one is: outliers are few.
const BESIDE: usize = 12;

/// The background is counted up to so many times the distance from the surface within which points count.
const REACH: f64 = 8.0;

/// A surface has more points than the background lets expect by so many standard deviations of that number, and by one.
const BEYOND_CHANCE: f64 = 3.0;

/// A sector is told by as many to either side of it, too, as have so many points together where half of all points are.
const ENOUGH_TO_TELL: f64 = 10.0;

/// Sectors are thin that have less than this part of the points of those where half of all points are.
const HARDLY_ANY: f64 = 0.05;

/// Thin sectors are surface where they have more than so many times the points that the background lets expect in all of them, and so many
/// more: a fit is drawn to where chance has put a few.
const DRAWN: f64 = 3.0;
const LEAST_OF_THIN: f64 = 5.0;

/// Points that scatter this far from the surface, in radii, have nothing beside them.
const WIDEST: f64 = 0.25;

/// Where less than this part of the points on a cylinder is on its surface nothing tells what is background.
const LEAST_SURFACE: f64 = 0.5;

/// The sectors about a cylinder that hold its surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Surface {
    frame: LocalFrame,
    pub holds: [bool; SECTORS],
}

impl Surface {
    /// By the points of all views about a cylinder in the reference frame, which scatter by `scale` about it; `None` where all on the
    /// cylinder are on its surface.
    pub fn about<'a>(
        views: &(impl Iterator<Item = &'a View> + Clone),
        cylinder: &Cylinder,
        scale: f64,
    ) -> Option<Self> {
        let frame = LocalFrame::new(cylinder, &cylinder.axis.point, 1.0);
        let within = TUKEY_EFFICIENT * scale;
        if within > WIDEST * cylinder.radius {
            return None;
        }
        let most = ENOUGH_POINTS_TO_FIT / views.clone().count();
        let (mut on, mut beside) = ([0.0; SECTORS], [0.0; SECTORS]);
        for view in views.clone() {
            let seen = frame.moved(&view.pose().inverse());
            // Of very many a part that no length of rows is in step with.
            for index in spread(view.cloud.len(), most) {
                let position = Position::new(&seen, &view.cloud.point(index));
                if position.distance <= within {
                    on[position.sector()] += 1.0;
                } else if position.distance <= REACH * within {
                    beside[position.sector()] += 1.0;
                }
            }
        }
        let typical = typical(on);
        let is_thin = |sector: &usize| on[*sector] <= HARDLY_ANY * typical;
        // Beside a surface are points of its own as well, where noise has tails.
        if !(0..SECTORS).filter(is_thin).any(|sector| beside[sector] > 0.0) {
            return None;
        }
        let share = share_within(cylinder.radius, within);
        let expected = |sector: usize| share * background(&beside, sector);
        let thin = (0..SECTORS).filter(is_thin).map(|sector| Vector2::new(on[sector], expected(sector)));
        let thin: Vector2<f64> = thin.sum();
        let thin_are_surface = thin.x > DRAWN * thin.y + LEAST_OF_THIN;
        let reach = ((ENOUGH_TO_TELL / typical - 1.0) / 2.0).ceil().clamp(0.0, BESIDE as f64) as usize;
        let holds = std::array::from_fn(|sector| {
            let expected = expected(sector) * (2 * reach + 1) as f64;
            let is_dense = around(&on, sector, reach) > expected + BEYOND_CHANCE * expected.sqrt() + 1.0;
            is_dense && (thin_are_surface || !is_thin(&sector))
        });
        let all: f64 = on.iter().sum();
        let of_surface: f64 = on.iter().zip(holds).map(|(on, holds)| if holds { *on } else { 0.0 }).sum();
        (of_surface < all && of_surface >= LEAST_SURFACE * all).then_some(Self { frame, holds })
    }

    /// The view with the points of these sectors alone.
    pub fn of(&self, view: &View) -> View {
        let seen = self.frame.moved(&view.pose().inverse());
        let holds = |index| self.holds[Position::new(&seen, &view.cloud.point(index)).sector()];
        view.with_points(view.cloud.chosen(holds), view.body.clone())
    }
}

/// Where a point is about a cylinder.
struct Position {
    /// Across the axis.
    across: [f64; 2],
    /// From the surface.
    distance: f64,
}

impl Position {
    fn new(frame: &LocalFrame, point: &Vector3<f64>) -> Self {
        let aside = point - frame.cylinder.axis.point;
        let [x, y] = [aside.dot(&frame.u), aside.dot(&frame.v)];
        Self { across: [x, y], distance: ((x * x + y * y).sqrt() - frame.cylinder.radius).abs() }
    }

    fn sector(&self) -> usize {
        let [x, y] = self.across;
        // Around a square in place of a circle, which takes no arc tangent.
        let along = x / (x.abs() + y.abs());
        let turns = if y < 0.0 { 3.0 + along } else { 1.0 - along } / 4.0;
        ((turns * SECTORS as f64) as usize).min(SECTORS - 1)
    }
}

/// How many points of the background are within a distance of the surface, for each that is beside it: both are in rings about the axis.
fn share_within(radius: f64, within: f64) -> f64 {
    let ring = |distance: f64| (radius + distance).powi(2) - (radius - distance).max(0.0).powi(2);
    ring(within) / (ring(REACH * within) - ring(within))
}

/// The number of points beside the surface in a sector as those around it tell it, but no fewer than in all of them on average.
fn background(beside: &[f64; SECTORS], sector: usize) -> f64 {
    let mean = |sum: f64, count: usize| sum / count as f64;
    mean(around(beside, sector, BESIDE), 2 * BESIDE + 1).max(mean(beside.iter().sum(), SECTORS))
}

/// How many points are in a sector and as many as `reach` to either side.
fn around(counts: &[f64; SECTORS], sector: usize, reach: usize) -> f64 {
    (0..=2 * reach).map(|k| counts[(sector + SECTORS + k - reach) % SECTORS]).sum()
}

/// How many points are in a sector, for half of them at least.
fn typical(mut on: [f64; SECTORS]) -> f64 {
    on.sort_unstable_by(f64::total_cmp);
    let half = on.iter().sum::<f64>() / 2.0;
    let mut below = 0.0;
    let is_half = |on: &&f64| {
        below += **on;
        below >= half
    };
    on.iter().find(is_half).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitter::Fitter;
    use crate::observations::PointsView;
    use crate::statistics::random_number as number;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    /// Points on an arc of a cylinder of radius 1, with noise, and outliers in a box about it.
    fn points(seed: u64, arc: f64, count: usize, outliers: usize) -> Vec<[f64; 3]> {
        let rng = &mut ChaCha8Rng::seed_from_u64(seed);
        let noise = |rng: &mut ChaCha8Rng| 0.01 * (0..3).map(|_| number(rng)).sum::<f64>();
        let of_arc = |_| {
            let angle = arc.to_radians() * number(rng) / 2.0;
            let radius = 1.0 + noise(rng);
            [radius * angle.cos(), radius * angle.sin(), 5.0 + 2.0 * number(rng)]
        };
        let mut points: Vec<[f64; 3]> = (0..count).map(of_arc).collect();
        points.extend((0..outliers).map(|_| [1.5 * number(rng), 1.5 * number(rng), 5.0 + 2.0 * number(rng)]));
        points
    }

    fn of(points: &[[f64; 3]]) -> Fitter {
        let mut fitter = Fitter::new();
        fitter.push_points(&PointsView::from_f64(points), None).unwrap();
        fitter
    }

    fn arc(seed: u64, arc: f64, count: usize, outliers: usize) -> Fitter {
        of(&points(seed, arc, count, outliers))
    }

    #[test]
    fn outliers_all_about_the_axis_do_not_tell_the_radius_of_an_arc() {
        for (degrees, outliers) in [(40.0, 20), (40.0, 50), (60.0, 100), (60.0, 300)] {
            for seed in 0..4 {
                let alone = arc(seed, degrees, 1000, 0).fit().unwrap();
                let among = arc(seed, degrees, 1000, outliers).fit().unwrap();
                let [stated, found] = [alone, among].map(|fit| fit.uncertainty.unwrap().radius());
                let off = (among.cylinder.radius - alone.cylinder.radius).abs();
                assert!(off < stated, "{degrees}° {outliers} {seed}: {off} {stated}");
                assert!((found / stated - 1.0).abs() < 0.5, "{degrees}° {outliers} {seed}: {found} {stated}");
            }
        }
    }

    #[test]
    fn without_background_a_few_points_elsewhere_are_surface() {
        let cylinder = Cylinder::new(Vector3::zeros(), Vector3::z(), 1.0).unwrap();
        let mut fitter = arc(1, 60.0, 1000, 0);
        let back: Vec<[f64; 3]> = (0..3).map(|k| [-1.0, 0.0, 0.1 * f64::from(k)]).collect();
        fitter.push_points(&PointsView::from_f64(&back), None).unwrap();
        assert_eq!(Surface::about(&[fitter.view()].into_iter(), &cylinder, 0.01), None);
        // One point beside the surface, and these may be there by chance.
        fitter.push_points(&PointsView::from_f64(&[[0.0, 1.1, 0.0]]), None).unwrap();
        let surface = Surface::about(&[fitter.view()].into_iter(), &cylinder, 0.01).unwrap();
        assert_eq!(surface.of(fitter.view()).cloud.len(), 1000);
    }

    #[test]
    fn a_thin_surface_is_no_background_where_there_are_more_points_than_chance_has() {
        let mut fitter = arc(1, 40.0, 2000, 20);
        let on_surface = |k: u32| {
            let angle = 2.4 * f64::from(k);
            [angle.cos(), angle.sin(), 3.0 + 0.02 * f64::from(k)]
        };
        let thin: Vec<[f64; 3]> = (0..200).map(on_surface).collect();
        fitter.push_points(&PointsView::from_f64(&thin), None).unwrap();
        let fit = fitter.fit().unwrap();
        assert!(fit.uncertainty.unwrap().radius() < 0.002, "{:?}", fit.uncertainty);
        assert!((fit.cylinder.radius - 1.0).abs() < 0.005, "{:?}", fit.cylinder);
    }

    /// On a ring that is far shorter than wide another search for a start may end at a cylinder across it.
    #[test]
    fn a_fit_without_background_that_is_worse_is_not_taken() {
        for seed in [5, 9, 18] {
            let mut ring = points(seed, 60.0, 2700, 60);
            ring.iter_mut().for_each(|[_, _, z]| *z = 5.0 + 0.025 * (*z - 5.0));
            let axis = of(&ring).fit().unwrap().cylinder.axis;
            assert!(axis.direction.z.abs() > 0.9, "{seed}: {axis:?}");
        }
    }

    /// Every hundredth point of rows of a hundred is of the same column.
    #[test]
    fn rows_of_an_organised_cloud_are_not_sampled_in_step() {
        let rng = &mut ChaCha8Rng::seed_from_u64(5);
        let mut points: Vec<[f64; 3]> = Vec::new();
        for row in 0..2000 {
            for column in 0..100 {
                let angle = 0.02 * f64::from(column);
                let radius = 1.0 + 0.01 * number(rng);
                points.push([radius * angle.cos(), radius * angle.sin(), 3.0 + 0.002 * f64::from(row)]);
            }
        }
        for k in 0..1000 {
            points[199 * k] = [1.5 * number(rng), 1.5 * number(rng), 5.0 + 2.0 * number(rng)];
        }
        let fit = of(&points).fit().unwrap();
        assert!((fit.cylinder.radius - 1.0).abs() < 1e-3, "{:?}", fit.cylinder);
        assert!(fit.points_used > 190_000, "{}", fit.points_used);
    }

    #[test]
    fn no_surface_is_told_where_background_is_all_there_is() {
        let cylinder = Cylinder::new(Vector3::zeros(), Vector3::z(), 1.0).unwrap();
        let fitter = arc(1, 60.0, 20, 5000);
        assert_eq!(Surface::about(&[fitter.view()].into_iter(), &cylinder, 0.05), None);
        // Nor where some sectors have nothing on the cylinder.
        let mut points = points(1, 60.0, 20, 5000);
        points.retain(|[x, y, _]| *x > 0.0 || y.abs() > 0.3 || (x.hypot(*y) - 1.0).abs() > 0.05);
        let fitter = of(&points);
        assert_eq!(Surface::about(&[fitter.view()].into_iter(), &cylinder, 0.01), None);
    }

    #[test]
    fn few_points_are_surface_where_a_sector_holds_one() {
        for seed in 0..4 {
            let fit = arc(seed, 360.0, 100, 20).fit().unwrap();
            assert!(fit.points_used >= 100, "{seed}: {}", fit.points_used);
        }
    }

    #[test]
    fn rings_about_an_axis_hold_as_much_background_as_they_are_large() {
        assert!((share_within(1.0, 0.01) - 1.0 / 7.0).abs() < 1e-12);
        // Within 4 of a radius of 1 is all about the axis.
        assert!((share_within(1.0, 0.5) - 2.0 / (25.0 - 2.0)).abs() < 1e-12);
    }
}

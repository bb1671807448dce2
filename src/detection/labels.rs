//! Which pixels see the cylinders that were found.

use super::distances::{LANES, across, difference, dot, first_hits, lanes, residual, splat, times};
use super::effort::Effort;
use super::grid::Grid;
use super::rays::Band;
use super::row::{Points, Rays};
use super::search::Judged;
use super::surface::{REACH, Surface};
use super::{Detection, Detections};
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::statistics::min_max_of;
use nalgebra::Vector3;
use pulp::{Arch, Simd, WithSimd};

constants! {
    /// How much noisier a pixel is than the noisiest cell of its cylinder.
    NOISE = 1.5, "σ";
}

/// Rows of the image that are given to a cylinder between two questions whether to go on: some milliseconds.
const ROWS_BETWEEN_QUESTIONS: usize = 64;

/// Counts the pixels or points with the labels of cylinders.
pub(super) fn count_pixels(cylinders: &mut [Detection], labels: &[u16]) {
    cylinders.iter_mut().for_each(|detection| detection.pixels = 0);
    for &label in labels.iter().filter(|&&label| label != 0) {
        cylinders[usize::from(label) - 1].pixels += 1;
    }
}

/// The pixels of each cylinder: those within its outline between its ends that see its surface, or nothing. Where the search is
/// stopped they are of no use.
pub(super) fn label(
    grid: &Grid,
    found: &[Judged],
    (width, height): (usize, usize),
    pixel: f64,
    read_points: &Points<'_>,
    read_rays: &Rays<'_>,
    effort: &Effort<'_>,
) -> Detections {
    let mut labels = vec![0_u16; width * height];
    let mut nearest = vec![f32::INFINITY; width * height];
    let mut cylinders = Vec::new();
    let (mut rays, mut points) = (<[List<f64>; 2]>::default(), <[List<f64>; 3]>::default());
    let (mut excesses, mut misfits) = (List::new(), List::new());
    for (index, judged) in found.iter().enumerate() {
        if effort.ask() {
            break;
        }
        let surface = &judged.candidate.surface;
        let Surface::Cylinder(cylinder, _) = surface else { continue };
        let cells = || judged.candidate.cells.iter().map(|&k| &grid.cells[k]);
        let [first, last] = min_max_of(cells().map(|cell| surface.project(&cell.point).along));
        let depth = cells().map(|cell| cell.point.z).fold(0.0, f64::max);
        let sigma = cells().map(|cell| cell.sigma).fold(0.0, f64::max);
        let body = Band::new(cylinder, 1.0);
        let pad = 0.5 * grid.spacing * depth;
        let range = [first - pad, last + pad];
        let margin = 2 + (cylinder.radius / (grid.spacing * depth)).min(grid.columns as f64) as usize;
        let [columns, rows] = grid.around(&judged.candidate.cells, margin);
        let columns = columns.start * grid.side..(columns.end * grid.side).min(width);
        for y in rows.start * grid.side..(rows.end * grid.side).min(height) {
            // One cylinder may fill the image.
            if y % ROWS_BETWEEN_QUESTIONS == 0 && effort.ask() {
                break;
            }
            read_rays(y, columns.clone(), &mut rays);
            body.excesses(&rays[0], &rays[1], &mut excesses);
            let within = |excess: &f64| *excess < 0.0;
            let (Some(left), Some(right)) =
                (excesses.iter().position(within), excesses.iter().rposition(within))
            else {
                continue;
            };
            // Only of those between is it asked where along the axis.
            read_points(y, columns.start + left..columns.start + right + 1, &mut points);
            let rays = [&rays[0][left..=right], &rays[1][left..=right]];
            let of_row =
                OfRow { surface, cylinder, pixel, sigma: NOISE.get() * sigma, range, rays, points: &points };
            misfits.resize(right - left + 1, 0.0);
            Arch::new().dispatch(Misfits { of_row, misfits: &mut misfits });
            let row = y * width + columns.start + left..y * width + columns.start + right + 1;
            let pixels = labels[row.clone()].iter_mut().zip(&mut nearest[row]);
            for ((label, nearest), (misfit, excess)) in pixels.zip(misfits.iter().zip(&excesses[left..])) {
                if *misfit <= REACH.get() as f32 && *excess < 0.0 && *misfit < *nearest {
                    *nearest = *misfit;
                    *label = index as u16 + 1;
                }
            }
        }
        cylinders.push(Detection {
            cylinder: *cylinder,
            score: judged.score,
            pixels: 0,
            along: [first, last],
            evidence: judged.evidence,
        });
    }
    count_pixels(&mut cylinders, &labels);
    Detections {
        cylinders,
        labels,
        cut_short: effort.is_cut_short(),
        visits: effort.visits(),
        seen_from: Some(Vector3::zeros()),
        whole: true,
        independent: false,
        image: None,
        shift: None,
    }
}

/// Pixels side by side, and the cylinder that they may see.
struct OfRow<'a> {
    surface: &'a Surface,
    cylinder: &'a Cylinder,
    pixel: f64,
    /// Standard deviation of the depth.
    sigma: f64,
    /// Where the cylinder begins and ends along its axis.
    range: [f64; 2],
    rays: [&'a [f64]; 2],
    points: &'a [List<f64>; 3],
}

/// One pass over pixels: how far the points that they see lie from the surface, in standard deviations, [`REACH`] for those that
/// see nothing, and infinite where the ray does not meet the cylinder between its ends.
struct Misfits<'a> {
    of_row: OfRow<'a>,
    misfits: &'a mut [f32],
}

impl WithSimd for Misfits<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { of_row: OfRow { surface, cylinder, pixel, sigma, range, rays, points }, misfits } = self;
        let (zero, one) = (simd.splat_f32s(0.0), simd.splat_f32s(1.0));
        let (nothing, beyond) = (simd.splat_f32s(REACH.get() as f32), simd.splat_f32s(f32::INFINITY));
        let (low, high) = (simd.splat_f32s(range[0] as f32), simd.splat_f32s(range[1] as f32));
        let sigma = simd.splat_f32s(sigma as f32);
        for (group, misfits) in misfits.chunks_mut(LANES).enumerate() {
            let (first, count) = (group * LANES, misfits.len());
            let mut numbers = [[0.0_f32; LANES]; 5];
            let lists = [rays[0], rays[1], &points[0], &points[1], &points[2]];
            for (numbers, list) in numbers.iter_mut().zip(lists) {
                // Of a known length they are converted side by side.
                match list[first..].first_chunk() {
                    Some(group) => *numbers = group.map(|number: f64| number as f32),
                    None => {
                        let some = numbers.iter_mut().zip(&list[first..first + count]);
                        some.for_each(|(number, given)| *number = *given as f32);
                    }
                }
            }
            let mut found = [0.0; LANES];
            for part in 0..LANES / S::F32_LANES {
                let (x, y) = (lanes(simd, &numbers[0], part), lanes(simd, &numbers[1], part));
                let z = lanes(simd, &numbers[4], part);
                let point = [lanes(simd, &numbers[2], part), lanes(simd, &numbers[3], part), z];
                let residual = residual(simd, surface, pixel, point, [x, y], sigma);
                let misfit =
                    simd.mul_f32s(simd.abs_f32s(residual.distance), simd.sqrt_f32s(residual.information));
                let misfit = simd.select_f32s(simd.greater_than_f32s(z, zero), misfit, nothing);
                let along = meets(simd, cylinder, [x, y, one]);
                let misfit = simd.select_f32s(simd.less_than_f32s(along, low), beyond, misfit);
                let misfit = simd.select_f32s(simd.greater_than_f32s(along, high), beyond, misfit);
                S::as_mut_simd_f32s(&mut found).0[part] = misfit;
            }
            misfits.copy_from_slice(&found[..count]);
        }
    }
}

/// Where rays meet a cylinder along its axis, or pass it: [`meets`](super::rays::meets), side by side.
#[inline(always)]
fn meets<S: Simd>(simd: S, cylinder: &Cylinder, ray: [S::f32s; 3]) -> S::f32s {
    let (point, d) = (splat(simd, &cylinder.axis.point), splat(simd, &cylinder.axis.direction));
    let across = across(simd, ray, d);
    let passing = simd.div_f32s(dot(simd, across, point), dot(simd, across, across));
    let hit = first_hits(simd, cylinder, ray);
    let t = simd.select_f32s(simd.greater_than_f32s(hit, simd.splat_f32s(0.0)), hit, passing);
    dot(simd, difference(simd, times(simd, ray, t), point), d)
}

#[cfg(test)]
mod tests {
    use super::super::rays;
    use super::*;
    use nalgebra::Vector3;
    use pulp::Scalar;

    #[test]
    fn rays_meet_as_one_by_one() {
        let outside =
            Cylinder::new(Vector3::new(0.1, -0.05, 0.8), Vector3::new(0.3, 0.9, 0.2), 0.06).unwrap();
        let around = Cylinder::new(Vector3::new(0.0, 0.0, 0.1), Vector3::new(0.1, 0.0, 1.0), 0.3).unwrap();
        let behind = Cylinder::new(Vector3::new(0.1, 0.0, -0.8), Vector3::y(), 0.06).unwrap();
        for cylinder in [outside, around, behind] {
            for k in 0..40 {
                let (x, y) = (0.02 * f64::from(k) - 0.4, 0.01 * f64::from(k * k % 17));
                let one = rays::meets(&cylinder, &Vector3::new(x, y, 1.0));
                let found = f64::from(meets(Scalar, &cylinder, [x as f32, y as f32, 1.0]));
                assert!((found - one).abs() <= 1e-4 * one.abs().max(1.0), "{found} {one}");
            }
        }
    }
}

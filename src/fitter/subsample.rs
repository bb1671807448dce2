//! Of very many points a part leads to the minimum, and all of them end the fit there: the sums over a part cost less, and
//! tell the minimum to what its own noise allows.

use super::correlation::Lattice;
use super::data::{Data, ViewData};
use super::view::View;
use crate::geometry::LocalFrame;
use crate::memory::List;
use crate::observations::{ENOUGH_POINTS_TO_FIT, PointCloud, are_many};
use crate::residuals::PointTerm;
use crate::statistics::{
    beside, bounds_of_median_absolute, median_absolute, median_absolute_between, order_statistics,
};
use nalgebra::Vector3;

/// Fewest rows of neighbours in a band, of as many as there are in a square: correlation is looked for over a third of them.
const ROWS_OF_BAND: f64 = 33.0;

/// Points that tell between which numbers their median distance lies.
const SAMPLE: usize = 4096;

/// Points whose noise tells how neighbours are correlated, with their grid.
#[derive(Debug, Clone)]
pub(super) struct Neighbours {
    // In lists of one or none, as views hold these, and views are moved on the stack.
    /// Some of very many points, spread over all; none for all.
    part: List<PointCloud>,
    /// The same, all within one band.
    band: List<PointCloud>,
    /// `None` where it is that of a surface, or there is none.
    lattice: Option<Lattice>,
}

impl Neighbours {
    pub fn new(cloud: &PointCloud, observed: bool) -> Self {
        let part: List<PointCloud> =
            are_many(cloud.len()).then(|| cloud.spread(ENOUGH_POINTS_TO_FIT)).into_iter().collect();
        let band: List<PointCloud> = part.iter().map(|part| middle_band(cloud, part)).collect();
        let lattice = Lattice::of_cloud(band.first().unwrap_or(cloud), observed);
        Self { part, band, lattice }
    }

    /// The points that are spread over all, where there are very many.
    pub fn part(&self) -> Option<&PointCloud> {
        self.part.first()
    }

    /// The points of a view whose residuals tell it.
    pub fn cloud<'a>(&'a self, view: &'a ViewData<'_>) -> &'a PointCloud {
        self.band.first().unwrap_or(&view.view.cloud)
    }

    /// The points of the band, where there is one.
    pub fn band(&self) -> Option<PointTerm<'_>> {
        Some(PointTerm::new(self.band.first()?, None))
    }

    /// The number of independent points of a view about a surface, in the frame of the view, by the residuals of the band or
    /// of all points.
    pub fn independent_points(
        &self,
        view: &ViewData<'_>,
        frame: &LocalFrame,
        residuals: &[f64],
        cutoff: f64,
    ) -> f64 {
        let cloud = self.cloud(view);
        let of_surface = if self.lattice.is_none() { Lattice::on_surface(cloud, frame) } else { None };
        let independent = match self.lattice.as_ref().or(of_surface.as_ref()) {
            Some(lattice) => lattice.independent_points(residuals, cutoff),
            None => residuals.len() as f64,
        };
        independent * (view.stands_for as f64 / residuals.len() as f64)
    }
}

/// The upper median of the distances of many points of a view from a surface, in the frame of the view, which may be about
/// known: that changes nothing but the time.
pub(super) fn median_distance(view: &ViewData<'_>, frame: &LocalFrame, near: Option<f64>) -> f64 {
    let cloud = &view.view.cloud;
    let between = |bounds| {
        let blocks = |receive: &mut dyn FnMut(&[f64])| view.points.distances_by_blocks(frame, receive);
        median_absolute_between(bounds, cloud.len(), blocks)
    };
    let by_sample = || {
        let sample = cloud.spread(SAMPLE);
        bounds_of_median_absolute(PointTerm::new(&sample, None).distances(frame).into_iter())
            .and_then(between)
    };
    near.and_then(|near| between(beside(near)))
        .or_else(by_sample)
        .unwrap_or_else(|| median_absolute(view.points.distances(frame).into_iter()))
}

/// The points in the middle of the length of a cloud, by a sample: neighbours stay neighbours, and all of an arc takes part.
fn middle_band(cloud: &PointCloud, sample: &PointCloud) -> PointCloud {
    let (_, covariance) = sample.mean_and_covariance().unwrap_or_default();
    let spreads = covariance.symmetric_eigen();
    let length: Vector3<f64> = spreads.eigenvectors.column(spreads.eigenvalues.imax()).into();
    let along = |point: Vector3<f64>| (point - cloud.origin()).dot(&length);
    let count = cloud.len() as f64;
    let part = (ENOUGH_POINTS_TO_FIT as f64 / count).max(ROWS_OF_BAND / count.sqrt());
    let last = (sample.len() - 1) as f64;
    let ranks = [0.5 - 0.5 * part, 0.5 + 0.5 * part].map(|quantile| (quantile * last).round() as usize);
    let band = cloud.between(&length, order_statistics(sample.points().map(along), ranks));
    // Where coordinates are so large that their squares overflow there is no band.
    if band.is_empty() { sample.clone() } else { band }
}

impl Data<'_> {
    /// The views with a part of their points, where there are very many.
    pub fn views_of_subsample(&self) -> Option<List<View>> {
        let count = self.count();
        are_many(count).then(|| {
            let part = ENOUGH_POINTS_TO_FIT as f64 / count as f64;
            self.views.iter().map(|view| view.view.with_part(part)).collect()
        })
    }

    /// The same data with the points of these views, which stand for all.
    pub fn of_subsample<'a>(&'a self, views: &'a [View]) -> Data<'a> {
        let view = |(of_all, view): (&'a ViewData<'_>, &'a View)| ViewData {
            view,
            points: of_all.points.of(&view.cloud),
            edges: of_all.edges.clone(),
            ..*of_all
        };
        Data { views: self.views.iter().zip(views).map(view).collect(), ..*self }
    }
}

impl View {
    /// The same view with a part of its points.
    fn with_part(&self, part: f64) -> Self {
        let count = self.cloud.len();
        let size = ((count as f64 * part) as usize).max(count.min(ENOUGH_POINTS_TO_FIT / 10));
        self.with_points(self.cloud.spread(size), self.body.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fitter::Fitter;
    use crate::geometry::Cylinder;
    use crate::observations::{PointsView, Scalar, Strided, VectorsView};
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    const COLUMNS: usize = 300;
    const ROWS: usize = 400;
    /// Pixels along a row that share their noise.
    const ALIKE: usize = 4;

    /// A grid of points on the near half of a cylinder, each with the mean noise of some neighbours.
    fn grid(truth: &Cylinder, noise: f64) -> Vec<[f64; 3]> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut next = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
        let mut points = Vec::with_capacity(ROWS * COLUMNS);
        for row in 0..ROWS {
            let errors: Vec<f64> = (0..COLUMNS + ALIKE).map(|_| next()).collect();
            for column in 0..COLUMNS {
                let error = noise * errors[column..column + ALIKE].iter().sum::<f64>();
                let angle = (column as f64 / COLUMNS as f64 - 0.5) * 2.6;
                let radius = truth.radius + error;
                let point = truth.axis.point + Vector3::y() * (0.3 * row as f64 / ROWS as f64 - 0.15);
                points.push((point + Vector3::new(angle.sin(), 0.0, -angle.cos()) * radius).into());
            }
        }
        points
    }

    fn truth() -> Cylinder {
        Cylinder::new(Vector3::new(0.01, 0.02, 0.8), Vector3::y(), 0.04).unwrap()
    }

    fn fitter(points: &[[f64; 3]]) -> Fitter {
        let mut fitter = Fitter::new();
        let bytes: Vec<u8> = points.iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
        let size = (COLUMNS, points.len() / COLUMNS);
        let grid = Strided::new(&bytes, 0, size, 24, (24, 24 * COLUMNS as isize)).unwrap();
        let view = PointsView { points: VectorsView::new(grid, Scalar::F64), weights: None, normals: None };
        fitter.push_points(&view, None).unwrap();
        fitter
    }

    #[test]
    fn a_band_is_in_the_middle_and_its_noise_is_correlated_as_that_of_all() {
        let points = grid(&truth(), 1e-3);
        let fitter = fitter(&points);
        let cloud = fitter.cloud();
        let band = middle_band(cloud, &cloud.spread(ENOUGH_POINTS_TO_FIT));
        assert!((ENOUGH_POINTS_TO_FIT..2 * ENOUGH_POINTS_TO_FIT).contains(&band.len()), "{}", band.len());
        let mean = band.points().sum::<Vector3<f64>>() / band.len() as f64;
        assert!((mean.y - 0.02).abs() < 1e-3, "{mean}");
        let frame = LocalFrame::new(&truth(), &truth().axis.point, 1.0);
        let [of_band, of_all] = [&band, cloud].map(|cloud| {
            let residuals = PointTerm::new(cloud, None).distances(&frame);
            let lattice = Lattice::of_cloud(cloud, false).unwrap();
            lattice.independent_points(&residuals, 1.0) / cloud.len() as f64
        });
        // Neighbours at k of 4 pixels have the correlation 1 - k / 4.
        assert!((of_all * ALIKE as f64 - 1.0).abs() < 0.05, "{of_all}");
        assert!((of_band / of_all - 1.0).abs() < 0.1, "{of_band} {of_all}");
    }

    #[test]
    fn very_many_points_end_at_the_minimum_of_all_from_wherever_they_start() {
        let points = grid(&truth(), 1e-3);
        let mut fitter = fitter(&points);
        let result = fitter.fit().unwrap();
        let deviation = result.uncertainty.unwrap().radius();
        assert!((result.cylinder.radius - 0.04).abs() < 4.0 * deviation);
        let independent = points.len() as f64 / ALIKE as f64;
        assert!((result.independent_points / independent - 1.0).abs() < 0.1, "{}", result.independent_points);
        assert_eq!(result.points_used, points.len());
        // Other points lead there, and another start.
        let reversed: Vec<[f64; 3]> = points.iter().rev().copied().collect();
        let mut other = self::fitter(&reversed);
        other.set_start(Some(Cylinder::new(Vector3::new(0.0, 0.0, 0.8), Vector3::y(), 0.045).unwrap()));
        let other = other.fit().unwrap();
        assert!((other.cylinder.radius - result.cylinder.radius).abs() < 1e-3 * deviation);
        // A part of them has a minimum of its own.
        let mut part = self::fitter(&points[..2 * ENOUGH_POINTS_TO_FIT / COLUMNS * COLUMNS]);
        let part = part.fit().unwrap();
        assert!((part.cylinder.radius - result.cylinder.radius).abs() > 1e-2 * deviation);
    }

    #[test]
    fn the_median_distance_of_many_is_that_of_their_list() {
        let points = grid(&truth(), 1e-3);
        let fitter = fitter(&points);
        let data = fitter.data().unwrap();
        let mut moved = truth();
        moved.axis.point.x += 1e-3;
        let frame = LocalFrame::new(&moved, &moved.axis.point, 1.0);
        let distances = data.views[0].points.distances(&frame);
        let limit = median_absolute(distances.iter().copied());
        for near in [None, Some(limit), Some(0.99 * limit), Some(1.1 * limit), Some(0.0), Some(f64::NAN)] {
            assert_eq!(median_distance(&data.views[0], &frame, near), limit);
        }
        let within = distances.iter().filter(|distance| distance.abs() <= limit).count();
        assert_eq!(data.views[0].points.count_within(&frame, limit), within);
    }
}

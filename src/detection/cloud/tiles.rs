//! Cubes that a cloud is cut into.

use super::STRAY;
use crate::observations::PointsView;
use nalgebra::Vector3;

/// Fewest points of a tile: fewer show no body.
const FEWEST: usize = 500;

/// The numbers of the points of each tile of a cloud, an edge being 2^-level of the longest of its box. Tiles are laid half an edge off the
/// box: no border is one at another level.
pub(super) fn of(points: &PointsView<'_>, level: u32) -> Vec<Vec<u32>> {
    let (width, height) = (points.width(), points.height());
    let all = || {
        let of_row = |row| (0..width).map(move |column| (column, row));
        (0..height).flat_map(of_row).map(|(column, row)| points.points.at(column, row))
    };
    let range = [0, 1, 2].map(|axis| {
        let mut values: Vec<f64> = all().map(|point| point[axis]).filter(|x| x.is_finite()).collect();
        if values.is_empty() {
            return [0.0; 2];
        }
        let stray = (STRAY * values.len() as f64) as usize;
        let last = values.len() - 1 - stray;
        [stray, last].map(|place| *values.select_nth_unstable_by(place, f64::total_cmp).1)
    });
    let edge = range.iter().map(|[low, high]| high - low).fold(0.0, f64::max) / f64::from(1_u32 << level);
    if edge <= 0.0 {
        return Vec::new();
    }
    let count = (1_usize << level) + 1;
    let tile = |point: Vector3<f64>| {
        let place = |axis: usize| (point[axis] - range[axis][0]) / edge + 0.5;
        let at = [0, 1, 2].map(place);
        let inside = at.iter().all(|x| (0.0..count as f64).contains(x));
        inside.then(|| at.iter().fold(0, |number, x| number * count + *x as usize))
    };
    let mut tiles = vec![Vec::new(); count.pow(3)];
    for (k, point) in (0..).zip(all()) {
        if let Some(tile) = tile(point) {
            tiles[tile].push(k);
        }
    }
    tiles.retain(|numbers| numbers.len() >= FEWEST);
    tiles
}

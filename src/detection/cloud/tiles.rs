//! Cubes that a cloud is cut into.

use super::{Asked, STRAY};
use crate::error::Result;
use crate::observations::PointsView;
use crate::statistics::at_both_ends;
use nalgebra::Vector3;

/// Fewest points of a tile: fewer show no body.
const FEWEST: usize = 500;

/// The numbers of the points of each tile of a cloud, an edge being 2^-level of the longest of its box. Tiles are laid half an edge off the
/// box: no border is one at another level.
pub(super) fn of(points: &PointsView<'_>, level: u32, asked: &Asked<'_>) -> Result<Vec<Vec<u32>>> {
    let (width, height) = (points.width(), points.height());
    let all = || {
        let of_row = |row| (0..width).map(move |column| (column, row));
        (0..height).flat_map(of_row).map(|(column, row)| points.points.at(column, row))
    };
    let mut range = [[0.0; 2]; 3];
    for (axis, range) in range.iter_mut().enumerate() {
        let values: Vec<f64> = all().map(|point| point[axis]).filter(|x| x.is_finite()).collect();
        if values.is_empty() {
            return Ok(Vec::new());
        }
        *range = at_both_ends(&values, (STRAY * values.len() as f64) as usize);
        asked()?;
    }
    let edge = range.iter().map(|[low, high]| high - low).fold(0.0, f64::max) / f64::from(1_u32 << level);
    if edge <= 0.0 {
        return Ok(Vec::new());
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
    asked()?;
    tiles.retain(|numbers| numbers.len() >= FEWEST);
    Ok(tiles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::statistics::ends;

    #[test]
    fn each_point_is_in_one_tile_with_those_near_it() {
        // A cube of 30 x 30 x 30 points.
        let points: Vec<[f64; 3]> =
            (0..27_000).map(|k| [k % 30, k / 30 % 30, k / 900].map(|x| f64::from(x) - 7.0)).collect();
        let view = PointsView::from_f64(&points);
        let tiles = of(&view, 1, &|| Ok(())).unwrap();
        // The grid is half an edge off the box, which has 8, 14 and 8 points along a side of its tiles.
        assert_eq!(tiles.len(), 27);
        let mut counts = vec![0; points.len()];
        for tile in &tiles {
            let range = |axis: usize| {
                let [low, high] = ends(tile.iter().map(|&k| points[k as usize][axis]));
                high - low
            };
            assert!([0, 1, 2].into_iter().all(|axis| range(axis) <= 14.5));
            tile.iter().for_each(|&k| counts[k as usize] += 1);
        }
        assert!(counts.iter().all(|count| *count == 1));
        let cancelled = of(&view, 1, &|| Err(Error::Cancelled { iterations: 0 }));
        assert!(matches!(cancelled, Err(Error::Cancelled { .. })));
    }
}

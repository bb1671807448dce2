//! Cubes that a cloud is cut into.

use super::cubes::{Bounds, all};
use super::{Asked, BETWEEN_QUESTIONS};
use crate::error::Result;
use crate::observations::PointsView;

/// Fewest points of a tile: fewer show no body.
const FEWEST: usize = 500;

/// The numbers of the points of each tile of a cloud with some bounds, an edge being 2^-level of the longest side of these.
pub(super) fn of(
    points: &PointsView<'_>,
    bounds: &Bounds,
    level: u32,
    asked: &Asked<'_>,
) -> Result<Vec<Vec<u32>>> {
    let cubes = bounds.cubes(level);
    let mut tiles = vec![Vec::new(); cubes.len()];
    for (k, point) in all(points).enumerate() {
        if k.is_multiple_of(BETWEEN_QUESTIONS) {
            asked()?;
        }
        if let Some(tile) = cubes.number(&point) {
            tiles[tile].push(k as u32);
        }
    }
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
        let bounds = Bounds::of(&view, &|| Ok(())).unwrap().unwrap();
        let tiles = of(&view, &bounds, 1, &|| Ok(())).unwrap();
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
        let cancelled = of(&view, &bounds, 1, &|| Err(Error::Cancelled { iterations: 0 }));
        assert!(matches!(cancelled, Err(Error::Cancelled { .. })));
    }
}

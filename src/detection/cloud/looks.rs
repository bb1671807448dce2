//! The looks at a cloud: from where, at which part of it, and how finely.

use super::super::grid::side_of_cells;
use super::cubes::{Bounds, Places};
use super::viewpoints::{Viewpoint, from_all_sides, of_origin};
use super::{Asked, Cloud, FEWEST, tiles};
use crate::error::Result;
use crate::observations::PointsView;

/// Cells of a cloud take this many pixels to each side at least: with a point to a pixel, one in three is empty.
pub(super) const LEAST_SIDE: usize = 3;

/// Where an image has fewer cells than this, a body may have too few to be seen as one, and finer ones are looked at, too.
const FEW_CELLS: usize = 4_000;

/// How often a cloud is cut into smaller tiles.
const LEVELS: u32 = 4;

/// The sides that a tile is looked at from.
const SIDES: usize = 6;

/// The looks at a cloud, one after the other: from its origin, and where that is not where all of it was seen from, from all sides, and
/// from all sides of tiles of it, in which less hides the rest and pixels are as small as the points there allow.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    /// From where the cloud, or the tile, is looked at.
    viewpoints: Vec<Viewpoint>,
    /// The number of the viewpoint that is looked from.
    current: usize,
    /// Pixels along the side of a cell at least.
    side: usize,
    /// Whether finer cells may show more.
    few_cells: bool,
    /// Whether some image of the origin has another wall behind what is seen.
    closed: bool,
    /// How often the same surface may have been looked at before.
    before: usize,
    /// How often the cloud is cut in halves; the whole of it is looked at first.
    level: u32,
    /// The points of the tiles of this level that are still to be looked at, the present one last.
    tiles: Vec<Vec<u32>>,
    /// Whether the cloud has been cut into them.
    cut: bool,
    /// Where the points of the cloud lie, once it has been asked for; `None` for no points.
    bounds: Option<Option<Bounds>>,
    places: Option<Places>,
}

impl Looks {
    /// The numbers of the points that are looked at; `None` for all.
    pub fn part(&self) -> Option<&[u32]> {
        self.tiles.last().map(Vec::as_slice)
    }

    /// Cuts the cloud into tiles where that is due. Whether there is anything to look at.
    pub(super) fn prepare(&mut self, points: &PointsView<'_>, asked: &Asked<'_>) -> Result<bool> {
        if self.level > 0 && !self.cut {
            if let Some(bounds) = self.bounds(points, asked)? {
                self.tiles = tiles::of(points, &bounds, self.level, asked)?;
            }
            self.cut = true;
        }
        Ok(self.level == 0 || !self.tiles.is_empty())
    }

    fn bounds(&mut self, points: &PointsView<'_>, asked: &Asked<'_>) -> Result<Option<Bounds>> {
        if self.bounds.is_none() {
            self.bounds = Some(Bounds::of(points, asked)?);
        }
        Ok(self.bounds.flatten())
    }

    /// The cubes of all points of the cloud, which [`Looks::places`] then has.
    pub(super) fn place(&mut self, points: &PointsView<'_>, asked: &Asked<'_>) -> Result<()> {
        if self.places.is_none()
            && let Some(bounds) = self.bounds(points, asked)?
        {
            self.places = Some(Places::of(points, &bounds, asked)?);
        }
        Ok(())
    }

    /// The cubes of the points of a cloud of which the bodies that were found may be pieces.
    pub fn places(&self) -> Option<&Places> {
        self.places.as_ref()
    }

    /// The viewpoint of the look at points; `None` for too few points.
    pub(super) fn viewpoint(&mut self, points: &Cloud, asked: &Asked<'_>) -> Result<Option<Viewpoint>> {
        if points.usable < FEWEST {
            return Ok(None);
        }
        if self.viewpoints.is_empty() {
            self.side = LEAST_SIDE;
            if self.level == 0 {
                self.viewpoints = of_origin(points);
            }
            if self.viewpoints.first().is_none_or(|first| !first.is_sensor()) {
                self.viewpoints.extend(from_all_sides(points, asked)?);
            }
        }
        Ok(self.viewpoints.get(self.current).copied())
    }

    /// Notes what the image of the present look is like: its size, and whether there is another wall behind what is seen.
    pub(super) fn note(
        &mut self,
        (width, height): (usize, usize),
        closed: bool,
        points: &Cloud,
        asked: &Asked<'_>,
    ) -> Result<()> {
        self.few_cells = width * height < FEW_CELLS * self.side * self.side;
        let viewpoint = self.viewpoints[self.current];
        self.closed |= closed && viewpoint.is_origin();
        if viewpoint.is_sensor() && closed && self.viewpoints.len() == 1 {
            // No sensor was there.
            self.viewpoints.extend(from_all_sides(points, asked)?);
        }
        Ok(())
    }

    /// Pixels along the side of a cell of an image of some size.
    pub(super) fn side_of_cells(&self, size: (usize, usize)) -> usize {
        if self.side < LEAST_SIDE { self.side } else { side_of_cells(size, f64::INFINITY).max(LEAST_SIDE) }
    }

    /// So many looks may have shown the same surface, the present one among them.
    pub fn tries(&self) -> f64 {
        (self.before + 1) as f64
    }

    /// Goes on to the next look, where there is one: with finer cells where these are few and nothing was found in any look so
    /// far, else from the next viewpoint, else at the next tile.
    pub fn go_on(&mut self, found: bool) -> bool {
        if !found && self.few_cells && self.side > 1 {
            self.side -= 1;
            self.before += 1;
            return true;
        }
        self.few_cells = false;
        self.side = LEAST_SIDE;
        let origin = self.viewpoints.get(self.current).map(|viewpoint| viewpoint.origin);
        self.current += 1;
        if let Some(next) = self.viewpoints.get(self.current) {
            // To other sides of the same place other surfaces are seen.
            self.before += usize::from(Some(next.origin) != origin);
            return next.is_origin() || self.closed || !found;
        }
        if self.viewpoints.first().is_some_and(Viewpoint::is_sensor) && !self.closed {
            return false;
        }
        self.viewpoints.clear();
        self.current = 0;
        self.tiles.pop();
        if self.tiles.is_empty() {
            self.level += 1;
            self.cut = false;
        }
        self.before = SIDES * self.level as usize;
        self.level <= LEVELS
    }
}

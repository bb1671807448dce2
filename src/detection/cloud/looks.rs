//! The looks at a cloud: from where, at which part of it, and how finely.

use super::super::grid::side_of_cells;
use super::CancelCheck;
use super::cubes::Order;
use super::image::{FEWEST, Image};
use super::points::Points;
use super::sensor::{Densities, FEW_POINTS, MANY_POINTS};
use super::viewpoints::{
    Viewpoint, are_far, from_all_sides, middle_of_some, of_origin, of_sensor, of_sensor_at,
};
use crate::error::Result;
use crate::geometry::Cylinder;
use crate::memory::List;
use crate::observations::{ENOUGH_POINTS_TO_FIT, PointsView, spread};
use nalgebra::Vector3;
use std::ops::Range;

/// Cells of a cloud take this many pixels to each side at least: with a point to a pixel, one in three is empty.
pub(super) const LEAST_SIDE: usize = 3;

constants! {
    /// Where an image has fewer cells than this, a body may have too few to be seen as one, and finer ones are looked at, too.
    FEW_CELLS = 4_000.0, "cells";

    /// From where a sensor was others hide less than the rest of this part of the points: from those of the twin 0.98 and more are seen, and
    /// 0.93 and more where the points were thinned in cubes.
    SEEN = 0.93, "";

    /// One sensor leaves less of the logarithms of the densities: 0.04 to 0.2. Two that are far apart leave 0.25 and more.
    LEFT = 0.22, "";

    /// How much is hidden from anywhere, by noise.
    HIDDEN = 0.01, "";

    /// From another position than the origin so much of what is hidden there is hidden, at most, where that is no sensor.
    LESS = 0.6, "";
}

/// How often a cloud is cut into smaller tiles.
pub(super) const LEVELS: u32 = 4;

/// The sides that a tile is looked at from.
const SIDES: usize = 6;

/// The points of use of a tile, and their numbers in the cloud.
#[derive(Debug, Default)]
struct Tile {
    points: Points,
    numbers: Vec<u32>,
}

/// The tiles that the cloud is cut into after the looks at all of it.
#[derive(Debug, Default)]
struct Tiles {
    /// How often the cloud is cut in halves; the whole of it is looked at first.
    level: u32,
    /// The points of the tiles of this level that are still to be looked at, the present one last; `None` before it is cut.
    left: Option<Vec<Vec<Range<usize>>>>,
    /// The tile that is looked at; `None` for the whole cloud.
    present: Option<Tile>,
}

impl Tiles {
    /// Goes on to the next tile, after the last one to the next level.
    fn go_on(&mut self) {
        self.left = self.left.take().filter(|left| left.len() > 1);
        match &mut self.left {
            Some(left) => drop(left.pop()),
            None => self.level += 1,
        }
    }
}

/// How fine the cells of an image are.
#[derive(Debug)]
struct Cells {
    /// Pixels along the side of one at least.
    side: usize,
    /// Whether there are so few that finer ones may show more.
    few: bool,
    /// Whether finer ones show bodies that are too thin for these, and lose nothing: a sensor has seen the cloud whose errors are
    /// those of single points.
    sharp: bool,
}

impl Default for Cells {
    fn default() -> Self {
        Self { side: LEAST_SIDE, few: false, sharp: false }
    }
}

impl Cells {
    /// Makes them finer where that may show more than was found `here`; whether it does.
    fn refine(&mut self, here: bool) -> bool {
        let may_show_more = (self.sharp || !here && self.few) && self.side > 1;
        self.side -= usize::from(may_show_more);
        may_show_more
    }
}

/// What is known of where the cloud was seen from.
#[derive(Debug, Default)]
struct SeenFrom {
    /// Whether the cloud is so far from its origin that nothing there has seen it.
    far: bool,
    /// Whether the points have flat pieces enough for their densities to tell of a sensor in the origin, or of none there.
    densities_tell: bool,
    /// Whether no sensor has seen all of it.
    unseen: bool,
    /// Whether some image of the origin has another wall behind what is seen, or no image is of the origin.
    closed: bool,
}

/// The looks at a cloud, one after the other: from where a sensor has seen all of it, and where none has, from all sides, and
/// from all sides of tiles of it, in which less hides the rest and pixels are as small as the points there allow.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    /// From where the cloud, or the tile, is looked at.
    viewpoints: Vec<Viewpoint>,
    /// The number of the viewpoint that is looked from.
    current: usize,
    cells: Cells,
    seen: SeenFrom,
    /// How often the same surface may have been looked at before.
    before: usize,
    tiles: Tiles,
    /// All points: in the order of the caller until another one is needed, as where a sensor in the origin has seen them they are
    /// looked at once.
    points: Option<Points>,
    order: Option<Order>,
    /// Some of the points that are looked at, where these are many.
    sample: Option<Points>,
    /// Whether the present tile and the sample are those of the points that are there now.
    is_read: bool,
    /// The image of the present look, where it has been made to choose that.
    pub(super) image: Option<Image>,
    /// Memory of an image, for the next one.
    pub(super) memory: Vec<u64>,
}

impl Looks {
    /// The number among all points of one that is looked at.
    pub fn in_all(&self, k: usize) -> u32 {
        self.tiles.present.as_ref().map_or(k as u32, |tile| tile.numbers[k])
    }

    /// The number that the caller knows one of all points by.
    pub fn given(&self, k: u32) -> usize {
        self.order.as_ref().map_or(k, |order| order.numbers[k as usize]) as usize
    }

    /// Where one of all points lies.
    pub fn point(&self, k: u32) -> Vector3<f64> {
        self.points.as_ref().map_or_else(Vector3::zeros, |points| points.point(k as usize))
    }

    /// Those of all points that may lie within a reach of a surface, and where; none of a cloud that was looked at from its origin alone.
    pub fn near(&self, cylinder: &Cylinder, reach: f64) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        self.order.iter().zip(&self.points).flat_map(move |(order, points)| {
            let usable = order.near(cylinder, reach).filter(|&k| points.is_usable(k));
            usable.map(|k| (k as u32, points.point(k)))
        })
    }

    /// Points of use within a reach of a surface, and where; of a cloud that was looked at from its origin alone some of them.
    pub fn some_near(&self, cylinder: &Cylinder, reach: f64) -> List<Vector3<f64>> {
        let is_near = |point: &Vector3<f64>| cylinder.distance(point).abs() <= reach;
        match (&self.order, &self.points) {
            (None, Some(points)) => {
                let some =
                    spread(points.len(), ENOUGH_POINTS_TO_FIT).into_iter().filter(|&k| points.is_usable(k));
                some.map(|k| points.point(k)).filter(is_near).collect()
            }
            _ => self.near(cylinder, reach).map(|(_, point)| point).filter(is_near).collect(),
        }
    }

    /// Whether many of the points are looked at, and others will be few.
    pub fn is_large(&self) -> bool {
        self.order.is_some() && self.tiles.level <= 1
    }

    /// Whether all of the points are looked at, not a tile of them.
    pub fn at_all(&self) -> bool {
        self.tiles.level == 0
    }

    /// One of all points belongs to a body: later looks do not see it.
    pub fn remove(&mut self, k: u32) {
        if let Some(points) = &mut self.points {
            points.remove(k as usize);
            self.is_read = false;
        }
    }

    /// The points that are looked at.
    pub(super) fn part(&self) -> Option<&Points> {
        self.tiles.present.as_ref().map(|tile| &tile.points).or(self.points.as_ref())
    }

    /// Some of them, or all, which tell about where they are.
    pub(super) fn sample(&self) -> Option<&Points> {
        self.sample.as_ref().or(self.part())
    }

    /// The viewpoint of the present look.
    pub(super) fn viewpoint(&self) -> Option<&Viewpoint> {
        self.viewpoints.get(self.current)
    }

    /// Reads what there is to be looked at, and chooses from where. Whether there is a look to take.
    pub(super) fn prepare(&mut self, view: &PointsView<'_>, check_cancel: &CancelCheck<'_>) -> Result<bool> {
        if self.points.is_none() {
            let mut points = Points::read(view, Vector3::zeros(), check_cancel)?;
            self.seen.far = are_far(&points);
            if self.seen.far {
                let among_them = points.all_usable().next().unwrap_or_default();
                points = Points::read(view, among_them, check_cancel)?;
            }
            self.points = Some(points);
        }
        let Tiles { level, left, .. } = &mut self.tiles;
        if *level > 0 {
            let cut = || self.order.as_ref().map_or_else(Vec::new, |order| order.tiles(*level));
            if left.get_or_insert_with(cut).is_empty() {
                return Ok(false);
            }
        }
        self.read_part();
        if self.part().is_none_or(|points| points.usable < FEWEST.count()) {
            return Ok(false);
        }
        if self.viewpoints.is_empty() {
            self.cells.side = LEAST_SIDE;
            if self.at_all() {
                if !self.seen.unseen {
                    let sensor = self.sensor(check_cancel)?;
                    self.viewpoints.extend(sensor);
                }
                if self.viewpoints.is_empty() {
                    // More than one position may have seen what is far from the origin.
                    self.seen.closed |= self.seen.far;
                    self.put_in_order(view, check_cancel)?;
                    self.viewpoints =
                        self.sample().filter(|_| !self.seen.far).map(of_origin).unwrap_or_default();
                }
            }
            if self.viewpoints.first().is_none_or(|first| !first.is_sensor()) {
                self.look_from_all_sides();
            }
        }
        Ok(self.viewpoint().is_some())
    }

    /// Where a sensor was that has seen the cloud: in the origin, unless that is far, or where the densities of the points tell.
    fn sensor(&mut self, check_cancel: &CancelCheck<'_>) -> Result<Option<Viewpoint>> {
        let Some(points) = &self.points else { return Ok(None) };
        let image = |viewpoint: &Viewpoint, memory: Vec<u64>| {
            Image::of(points, points, (&viewpoint.pose(points), viewpoint.widest), memory, check_cancel)
        };
        let (_, middle, _) = middle_of_some(points);
        let middle = points.origin + middle;
        let origin = if self.seen.far { None } else { of_sensor(points) };
        // A sensor in the origin may look along another axis: that is a look like others.
        let aside = || if self.seen.far { None } else { of_sensor_at(&Vector3::zeros(), points, &middle) };
        let (mut hidden_from_origin, mut memory) = (1.0, Vec::new());
        // A look from there shows little where much is hidden, and would be the only one.
        let mut sees_all = true;
        if let Some(from) = origin.or_else(aside)
            && let Some(image) = image(&from, Vec::new())?
        {
            let few = Densities::of(points, FEW_POINTS);
            self.seen.densities_tell = few.is_some();
            if image.seen >= SEEN.get() && few.is_none_or(|few| few.confirm(&from.origin)) {
                self.image = origin.map(|_| image);
                return Ok(origin);
            }
            sees_all = image.seen >= SEEN.get() || image.closed;
            (hidden_from_origin, memory) = (1.0 - image.seen, image.nearest);
        }
        // Of several positions the one that leaves the least of the densities and hides the least of the points.
        let mut best: Option<(f64, Viewpoint)> = None;
        let densities = Densities::of(points, MANY_POINTS);
        let positions =
            densities.iter().flat_map(Densities::positions).filter(|(_, left)| *left <= LEFT.get());
        for (position, left) in positions {
            let Some(viewpoint) = of_sensor_at(&position, points, &middle) else { continue };
            let Some(image) = image(&viewpoint, memory)? else { break };
            let hidden = 1.0 - image.seen;
            let is_one = image.seen >= SEEN.get() && hidden < LESS.get() * hidden_from_origin;
            let cost = left * (hidden + HIDDEN.get());
            if is_one && best.as_ref().is_none_or(|(least, _)| cost < *least) {
                best = Some((cost, viewpoint));
            }
            memory = image.nearest;
        }
        Ok(best.map(|(_, viewpoint)| viewpoint).or(origin.filter(|_| sees_all)))
    }

    fn look_from_all_sides(&mut self) {
        let viewpoints = self.sample().map(from_all_sides).unwrap_or_default();
        self.viewpoints.extend(viewpoints);
    }

    /// Reads the points of the tile and the sample of those that are looked at, where others have been.
    fn read_part(&mut self) {
        if self.is_read {
            return;
        }
        self.is_read = true;
        let Tiles { left, present, .. } = &mut self.tiles;
        if let (Some(ranges), Some(all)) = (left.as_ref().and_then(|left| left.last()), &self.points) {
            let Tile { points, numbers } = present.get_or_insert_default();
            points.start_from(all.origin);
            numbers.clear();
            ranges.iter().for_each(|range| points.push_usable(all, range.clone(), numbers));
        }
        // A cloud that is looked at once takes little time.
        self.sample = self.order.as_ref().and(self.part()).and_then(Points::sample);
    }

    /// Puts the points of the cloud into an order in which those near each other follow each other.
    pub(super) fn put_in_order(
        &mut self,
        view: &PointsView<'_>,
        check_cancel: &CancelCheck<'_>,
    ) -> Result<()> {
        if let Some(points) = self.points.take_if(|_| self.order.is_none()) {
            let (order, points) = Order::of(view, points, check_cancel)?;
            (self.order, self.points, self.is_read) = (order, Some(points), false);
            self.read_part();
        }
        Ok(())
    }

    /// Notes what the image of the present look is like: its size, whether there is another wall behind what is seen, and whether each
    /// cell has an error of its own.
    pub(super) fn note(&mut self, (width, height): (usize, usize), closed: bool, independent: bool) {
        self.cells.few = width * height < FEW_CELLS.count() * self.cells.side * self.cells.side;
        let Some(viewpoint) = self.viewpoint().copied() else { return };
        self.seen.closed |= closed && viewpoint.may_be_sensor();
        self.cells.sharp = independent && viewpoint.is_sensor() && !closed;
        if viewpoint.is_sensor() && closed && self.viewpoints.len() == 1 {
            // No sensor was there.
            self.look_from_all_sides();
        }
    }

    /// Keeps the memory of an image for the next one; that of the whole cloud is much, and looked at a few times.
    pub(super) fn keep(&mut self, memory: Vec<u64>) {
        self.memory = if self.tiles.level > 0 { memory } else { Vec::new() };
    }

    /// Pixels along the side of a cell of an image of some size.
    pub(super) fn side_of_cells(&self, size: (usize, usize)) -> usize {
        if self.cells.side < LEAST_SIDE {
            self.cells.side
        } else {
            side_of_cells(size, f64::INFINITY).max(LEAST_SIDE)
        }
    }

    /// So many looks may have shown the same surface, the present one among them.
    pub fn tries(&self) -> f64 {
        (self.before + 1) as f64
    }

    /// Goes on to the next look, where there is one: with finer cells where these are few and nothing was found `here`, by the present
    /// look, else from the next viewpoint, else at the next tile. Whether any look so far has `found` something.
    pub fn go_on(&mut self, found: bool, here: bool) -> bool {
        if self.cells.refine(here) {
            self.before += 1;
            return true;
        }
        self.cells = Cells::default();
        let origin = self.viewpoints.get(self.current).map(|viewpoint| viewpoint.origin);
        self.current += 1;
        if let Some(next) = self.viewpoints.get(self.current) {
            // To other sides of the same position other surfaces are seen.
            self.before += usize::from(Some(next.origin) != origin);
            return true;
        }
        if let Some(sensor) = self.viewpoints.first().filter(|first| first.is_sensor() && !self.seen.closed) {
            if found || (sensor.origin == Vector3::zeros() && self.seen.densities_tell) {
                return false;
            }
            // The densities may have misled.
            (self.seen.unseen, self.seen.closed) = (true, true);
            self.viewpoints.clear();
            self.current = 0;
            self.before += 1;
            return true;
        }
        self.viewpoints.clear();
        self.current = 0;
        self.tiles.go_on();
        self.is_read = false;
        self.before = SIDES * self.tiles.level as usize;
        self.tiles.level <= LEVELS
    }
}

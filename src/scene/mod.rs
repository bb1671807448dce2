//! Whole scenes: finds all cylinders of a frame or a cloud and fits each by the full method.
//!
//! [`crate::detection`] finds the regions by depth and image; here each becomes the mask of a fit of its own, and how well that
//! determines the radius joins the score.

mod contests;
mod fits;
mod labels;
mod outcomes;
mod regions;
mod results;
mod work;

#[cfg(feature = "sensitivity")]
/// The constants of whole scenes.
#[must_use]
pub fn constants() -> Vec<crate::constant::Constant> {
    [CONSTANTS, contests::CONSTANTS, fits::CONSTANTS, regions::CONSTANTS].concat()
}

use crate::camera::Camera;
use crate::detection::{
    Detection, DetectionOptions, Detections, Looks, detect_points_until, detect_until, least_before_fit,
};
use crate::error::{Error, Result, cancelled_if};
use crate::fitter::{Flags, Options, StartKind};
use crate::geometry::{CylinderLimits, RigidMotion};
use crate::memory::{Memory, apart, is_there};
use crate::observations::{DepthImage, DepthRange, Frame, PointsView, check_weights, moved};
use fits::{Fits, Task};
use labels::renumber;
use outcomes::{FitRegion, Outcome, Regions};
pub use results::{Found, Scene};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use work::WorkBudget;

/// Bytes a pixel or point that there must be memory for before a search begins, which could not end it well later. Searches and
/// fits of clouds of 1 to 4 million points held 32 to 123 at a time, most where one body is all of the cloud; 231 were seen.
const BYTES_OF_SEARCH: usize = 256;

/// Most points of a cloud: they are counted in 32 bits.
const MOST_POINTS: usize = u32::MAX as usize - 1;

/// The settings of a [`Detector`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectorOptions {
    /// The search; its limits of the cylinders hold for the fits as well. The axis is in the frame of reference.
    pub search: DetectionOptions,
    /// The fits. Limits, start and threads are those of the detector and must be the default here.
    pub fit: Options,
    /// Whether the image of a frame is looked at, if it has one.
    pub use_image: bool,
    /// Most threads, on which cylinders are fitted side by side; 1, the default, starts none and 0 as many as the machine
    /// has. The result has the same bits for any number.
    pub threads: usize,
}

impl Default for DetectorOptions {
    fn default() -> Self {
        Self { search: DetectionOptions::default(), fit: Options::default(), use_image: true, threads: 1 }
    }
}

impl DetectorOptions {
    /// Checks every value.
    ///
    /// # Errors
    /// `InvalidArgument` that names the option, its value and its limit.
    pub fn check(&self) -> Result<()> {
        self.search.check()?;
        self.fit.check()?;
        let refuse = |name: &str, value: String, requirement: &str| {
            Err(Error::argument(format!("{name} of the fits"), value, requirement))
        };
        let CylinderLimits { radius_min, radius_max, axis } = self.fit.cylinder_limits;
        let default = CylinderLimits::default();
        let given = [
            ("radius_min", (radius_min != default.radius_min).then(|| radius_min.to_string())),
            ("radius_max", (radius_max != default.radius_max).then(|| radius_max.to_string())),
            ("axis", axis.map(|cone| format!("{:?}", cone.direction.as_slice()))),
        ];
        for (name, value) in given {
            let Some(value) = value else { continue };
            let requirement =
                format!("be left at its default: set {name} of the detector, which holds for the fits");
            return refuse(name, value, &requirement);
        }
        if self.fit.start != StartKind::Auto {
            let start = format!("{:?}", self.fit.start);
            return refuse("start", start, "be Auto: a fit starts from the cylinder that was found");
        }
        if self.fit.threads != 1 {
            let threads = self.fit.threads.to_string();
            return refuse(
                "max_threads",
                threads,
                "be 1: the threads of the detector fit cylinders side by side",
            );
        }
        Ok(())
    }
}

/// Progress of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// It begins to look for cylinders; at a cloud that was not seen from its origin, from many positions.
    Search,
    /// So many of the cylinders that were found are fitted.
    Fit {
        /// Fits that are done.
        done: usize,
        /// All fits.
        count: usize,
    },
}

/// Receives the progress of a search, and may cancel it.
pub struct Observer<'a> {
    /// Called on the thread that searches; `Break` stops.
    pub progress: &'a mut dyn FnMut(Progress) -> ControlFlow<()>,
    /// Asked on any thread, before each candidate of the search and each iteration of the fits.
    pub stopped: &'a (dyn Fn() -> bool + Sync),
}

/// Finds all cylinders of a scene, and fits each.
///
/// A detector keeps the memory of its calls for the next ones, 3 to 25 MB after frames of 640 × 480 pixels, and frees it when it
/// is dropped: what a call like the ones before asks for is its result and little else. Calls at the same time have their own each.
///
/// ```
/// use cylfuse::observations::PointsView;
/// use cylfuse::scene::Detector;
///
/// // The front of a can of radius 0.1 that stands before a wall.
/// let mut points = Vec::new();
/// for row in 0..120 {
///     for column in 0..160 {
///         let [x, y] = [(f64::from(column) - 79.5) / 200.0, (f64::from(row) - 59.5) / 200.0];
///         let near = (1.0_f64 - (1.0 + x * x) * (1.0 - 0.01)).sqrt();
///         let z = if near > 0.0 { (1.0 - near) / (1.0 + x * x) } else { 1.5 };
///         points.push([x * z, y * z, z]);
///     }
/// }
/// let scene = Detector::new().detect_points(&PointsView::from_f64(&points))?;
/// assert_eq!(scene.cylinders.len(), 1);
/// assert!((scene.cylinders[0].result.cylinder.radius - 0.1).abs() < 0.001);
/// # Ok::<(), cylfuse::error::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct Detector {
    options: DetectorOptions,
    /// What a call uses again.
    memory: Memory,
}

impl Detector {
    /// A detector with default options.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &DetectorOptions {
        &self.options
    }

    /// Replaces the options.
    ///
    /// # Errors
    /// `InvalidArgument`; the old options stay then.
    pub fn set_options(&mut self, options: DetectorOptions) -> Result<()> {
        options.check()?;
        self.options = options;
        Ok(())
    }

    /// Finds and fits all cylinders of a frame. They are in the frame of reference that the pose of the frame leads to.
    /// The images of the frame are shared and not copied.
    ///
    /// # Errors
    /// `BadState` without intrinsics or depth; `Unsupported` for an objective of the fits that needs edge segments;
    /// `OutOfMemory`.
    pub fn detect(&self, frame: &Frame) -> Result<Scene> {
        unobserved(|observer| self.detect_with(frame, observer))
    }

    /// Finds and fits all cylinders of a frame, as [`Detector::detect`] does, with an observer of its progress that may cancel it.
    ///
    /// # Errors
    /// Those of [`Detector::detect`], and `Cancelled`.
    pub fn detect_with(&self, frame: &Frame, observer: &mut Observer<'_>) -> Result<Scene> {
        self.memory.lend(|| self.detect_in_memory(frame, observer))
    }

    fn detect_in_memory(&self, frame: &Frame, observer: &mut Observer<'_>) -> Result<Scene> {
        let size = searched(frame)?.0.size();
        check_memory("the search", size.0 * size.1)?;
        let mut frame = frame.clone();
        if !self.options.use_image {
            frame.clear_image();
        }
        let mut depth_moved = [0; 2];
        let found = self.search(observer, |stopped| {
            let found = self.search_frame(&frame, stopped)?;
            let Some(shift) = found.shift else { return Ok(found) };
            let Some(moved) = frame.with_depth_moved(shift)? else { return Ok(found) };
            let mut in_moved = self.search_frame(&moved, stopped)?;
            in_moved.visits += found.visits;
            if in_moved.seen_in_image() <= found.seen_in_image() {
                return Ok(found);
            }
            (frame, depth_moved) = (moved, shift);
            Ok(in_moved)
        })?;
        let fits = Fits::new(&self.options, found, size);
        let scene =
            self.fit_regions(fits, observer, |fits, task, budget| fits.of_frame(&frame, task, budget))?;
        if scene.cylinders.is_empty() {
            // Nothing confirms the shift.
            depth_moved = [0; 2];
        }
        let mut scene = Scene { depth_moved, ..scene };
        if depth_moved != [0; 2] {
            scene.labels = moved(&scene.labels, size, depth_moved.map(|by| -by))?;
            scene.cylinders.iter_mut().for_each(|found| found.result.flags |= Flags::DEPTH_SHIFTED);
        }
        Ok(scene)
    }

    fn search_frame(&self, frame: &Frame, stopped: &dyn Fn() -> bool) -> Result<Detections> {
        let (camera, depth) = searched(frame)?;
        let limited;
        let depth = if *frame.depth_range() == DepthRange::default() {
            depth
        } else {
            limited = depth.within(frame.depth_range())?;
            &limited
        };
        let filled = depth.without_gaps()?;
        let depth = filled.as_ref().unwrap_or(depth);
        let search = self.search_options(&frame.pose().inverse(), frame.image().is_some());
        detect_until(camera, depth, frame.image(), &search, stopped)
    }

    /// Finds and fits all cylinders of a cloud, organised or not. It is looked at from where a sensor has seen
    /// it: the origin, where nearly all points lie in front of it and hide none of each other, or where their densities tell. Clouds that
    /// no single position has seen are looked at from all sides, and from all sides of tiles of them, which takes about ten times as long.
    /// Points with a coordinate that is not finite or a weight of 0 are left out.
    ///
    /// # Errors
    /// `InvalidArgument` for a negative weight, and for too many points; `Unsupported` as [`Detector::detect`];
    /// `OutOfMemory`.
    pub fn detect_points(&self, points: &PointsView<'_>) -> Result<Scene> {
        unobserved(|observer| self.detect_points_with(points, observer))
    }

    /// Finds and fits all cylinders of a cloud, as [`Detector::detect_points`] does, with an observer of its progress that may
    /// cancel it.
    ///
    /// # Errors
    /// Those of [`Detector::detect_points`], and `Cancelled`.
    pub fn detect_points_with(&self, points: &PointsView<'_>, observer: &mut Observer<'_>) -> Result<Scene> {
        self.memory.lend(|| self.detect_points_in_memory(points, observer))
    }

    fn detect_points_in_memory(&self, points: &PointsView<'_>, observer: &mut Observer<'_>) -> Result<Scene> {
        let size = (points.width(), points.height());
        let count = size.0.saturating_mul(size.1);
        if count > MOST_POINTS {
            let requirement = format!("be at most {MOST_POINTS}: divide the cloud");
            return Err(Error::argument("the number of points", count, requirement));
        }
        check_memory("the search", count)?;
        check_weights(points)?;
        let search = self.search_options(&RigidMotion::identity(), false);
        let mut scene = Scene {
            cylinders: Vec::new(),
            labels: vec![0; count],
            size,
            complete: true,
            depth_moved: [0; 2],
        };
        // Rows of no points are as many as the caller likes.
        let (mut looks, mut more) = (Looks::default(), count > 0);
        while more {
            let seen =
                self.search(observer, |stopped| detect_points_until(points, &mut looks, &search, stopped))?;
            scene.complete &= !seen.as_ref().is_some_and(|seen| seen.cut_short);
            let before = scene.cylinders.len();
            if let Some(seen) = seen.filter(|seen| !seen.cylinders.is_empty()) {
                let fits = Fits::new(&self.options, seen, size).after(looks.tries());
                let fit = || {
                    self.fit_regions(fits, observer, |fits, task, budget| {
                        fits.of_points(points, &looks, task, budget)
                    })
                };
                let found = if looks.is_large() { apart(fit) } else { fit() }?;
                scene.add(found, &mut looks);
            }
            more = looks.go_on(!scene.cylinders.is_empty(), scene.cylinders.len() > before);
        }
        scene.order(self.options.search.max_count);
        Ok(scene)
    }

    /// The options of the search, for all that may be left when every cylinder is fitted.
    fn search_options(&self, into_camera: &RigidMotion, has_image: bool) -> DetectionOptions {
        let errors = [1.0 - RADIUS_ERROR.get(), 1.0 + RADIUS_ERROR.get()];
        let limits = self.options.search.limits.moved(into_camera).widened(errors, 0.0);
        let min_score = least_before_fit(self.options.search.min_score, has_image);
        DetectionOptions { limits, max_count: usize::MAX, min_score, ..self.options.search }
    }

    /// Whether a cylinder keeps the limits by itself: one that was found outside does where the fit led inside, and no
    /// limit has to hold it.
    fn within(&self, detection: &Detection, found: &Found) -> bool {
        let CylinderLimits { radius_min, radius_max, .. } = self.options.search.limits;
        let inside = (radius_min..=radius_max).contains(&detection.cylinder.radius);
        inside || !found.result.flags.contains(Flags::RADIUS_AT_LIMIT)
    }

    fn search<T>(
        &self,
        observer: &mut Observer<'_>,
        find: impl FnOnce(&dyn Fn() -> bool) -> Result<T>,
    ) -> Result<T> {
        cancelled_if((observer.progress)(Progress::Search).is_break() || (observer.stopped)())?;
        let found = find(&observer.stopped)?;
        cancelled_if((observer.stopped)()).map(|()| found)
    }

    /// Fits every region that the work of a scene reaches, and puts the cylinders into the order of their scores.
    fn fit_regions<'a>(
        &self,
        fits: Fits<'a>,
        observer: &mut Observer<'_>,
        fit: impl Fn(&Fits<'a>, &Task, Option<&WorkBudget<'_>>) -> Result<Box<Found>> + Sync,
    ) -> Result<Scene> {
        let count = fits.seen.cylinders.len();
        let stop = AtomicBool::new(false);
        let stopped = observer.stopped;
        let poll = || match stop.load(Ordering::Relaxed) || stopped() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let progress = &mut *observer.progress;
        let mut tell = |done| {
            if progress(Progress::Fit { done, count }).is_break() {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let fit: &FitRegion<'_> = &|task, budget| fit(&fits, task, budget);
        let (outcomes, all) = Regions { fits: &fits, fit, poll: &poll }.outcomes(&mut tell);
        if poll().is_break() {
            let done = outcomes.iter().flatten().flatten();
            return Err(Error::Cancelled { iterations: done.map(|found| found.result.iterations).sum() });
        }
        let complete = all && !fits.seen.cut_short;
        let cylinders = self.returned(&fits.seen.cylinders, outcomes)?;
        let Fits { seen: Detections { mut labels, .. }, size, .. } = fits;
        renumber(&mut labels, cylinders.iter().map(|(label, _)| *label));
        // What goes to the caller has no more room than it needs.
        let cylinders = cylinders.into_iter().map(|(_, found)| apart(move || Found::clone(&found))).collect();
        Ok(Scene { cylinders, labels, size, complete, depth_moved: [0; 2] })
    }

    /// The cylinders that are returned, by falling score, each with the label of its region.
    fn returned(&self, detections: &[Detection], outcomes: Vec<Outcome>) -> Result<Vec<(u16, Box<Found>)>> {
        let mut cylinders = Vec::new();
        for (index, outcome) in outcomes.into_iter().enumerate() {
            match outcome {
                Some(Ok(found)) => {
                    let keeps = found.score >= self.options.search.min_score
                        && self.within(&detections[index], &found);
                    cylinders.extend(keeps.then_some((index as u16 + 1, found)));
                }
                Some(Err(
                    error @ (Error::Cancelled { .. } | Error::OutOfMemory { .. } | Error::Unsupported { .. }),
                )) => return Err(error),
                // A region without any measured pixel of its own, say, cannot be fitted.
                Some(Err(_)) | None => {}
            }
        }
        cylinders.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
        cylinders.truncate(self.options.search.max_count);
        Ok(cylinders)
    }
}

/// What a search needs of a frame.
fn searched(frame: &Frame) -> Result<(&Camera, &DepthImage)> {
    let missing = |missing, remedy| Error::BadState { call: "detecting cylinders", missing, remedy };
    let camera = frame.camera().ok_or(missing("intrinsics", "set the intrinsics of the frame first"))?;
    let depth = frame.depth_on_image().ok_or(missing("a depth image", "set the depth of the frame first"))?;
    Ok((camera, depth))
}

/// Calls with an observer that never stops anything.
fn unobserved<T>(call: impl FnOnce(&mut Observer<'_>) -> T) -> T {
    call(&mut Observer { progress: &mut |_| ControlFlow::Continue(()), stopped: &|| false })
}

constants! {
    /// A radius by depth alone is off by less than this part of it in 94 of 100 cylinders of ../shared/scenes: what the search
    /// finds so near to the limits may turn out to keep them.
    RADIUS_ERROR = 0.15, "radius";
}

/// Refuses a call for which there is no memory.
fn check_memory(what: &'static str, pixels: usize) -> Result<()> {
    let bytes = pixels.saturating_mul(BYTES_OF_SEARCH);
    if is_there(bytes) { Ok(()) } else { Err(Error::OutOfMemory { what, bytes }) }
}

//! Frames, what is done to their inputs, and the errors of a fit to them.

use crate::disturbance::Disturbance;
use crate::frames::{Inputs, cylinder, json};
use crate::parallel::map;
use crate::support::Noise;
use cylfuse::error::Error;
use cylfuse::fitter::{Fitter, Options};
use cylfuse::geometry::Cylinder;
use cylfuse::observations::{EdgeSegment, ImageFormat, ImageView, MaskView, PointsView};
use std::path::{Path, PathBuf};

/// E_o (degrees), E_p (mm), E_r (%), E_l (%).
pub type Errors = [f64; 4];

/// A frame in memory.
pub struct Frame {
    pub name: String,
    pub inputs: Inputs,
    /// The image with red, green and blue, where it has them.
    pub color: Option<Vec<u8>>,
    /// The cylinder as a perfect fit to the depth would find it, its axis point at the centre.
    pub truth: Cylinder,
    /// Whether the radius is known by other means than this frame.
    pub radius_known: bool,
    /// Unknown where a recorded cylinder was not measured.
    pub length: Option<f64>,
    /// Whether both ends are seen; where not, centre and length are not known.
    pub ends_seen: bool,
}

impl Frame {
    fn read(folder: &Path) -> Self {
        let truth = json(&folder.join("truth.json"));
        let mut true_cylinder = cylinder(&truth, "center", "axis");
        if let Some(radius) = truth["radius_in_sensor_scale"].as_f64() {
            true_cylinder.radius = radius;
        }
        let file = json(&folder.join("frame.json"))["image"].as_str().map(|name| folder.join(name)).unwrap();
        let image = image::open(file).unwrap();
        Self {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            inputs: Inputs::read(folder),
            color: image.color().has_color().then(|| image.into_rgb8().into_raw()),
            truth: true_cylinder,
            radius_known: truth["radius_known_independently"].as_bool().unwrap_or(true),
            length: truth["length"].as_f64(),
            ends_seen: truth["ends_seen"].as_bool().unwrap_or(true),
        }
    }
}

/// The frames of a set, by name; empty where the set is not there.
pub fn read_set(shared: &Path, set: &str) -> Vec<Frame> {
    let Ok(entries) = std::fs::read_dir(shared.join(set)) else {
        eprintln!("skipped: no frames in {}", shared.join(set).display());
        return Vec::new();
    };
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    folders.retain(|folder| {
        let truth = folder.join("truth.json");
        truth.exists() && json(&truth)["radius"].is_number()
    });
    folders.sort();
    map(&folders, |folder| Frame::read(folder))
}

/// Which edges a fit gets.
#[derive(Clone, Copy)]
pub enum Edges {
    /// Both, the endpoints moved by normal noise of a standard deviation in pixels.
    Both {
        noise: f64,
        seed: u64,
    },
    /// The first or the second alone.
    One(usize),
    /// Both, one of them moved across by some pixels.
    OneWrong {
        which: usize,
        shift: f64,
    },
    /// One limb twice, the second time 3 px beside the first.
    Twice(usize),
    None,
}

/// Both as given.
pub const GIVEN: Edges = Edges::Both { noise: 0.0, seed: 0 };

/// One way to fit.
#[derive(Clone, Copy)]
pub struct Case {
    pub edges: Edges,
    pub image: bool,
    /// What is done to the image.
    pub disturbance: Disturbance,
    /// The gamma that the fit is told.
    pub gamma: f64,
    /// Pixels by which the mask is dilated, or eroded where negative.
    pub grow: i32,
    /// Whether only the pixels that have depth are in the mask.
    pub of_depth: bool,
    /// Whether the fit knows the mask, or has the points of the mask only.
    pub mask: bool,
    pub options: Options,
}

impl Default for Case {
    fn default() -> Self {
        let options = Options { threads: 1, ..Options::default() };
        Self {
            edges: GIVEN,
            image: true,
            disturbance: Disturbance::None,
            gamma: 1.0,
            grow: 0,
            of_depth: false,
            mask: true,
            options,
        }
    }
}

impl Frame {
    fn edges(&self, edges: Edges) -> Vec<EdgeSegment> {
        let given = &self.inputs.edges;
        let shifted = |mut segment: EdgeSegment, shift: f64| {
            let [a, b] = segment.endpoints;
            let along = (b - a).normalize();
            let across = nalgebra::Vector2::new(-along.y, along.x) * shift;
            segment.endpoints.iter_mut().for_each(|q| *q += across);
            segment
        };
        match edges {
            Edges::Both { noise, seed } => {
                let mut given = given.clone();
                // Every frame has noise of its own.
                let of_frame = self.name.bytes().fold(seed, |sum, byte| sum * 31 + u64::from(byte));
                let mut normal = Noise::new(of_frame);
                for q in given.iter_mut().flat_map(|segment| &mut segment.endpoints) {
                    q.iter_mut().for_each(|x| *x += noise * normal.normal());
                }
                given
            }
            Edges::One(which) => vec![given[which]],
            Edges::OneWrong { which, shift } => {
                let mut given = given.clone();
                given[which] = shifted(given[which], shift);
                given
            }
            Edges::Twice(which) => vec![given[which], shifted(given[which], 3.0)],
            Edges::None => Vec::new(),
        }
    }

    /// The fit of a case, and the fitter that made it.
    pub fn fit(&self, case: &Case) -> Result<(Fitter, Cylinder), Error> {
        let mut fitter = self.fitter(case);
        fitter.set_options(case.options)?;
        if case.mask {
            let cylinder = fitter.fit()?.cylinder;
            return Ok((fitter, cylinder));
        }
        // The points alone go to a fitter of their own; the other one keeps the mask for the extent.
        let points: Vec<[f64; 3]> = fitter.cloud().points().map(|p| [p.x, p.y, p.z]).collect();
        let mut alone = Fitter::new();
        alone.set_intrinsics(self.inputs.intrinsics)?;
        alone.push_points(&PointsView::from_f64(&points), None)?;
        alone.push_edges(fitter.segments())?;
        if case.image {
            self.push_image(&mut alone, case)?;
        }
        alone.set_options(case.options)?;
        Ok((fitter, alone.fit()?.cylinder))
    }

    /// A fitter with the inputs of a case.
    pub fn fitter(&self, case: &Case) -> Fitter {
        let mut inputs = self.inputs.clone();
        inputs.mask = grown(&inputs.mask, inputs.size, case.grow);
        if case.of_depth {
            inputs.mask.iter_mut().zip(&inputs.depth).for_each(|(set, depth)| *set &= u8::from(*depth > 0));
        }
        let mut fitter = inputs.fitter();
        fitter.push_edges(&self.edges(case.edges)).unwrap();
        if case.image {
            self.push_image(&mut fitter, case).unwrap();
        }
        fitter
    }

    fn push_image(&self, fitter: &mut Fitter, case: &Case) -> Result<(), Error> {
        let Inputs { image, size, .. } = &self.inputs;
        if let (Some(color), Disturbance::None) = (&self.color, case.disturbance) {
            let view = ImageView::from_bytes(color, *size, ImageFormat::Rgb8)?;
            return fitter.push_image(&view.with_gamma(case.gamma)?);
        }
        let image = case.disturbance.applied(image, *size);
        fitter.push_image(&ImageView::from_u8(&image, *size)?.with_gamma(case.gamma)?)
    }

    /// The errors of a model; the extent is sought in the mask as given.
    pub fn errors(&self, fitter: &Fitter, model: &Cylinder) -> Result<Errors, Error> {
        let mask = MaskView::from_u8(&self.inputs.mask, self.inputs.size)?;
        let extent = fitter.extent(Some(model), Some(&mask))?;
        let difference = self.truth.compare(model);
        Ok([
            difference.angle.to_degrees(),
            (extent.center - self.truth.axis.point).norm() * 1e3,
            difference.radius_relative.abs() * 100.0,
            self.length.map_or(f64::NAN, |length| (extent.length / length - 1.0).abs() * 100.0),
        ])
    }

    /// The errors of a case; `None` where the fit fails.
    pub fn errors_of(&self, case: &Case) -> Option<Errors> {
        let (fitter, cylinder) = self.fit(case).ok()?;
        self.errors(&fitter, &cylinder).ok()
    }
}

/// A mask dilated by a disc of that radius, or eroded by it.
fn grown(mask: &[u8], (width, height): (usize, usize), by: i32) -> Vec<u8> {
    if by == 0 {
        return mask.to_vec();
    }
    let (target, limit) = (by > 0, by * by);
    let mut result: Vec<u8> = mask.iter().map(|&m| u8::from(m > 0)).collect();
    for y in 0..height as i32 {
        for x in 0..width as i32 {
            if (mask[y as usize * width + x as usize] > 0) != target {
                continue;
            }
            for dy in -by.abs()..=by.abs() {
                for dx in -by.abs()..=by.abs() {
                    let (x, y) = (x + dx, y + dy);
                    let inside = (0..width as i32).contains(&x) && (0..height as i32).contains(&y);
                    if inside && dx * dx + dy * dy <= limit {
                        result[y as usize * width + x as usize] = u8::from(target);
                    }
                }
            }
        }
    }
    result
}

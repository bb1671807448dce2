//! Several views of one cylinder, their depth not registered to the image: `../shared/views`.

use crate::Sets;
use crate::frame::Errors;
use crate::frames::{cylinder, json};
use crate::parallel::map;
use crate::table::{Target, columns, print_head, print_row, print_targets};
use cylfuse::camera::{Camera, Distortion, Intrinsics};
use cylfuse::error::Error;
use cylfuse::fitter::Fitter;
use cylfuse::geometry::{Cylinder, RigidMotion};
use cylfuse::observations::{DepthCamera, DepthRange, DepthView, EdgeSegment, Frame, ImageView, MaskView};
use nalgebra::{Matrix3, Vector2, Vector3};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Of the mean errors of single views, three views may have so much.
const OF_SINGLE_VIEWS: f64 = 0.6;

/// One view, decoded.
struct View {
    frame: Frame,
    mask: Vec<u8>,
    edges: Vec<EdgeSegment>,
}

/// One cylinder and its views.
pub struct Views {
    name: String,
    views: Vec<View>,
    truth: Cylinder,
    length: f64,
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn motion(value: &Value) -> RigidMotion {
    let rotation = Matrix3::from_row_slice(&numbers(&value["rotation"]));
    RigidMotion::new(rotation, Vector3::from_row_slice(&numbers(&value["translation"]))).unwrap()
}

fn camera(value: &Value) -> Camera {
    let number = |key: &str| value[key].as_f64().unwrap();
    Camera::new(Intrinsics {
        width: number("width") as u32,
        height: number("height") as u32,
        fx: number("fx"),
        fy: number("fy"),
        cx: number("cx"),
        cy: number("cy"),
        distortion: Distortion::brown_conrady(&numbers(&value["distortion"])).unwrap(),
    })
    .unwrap()
}

impl View {
    fn read(folder: &Path, value: &Value) -> Self {
        let open = |key: &str| image::open(folder.join(value[key].as_str().unwrap())).unwrap();
        let camera_of_color = camera(&value["camera"]);
        let size = camera_of_color.size();
        let mut frame = Frame::new(camera_of_color);
        frame.set_pose(motion(&value["pose"]));
        let own =
            DepthCamera { camera: camera(&value["depth_camera"]), to_color: motion(&value["depth_camera"]) };
        let depth_size = own.camera.size();
        frame.set_depth_camera(Some(own)).unwrap();
        let depth = open("depth").into_luma16().into_raw();
        let scale = value["depth_scale"].as_f64().unwrap();
        let depth = DepthView::from_u16(&depth, depth_size, scale).unwrap();
        frame.set_depth(&depth, &DepthRange::default()).unwrap();
        let grey = open("image").into_luma8().into_raw();
        frame.set_image(&ImageView::from_u8(&grey, size).unwrap()).unwrap();
        let end = |q: &Value| Vector2::new(q[0].as_f64().unwrap(), q[1].as_f64().unwrap());
        let edge = |e: &Value| EdgeSegment { endpoints: [end(&e[0]), end(&e[1])], weight: 1.0 };
        let edges = value["edges"].as_array().unwrap().iter().map(edge).collect();
        Self { frame, mask: open("mask").into_luma8().into_raw(), edges }
    }

    /// The same with the depth resampled to the grid of the image.
    fn registered(&self) -> Self {
        let size = self.frame.camera().unwrap().size();
        let seen = self.frame.depth_on_image().unwrap();
        let pixels = (0..size.1).flat_map(|row| (0..size.0).map(move |column| (column, row)));
        let depths: Vec<f32> = pixels.map(|(x, y)| seen.depth(x, y).unwrap_or(0.0) as f32).collect();
        let mut frame = self.frame.clone();
        frame.clear_depth();
        frame.set_depth_camera(None).unwrap();
        let view = DepthView::from_f32(&depths, size, 1.0).unwrap();
        frame.set_depth(&view, &DepthRange::default()).unwrap();
        Self { frame, mask: self.mask.clone(), edges: self.edges.clone() }
    }

    fn push(&self, fitter: &mut Fitter) -> Result<(), Error> {
        let size = self.frame.camera().unwrap().size();
        fitter.use_frame(&self.frame, Some(&MaskView::from_u8(&self.mask, size)?))?;
        fitter.push_edges(&self.edges)
    }
}

impl Views {
    fn read(folder: &Path) -> Self {
        let truth = json(&folder.join("truth.json"));
        let frame = json(&folder.join("frame.json"));
        let views = frame["views"].as_array().unwrap().iter().map(|view| View::read(folder, view));
        Self {
            name: folder.file_name().unwrap().to_string_lossy().into_owned(),
            views: views.collect(),
            truth: cylinder(&truth, "center", "axis"),
            length: truth["length"].as_f64().unwrap(),
        }
    }

    fn fit<'a>(&self, views: impl Iterator<Item = &'a View>) -> Result<Fitter, Error> {
        let mut fitter = Fitter::new();
        for (index, view) in views.enumerate() {
            fitter.select_view(index)?;
            view.push(&mut fitter)?;
        }
        fitter.fit()?;
        Ok(fitter)
    }

    fn errors<'a>(&self, views: impl Iterator<Item = &'a View>) -> Option<Errors> {
        let fitter = self.fit(views).ok()?;
        let difference = self.truth.compare(&fitter.result()?.cylinder);
        let extent = fitter.extent(None, None).ok()?;
        Some([
            difference.angle.to_degrees(),
            (extent.center - self.truth.axis.point).norm() * 1e3,
            difference.radius_relative.abs() * 100.0,
            (extent.length / self.length - 1.0).abs() * 100.0,
        ])
    }

    /// The largest relative change of radius and of the axis (over the radius) when the views come in other orders.
    fn change_by_order(&self) -> f64 {
        let orders: [&[usize]; 4] = [&[0, 1, 2], &[2, 1, 0], &[1, 2, 0], &[1, 0, 2]];
        let fit = |order: &&[usize]| {
            let fitter = self.fit(order.iter().map(|&k| &self.views[k])).unwrap();
            fitter.result().unwrap().cylinder
        };
        let fits: Vec<Cylinder> = orders.iter().map(fit).collect();
        let change = |other: &Cylinder| {
            let difference = fits[0].compare(other);
            difference.radius_relative.abs().max(difference.angle)
        };
        fits.iter().map(change).fold(0.0, f64::max)
    }
}

/// All folders with views; empty where the set is not there.
pub fn read_views(shared: &Path) -> Vec<Views> {
    let Ok(entries) = std::fs::read_dir(shared.join("views")) else {
        eprintln!("skipped: no views in {}", shared.join("views").display());
        return Vec::new();
    };
    let mut folders: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    folders.retain(|folder| folder.join("truth.json").exists());
    folders.sort();
    map(&folders, |folder| Views::read(folder))
}

/// Views alone and together.
pub fn views(sets: &Sets) {
    let all = &sets.views;
    let list = |name: &str, errors: &[Option<Errors>]| {
        if sets.list {
            for (views, errors) in all.iter().zip(errors) {
                let text = errors.map_or("failed".into(), |e| e.map(|x| format!("{x:7.3}")).join(" "));
                eprintln!("{name:24} {:12} {text}", views.name);
            }
        }
    };
    print_head("views, depth not registered");
    let none = [Target::NONE; 4];
    let registered = map(all, |views| views.errors(std::iter::once(&views.views[0].registered())));
    print_row("first view, depth registered", &registered, &none);
    list("registered", &registered);
    let mut targets = columns(&registered).map(|column| Target::mean(column.mean));
    (targets[1], targets[3]) = (Target::NONE, Target::NONE);
    let first = map(all, |views| views.errors(std::iter::once(&views.views[0])));
    print_targets(&targets);
    print_row("first view", &first, &targets);
    list("first view", &first);
    let single: Vec<Option<Errors>> = map(all, |views| {
        views.views.iter().map(|view| views.errors(std::iter::once(view))).collect::<Vec<_>>()
    })
    .concat();
    print_row("single views", &single, &none);
    let targets = columns(&single).map(|column| Target::mean(column.mean * OF_SINGLE_VIEWS));
    print_targets(&targets);
    let together = map(all, |views| views.errors(views.views.iter()));
    print_row("three views", &together, &targets);
    list("three views", &together);
    let change = map(all, Views::change_by_order).into_iter().fold(0.0, f64::max);
    println!("\nLargest relative change by the order of the views: {change:.1e}\n");
}

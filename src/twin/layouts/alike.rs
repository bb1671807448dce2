//! Alike bodies that touch: piles of pipes, rods in a row, crossed layers, cans side by side.

use super::builder::{Builder, Cylindrical, random_material};
use super::table::{room, spin_of};
use crate::error::Result;
use crate::twin::random::Stream;
use crate::twin::scene::{Material, Scene, Style, Texture};
use crate::twin::shape::Shape;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

/// How wide a row is at most, in metres, and how many bodies it has at most.
const WIDE: f64 = 0.4;
const MANY: usize = 7;

/// Most layers of a pile.
const LAYERS: usize = 4;

/// The middles and axes of bodies.
type Poses = Vec<(Vector3<f64>, Vector3<f64>)>;

pub fn scene(stream: &mut Stream) -> Result<Scene> {
    let mut room = room(stream)?;
    let stands = stream.chance(0.25);
    let radius = stream.log_between(if stands { 0.018 } else { 0.008 }, 0.04);
    let style = match (stands, stream.chance(0.3)) {
        (_, true) => Style::Open,
        (true, false) => Style::Can,
        (false, false) => Style::Plain,
    };
    let length = if stands { radius * stream.between(2.2, 5.0) } else { stream.between(0.15, 0.45) };
    let body = Cylindrical::random(style, radius, length, stream);
    let gap = if stream.chance(0.5) { 0.0 } else { stream.between(0.0, 0.3) };
    let pitch = body.widest() * (2.0 + gap);
    let row = ((WIDE / pitch) as usize).clamp(2, MANY);
    let turn = stream.between(-0.5 * PI, 0.5 * PI);
    let poses = match (stands, stream.below(3)) {
        (true, _) => standing(&body, pitch, row, stream),
        (false, 0) => pile(&body, pitch, row, stream),
        (false, 1) => layer(&body, pitch, row, stream),
        _ => crossed(&body, pitch, row, stream),
    };
    if !stands && stream.chance(0.4) {
        walls(&mut room, &body, pitch * row as f64, turn, stream)?;
    }
    let (sine, cosine) = libm::sincos(turn);
    let rotation = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
    let material = random_material(stream);
    for (middle, axis) in poses {
        let material = alike(&material, stream);
        room.cylinder(&body, (rotation * middle, rotation * axis), material, None)?;
    }
    Ok(room.scene)
}

/// Where the k-th of some bodies is in a row.
fn in_row(k: usize, count: usize, pitch: f64) -> f64 {
    (k as f64 - 0.5 * (count as f64 - 1.0)) * pitch
}

/// Cans on their ends in two or three rows.
fn standing(body: &Cylindrical, pitch: f64, row: usize, stream: &mut Stream) -> Poses {
    let rows = 2 + stream.below(2);
    let at = |k| Vector3::new(in_row(k % row, row, pitch), in_row(k / row, rows, pitch), 0.5 * body.whole());
    (0..row * rows).map(|k| (at(k), Vector3::z())).collect()
}

/// Bodies that lie side by side. Their ends stick out a little.
fn layer(body: &Cylindrical, pitch: f64, row: usize, stream: &mut Stream) -> Poses {
    let mut pose = |k| {
        let along = stream.between(-0.05, 0.05) * body.length;
        (Vector3::new(in_row(k, row, pitch), along, body.widest()), Vector3::y())
    };
    (0..row).map(&mut pose).collect()
}

/// Layers of which each lies in the grooves of the one below.
fn pile(body: &Cylindrical, pitch: f64, row: usize, stream: &mut Stream) -> Poses {
    let rise = (4.0 * body.widest().powi(2) - 0.25 * pitch * pitch).sqrt();
    let mut poses = Poses::new();
    for level in 0..row.min(LAYERS) {
        let up = Vector3::z() * (rise * level as f64);
        poses.extend(layer(body, pitch, row - level, stream).iter().map(|(at, axis)| (at + up, *axis)));
    }
    poses
}

/// A layer, and one on top across it.
fn crossed(body: &Cylindrical, pitch: f64, row: usize, stream: &mut Stream) -> Poses {
    let mut poses = layer(body, pitch, row, stream);
    let above = ((body.length / pitch) as usize).clamp(1, row);
    let up = Vector3::z() * (2.0 * body.widest());
    let turned = |at: &Vector3<f64>| Vector3::new(at.y, at.x, at.z) + up;
    poses.extend(layer(body, pitch, above, stream).iter().map(|(at, _)| (turned(at), Vector3::x())));
    poses
}

/// The long walls of a box about a row.
fn walls(room: &mut Builder, body: &Cylindrical, wide: f64, turn: f64, stream: &mut Stream) -> Result<()> {
    let half = Vector3::new(0.004, 0.55 * body.length, body.widest() * stream.between(0.6, 2.0));
    let material = random_material(stream);
    let (sine, cosine) = libm::sincos(turn);
    for side in [-1.0, 1.0] {
        let across = side * (0.5 * wide + half.x);
        let at = Vector3::new(cosine * across, sine * across, half.z);
        let object = room.new_object();
        room.add(object, Shape::Box { half }, (at, Vector3::z(), spin_of(turn)), material)?;
    }
    Ok(())
}

/// The same material with a pattern of its own.
fn alike(material: &Material, stream: &mut Stream) -> Material {
    let seed = stream.seed();
    let texture = match material.texture {
        Texture::Plain => Texture::Plain,
        Texture::Cells { size, share, contrast, .. } => Texture::Cells { size, share, contrast, seed },
        Texture::Grain { size, contrast, .. } => Texture::Grain { size, contrast, seed },
    };
    Material { texture, ..*material }
}

//! Long pipes before a wall.

use super::builder::{Builder, Cylindrical, random_ground, random_material};
use crate::error::Result;
use crate::geometry::Line;
use crate::twin::random::Stream;
use crate::twin::scene::{Scene, Style};
use nalgebra::Vector3;

/// How often a free position is looked for.
const TRIES: usize = 40;

pub fn scene(stream: &mut Stream) -> Result<Scene> {
    // Straight ahead: x to the right, y away, z up, the origin in the middle of the image.
    let distance = stream.between(0.8, 1.2);
    let mut room = Builder::new(distance, 0.0, 0.0)?;
    let lamp = Vector3::new(
        stream.between(-1.0, 1.0),
        -distance - stream.between(0.0, 0.6),
        stream.between(-0.3, 1.5),
    );
    room.light(lamp, stream.between(0.25, 0.6));
    let ground = random_ground(stream);
    let tilt = Vector3::new(stream.between(-0.25, 0.25), -1.0, stream.between(-0.25, 0.25));
    room.plane(Vector3::new(0.0, 0.3, 0.0), tilt, ground)?;
    let mut taken: Vec<(Line, f64)> = Vec::new();
    let mut beside: Option<(Line, f64)> = None;
    for _ in 0..3 + stream.below(4) {
        let radius = stream.log_between(0.012, 0.06);
        for _ in 0..TRIES {
            let line = match beside {
                // Side by side with the one before.
                Some((line, other)) if stream.chance(0.35) => {
                    let aside = line.direction.cross(&Vector3::y()).normalize();
                    let apart = radius + other + stream.between(0.002, 0.03);
                    Line::new(line.point + aside * apart, line.direction)
                }
                _ => {
                    let (sine, cosine) = libm::sincos(stream.between(0.0, std::f64::consts::PI));
                    let away = stream.between(-0.3, 0.3);
                    let at = Vector3::new(
                        stream.between(-0.35, 0.35),
                        stream.between(-0.15, 0.1),
                        stream.between(-0.25, 0.25),
                    );
                    Line::new(at, Vector3::new(cosine, away, sine))
                }
            };
            if taken.iter().any(|(other, size)| line.distance_to_line(other) < radius + size) {
                continue;
            }
            taken.push((line, radius));
            beside = Some((line, radius));
            let style = if stream.chance(0.3) { Style::Open } else { Style::Plain };
            let length = stream.between(0.5, 1.6);
            let pipe = Cylindrical::random(style, radius, length, stream);
            let middle = line.at(stream.between(-0.15, 0.15));
            room.cylinder(&pipe, (middle, line.direction), random_material(stream), None)?;
            break;
        }
    }
    Ok(room.scene)
}

//! Things on a table.

use super::builder::{Builder, Cylindrical, Footprint, random_ground, random_material};
use crate::error::Result;
use crate::twin::random::Stream;
use crate::twin::scene::{Scene, Style};
use crate::twin::shape::Shape;
use nalgebra::{Vector2, Vector3};
use std::f64::consts::{PI, TAU};

/// How often a free position is looked for.
const TRIES: usize = 40;

/// The half sides of the part of the table that things stand on, in metres.
const AREA: [f64; 2] = [0.3, 0.24];

pub fn scene(stream: &mut Stream) -> Result<Scene> {
    let mut room = room(stream)?;
    for _ in 0..5 + stream.below(5) {
        match stream.below(10) {
            0..3 => standing(&mut room, stream)?,
            3..5 => lying(&mut room, stream)?,
            5 => leaning(&mut room, stream)?,
            6 => bottle(&mut room, stream)?,
            7 => block(&mut room, stream)?,
            8 => ball(&mut room, stream)?,
            _ => frustum(&mut room, stream)?,
        }
    }
    Ok(room.scene)
}

/// A table, seen from above, with a wall behind it at times.
pub fn room(stream: &mut Stream) -> Result<Builder> {
    let distance = stream.between(0.65, 0.95);
    let elevation = stream.between(0.45, 1.0);
    let mut room = Builder::new(distance, elevation, stream.between(-0.08, 0.08))?;
    room.random_light(stream);
    let ground = random_ground(stream);
    room.plane(Vector3::zeros(), Vector3::z(), ground)?;
    if stream.chance(0.3) {
        let wall = random_ground(stream);
        let at = Vector3::new(0.0, stream.between(0.45, 0.8), 0.0);
        room.plane(at, Vector3::new(stream.between(-0.2, 0.2), -1.0, 0.0), wall)?;
    }
    Ok(room)
}

fn position(stream: &mut Stream) -> Vector2<f64> {
    Vector2::new(stream.between(-AREA[0], AREA[0]), stream.between(-AREA[1], AREA[1]))
}

fn random_cylinder(stream: &mut Stream) -> Cylindrical {
    let style = [Style::Can, Style::Can, Style::Plain, Style::Open][stream.below(4)];
    let radius = stream.log_between(0.014, 0.055);
    let length = (radius * stream.between(2.2, 6.0)).clamp(0.05, 0.24);
    Cylindrical::random(style, radius, length, stream)
}

/// A cylinder on its end, at times with a smaller one on top.
fn standing(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let cylinder = random_cylinder(stream);
    for _ in 0..TRIES {
        let at = position(stream);
        if !room.claim(Footprint::disc(at, cylinder.widest())) {
            continue;
        }
        let height = cylinder.whole();
        let middle = Vector3::new(at.x, at.y, 0.5 * height);
        room.cylinder(&cylinder, (middle, Vector3::z()), random_material(stream), None)?;
        if cylinder.style != Style::Open && height < 0.16 && stream.chance(0.25) {
            let radius = cylinder.radius * stream.between(0.6, 0.95);
            let length = (radius * stream.between(2.0, 4.0)).clamp(0.04, 0.14);
            let upper = Cylindrical::random(Style::Can, radius, length, stream);
            let middle = Vector3::new(at.x, at.y, height + 0.5 * upper.whole());
            room.cylinder(&upper, (middle, Vector3::z()), random_material(stream), None)?;
        }
        return Ok(());
    }
    Ok(())
}

/// A cylinder on its side.
fn lying(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let cylinder = random_cylinder(stream);
    for _ in 0..TRIES {
        let (at, turn) = (position(stream), stream.between(0.0, PI));
        let (sine, cosine) = libm::sincos(turn);
        let reach = (0.5 * cylinder.whole() - cylinder.widest()).max(0.0) + 0.2 * cylinder.widest();
        let along = Vector2::new(cosine, sine) * reach;
        if room.claim(Footprint { ends: [at - along, at + along], radius: cylinder.widest() }) {
            let middle = Vector3::new(at.x, at.y, cylinder.widest());
            let axis = Vector3::new(cosine, sine, 0.0);
            room.cylinder(&cylinder, (middle, axis), random_material(stream), None)?;
            break;
        }
    }
    Ok(())
}

/// A bar or tube that stands on its rim and leans on a box.
fn leaning(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let style = if stream.chance(0.5) { Style::Open } else { Style::Plain };
    let radius = stream.log_between(0.012, 0.035);
    let length = stream.between(0.12, 0.24);
    let cylinder = Cylindrical::random(style, radius, length, stream);
    let steep = stream.between(0.6, 1.2);
    let (sine, cosine) = libm::sincos(steep);
    // The lowest line of the cylinder passes the upper edge of the box at this share of the length.
    let height = stream.between(0.5, 0.85) * length * sine;
    let edge = height * cosine / sine;
    let half = Vector3::new(stream.between(0.02, 0.04), stream.between(0.03, 0.06), 0.5 * height);
    for _ in 0..TRIES {
        let (at, turn) = (position(stream), stream.between(0.0, TAU));
        let (east, north) = libm::sincos(turn);
        let forward = Vector2::new(north, east);
        let end = at + forward * (edge + 2.0 * half.x);
        if !room.claim(Footprint { ends: [at - forward * radius, end], radius: half.y.max(radius) }) {
            continue;
        }
        let along = Vector3::new(forward.x * cosine, forward.y * cosine, sine);
        let up = Vector3::new(-forward.x * sine, -forward.y * sine, cosine);
        let rim = Vector3::new(at.x, at.y, 0.0);
        let middle = rim + along * (0.5 * length) + up * radius;
        room.cylinder(&cylinder, (middle, along), random_material(stream), None)?;
        let center = at + forward * (edge + half.x);
        let object = room.new_object();
        let shape = Shape::Box { half };
        let at = Vector3::new(center.x, center.y, half.z);
        room.add(object, shape, (at, Vector3::z(), spin_of(turn)), random_material(stream))?;
        break;
    }
    Ok(())
}

/// The spin that turns the x axis of an upright body to an angle in the room.
pub fn spin_of(turn: f64) -> f64 {
    let (u, _) = crate::geometry::any_orthogonal(&Vector3::z());
    turn - libm::atan2(u.y, u.x)
}

/// A body, a shoulder and a neck.
fn bottle(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let radius = stream.between(0.025, 0.045);
    let neck = radius * stream.between(0.3, 0.45);
    let [body, shoulder, top] =
        [stream.between(0.08, 0.14), stream.between(0.03, 0.06), stream.between(0.03, 0.06)];
    for _ in 0..TRIES {
        let at = position(stream);
        if !room.claim(Footprint::disc(at, radius)) {
            continue;
        }
        let object = room.new_object();
        let material = random_material(stream);
        let middle = |height: f64| (Vector3::new(at.x, at.y, height), Vector3::z());
        let piece = |radius, length| Cylindrical {
            style: Style::Plain,
            radius,
            length,
            lid: 0.0,
            lid_radius: radius,
        };
        room.cylinder(&piece(radius, body), middle(0.5 * body), material, Some(object))?;
        let shape = Shape::Turned { radii: [radius, neck], length: shoulder, bore: None };
        let (point, axis) = middle(body + 0.5 * shoulder);
        room.add(object, shape, (point, axis, 0.0), material)?;
        room.cylinder(&piece(neck, top), middle(body + shoulder + 0.5 * top), material, Some(object))?;
        break;
    }
    Ok(())
}

/// A box, upright or turned, at times with a smaller one on it.
pub fn block(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let half =
        Vector3::new(stream.between(0.015, 0.07), stream.between(0.015, 0.07), stream.between(0.01, 0.08));
    for _ in 0..TRIES {
        let (at, turn) = (position(stream), stream.between(0.0, PI));
        if !room.claim(Footprint::disc(at, half.xy().norm())) {
            continue;
        }
        let object = room.new_object();
        let middle = Vector3::new(at.x, at.y, half.z);
        room.add(object, Shape::Box { half }, (middle, Vector3::z(), turn), random_material(stream))?;
        if stream.chance(0.25) {
            let upper = half * stream.between(0.4, 0.8);
            let middle = Vector3::new(at.x, at.y, 2.0 * half.z + upper.z);
            let object = room.new_object();
            let turn = stream.between(0.0, PI);
            let shape = Shape::Box { half: upper };
            room.add(object, shape, (middle, Vector3::z(), turn), random_material(stream))?;
        }
        break;
    }
    Ok(())
}

/// A sphere.
pub fn ball(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let radius = stream.log_between(0.015, 0.08);
    for _ in 0..TRIES {
        let at = position(stream);
        if room.claim(Footprint::disc(at, radius)) {
            let object = room.new_object();
            let middle = (Vector3::new(at.x, at.y, radius), Vector3::z(), 0.0);
            room.add(object, Shape::Sphere { radius }, middle, random_material(stream))?;
            break;
        }
    }
    Ok(())
}

/// A frustum whose wall leans by 4 to 20 degrees, on either end or on its side; open ones are cups.
pub fn frustum(room: &mut Builder, stream: &mut Stream) -> Result<()> {
    let wide = stream.log_between(0.02, 0.06);
    let lean = stream.between(4.0, 20.0).to_radians();
    let (sine, cosine) = libm::sincos(lean);
    let tangent = sine / cosine;
    let length = (wide * stream.between(1.5, 4.0)).min(0.8 * wide / tangent);
    let narrow = wide - length * tangent;
    let upside_down = stream.chance(0.5);
    let on_its_side = stream.chance(0.25);
    for _ in 0..TRIES {
        let (at, turn) = (position(stream), stream.between(0.0, TAU));
        let reach = if on_its_side { 0.5 * length + wide } else { wide };
        if !room.claim(Footprint::disc(at, reach)) {
            continue;
        }
        let radii = if upside_down { [narrow, wide] } else { [wide, narrow] };
        let shape = Shape::Turned { radii, length, bore: None };
        let object = room.new_object();
        let (height, axis) = if on_its_side {
            // A line of its wall lies on the table.
            let (east, north) = libm::sincos(turn);
            let rise = if upside_down { sine } else { -sine };
            (0.5 * (wide + narrow) * cosine, Vector3::new(north * cosine, east * cosine, rise))
        } else {
            (0.5 * length, Vector3::z())
        };
        let middle = Vector3::new(at.x, at.y, height);
        room.add(object, shape, (middle, axis, 0.0), random_material(stream))?;
        break;
    }
    Ok(())
}

//! The wheel and the JAR of the frozen release: their structs, kept as sizes and offsets, against those of today, and in use.

use crate::common::{root, run, scratch};
use crate::{freeze, frozen};
use cylfuse::ffi::*;
use std::collections::BTreeMap;
use std::process::Command;
use std::ptr::{null, null_mut};

/// Where a field lies in its struct, in bytes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Field {
    offset: usize,
    size: usize,
}

#[derive(Debug, Clone)]
struct Struct {
    size: usize,
    fields: BTreeMap<String, Field>,
}

type Layout = BTreeMap<String, Struct>;

/// Name and offset of a field, and its size where the line says it.
type Line = (String, usize, Option<usize>);

/// Reads lines `name size` of structs, below each `    name offset size` of its fields. Without the size of a field it
/// reaches to the next: tests/abi_layout.rs checks that nothing lies between.
fn parse(text: &str) -> Layout {
    let mut structs: Vec<(String, usize, Vec<Line>)> = Vec::new();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let name = words.next().unwrap().to_string();
        let mut number = || words.next().map(|word| word.parse().unwrap());
        let first = number().unwrap();
        if line.starts_with(' ') {
            structs.last_mut().unwrap().2.push((name, first, number()));
        } else {
            structs.push((name, first, Vec::new()));
        }
    }
    let field_ends =
        |size: usize, fields: &[Line], k: usize| fields.get(k + 1).map_or(size, |(_, offset, _)| *offset);
    let read = structs.into_iter().map(|(name, size, fields)| {
        let placed = fields.iter().enumerate().map(|(k, (name, offset, own))| {
            let size = own.unwrap_or(field_ends(size, &fields, k) - offset);
            (name.clone(), Field { offset: *offset, size })
        });
        (name, Struct { size, fields: placed.collect() })
    });
    read.collect()
}

/// The structs of both packages, as kept; written anew where the interface is frozen again.
fn kept() -> [(&'static str, Layout); 2] {
    let read = |package: &str, printed: &dyn Fn() -> String| {
        let path = frozen().join(format!("{package}_layout.txt"));
        if freeze() {
            std::fs::write(&path, printed()).unwrap();
        }
        parse(&std::fs::read_to_string(&path).unwrap())
    };
    [("wheel", read("wheel", &structs_of_the_wheel)), ("jar", read("jar", &structs_of_the_jar))]
}

fn structs_of_the_wheel() -> String {
    let script = root().join("tests/abi/wheel_layout.py");
    run(Command::new("python3").arg(script).arg(root().join("bindings/python/src/cylfuse/_structs.py")))
}

fn structs_of_the_jar() -> String {
    let (folder, jna) = (scratch("abi_jar"), "/usr/share/java/jna.jar");
    let structs = root().join("bindings/java/src/main/java/org/cylfuse/NativeStructs.java");
    let program = root().join("tests/abi/JarLayout.java");
    run(Command::new("javac").args(["-cp", jna, "-d"]).arg(&folder).arg(structs).arg(program));
    let classes = format!("{}:{jna}", folder.display());
    run(Command::new("java").args(["-cp", &classes, "org.cylfuse.JarLayout"]))
}

/// What breaks programs that know the structs as `old`.
fn breaks(old: &Layout, new: &Layout, may_grow: impl Fn(&str) -> bool) -> Vec<String> {
    let mut found = Vec::new();
    for (name, before) in old {
        let Some(now) = new.get(name) else {
            found.push(format!("{name} is gone"));
            continue;
        };
        if now.size < before.size || now.size > before.size && !may_grow(name) {
            found.push(format!("{name} has {} bytes, it had {}", now.size, before.size));
        }
        for (field, place) in &before.fields {
            if now.fields.get(field) != Some(place) {
                found.push(format!("{name}.{field} is {:?}, it was {place:?}", now.fields.get(field)));
            }
        }
    }
    found
}

#[test]
#[cfg(target_pointer_width = "64")]
fn structs_of_the_wheel_and_the_jar_are_those_of_today_or_have_grown_as_they_may() {
    let now = parse(&std::fs::read_to_string(root().join("tests/data/abi_layout.txt")).unwrap());
    let suppressions = std::fs::read_to_string(root().join("tests/abi/may-grow.suppr")).unwrap();
    let names = suppressions.split("^cylfuse_(").nth(1).and_then(|rest| rest.split(')').next()).unwrap();
    let names: Vec<String> = names.split('|').map(|name| format!("cylfuse_{name}")).collect();
    for (package, then) in kept() {
        assert!(then.len() >= 23, "{package}");
        let found = breaks(&then, &now, |name| names.iter().any(|one| one == name));
        assert!(found.is_empty(), "the {package} of then: {found:?}");
    }
    // What the check would miss nobody would see.
    let (_, then) = &kept()[0];
    let changed = |change: &dyn Fn(&mut Layout)| {
        let mut later = now.clone();
        change(&mut later);
        breaks(then, &later, |name| names.iter().any(|one| one == name)).len()
    };
    let grown = |name: &'static str| move |later: &mut Layout| later.get_mut(name).unwrap().size += 8;
    let moved = |later: &mut Layout| {
        let options = later.get_mut("cylfuse_options").unwrap();
        options.fields.get_mut("seed").unwrap().offset += 8;
        options.fields.get_mut("method").unwrap().size += 4;
    };
    assert_eq!(changed(&grown("cylfuse_options")), 0);
    assert_eq!(changed(&grown("cylfuse_cylinder")), 1);
    assert_eq!(changed(&moved), 2);
    assert_eq!(changed(&|later| drop(later.remove("cylfuse_limb"))), 1);
}

/// A struct, or several, in the memory of a program that knows it as a package did, with bytes behind that are the program's
/// own.
struct Memory {
    words: Vec<u64>,
    of: Struct,
}

/// Those bytes.
const OWN: [u64; 2] = [0x0123_4567_89ab_cdef; 2];

impl Memory {
    fn new(layout: &Layout, name: &str, count: usize) -> Self {
        let of = layout[name].clone();
        let mut words = vec![0; count * of.size / 8];
        words.extend(OWN);
        Self { words, of }
    }

    /// With what an `..._init` function writes.
    fn filled<T>(
        layout: &Layout,
        name: &str,
        fill: unsafe extern "C" fn(*mut T, usize) -> cylfuse_status,
    ) -> Self {
        let mut memory = Self::new(layout, name, 1);
        // SAFETY: so many bytes are there.
        let status = unsafe { fill(memory.pointer(), memory.of.size) };
        assert_eq!(status, cylfuse_status::OK, "{name}");
        assert_eq!(memory.bits("struct_size"), memory.of.size as u64, "{name}");
        assert!(memory.is_whole(), "{name}");
        memory
    }

    fn pointer<T>(&mut self) -> *mut T {
        self.words.as_mut_ptr().cast()
    }

    fn bytes(&mut self, field: &str) -> &mut [u8] {
        let Field { offset, size } = self.of.fields[field];
        // SAFETY: any bytes make a u8, and the words are so many bytes.
        let all = unsafe { std::slice::from_raw_parts_mut(self.pointer::<u8>(), 8 * self.words.len()) };
        &mut all[offset..offset + size]
    }

    fn set<const N: usize>(mut self, field: &str, bytes: [u8; N]) -> Self {
        self.bytes(field).copy_from_slice(&bytes);
        self
    }

    fn size(self, width: u32, height: u32) -> Self {
        self.set("width", width.to_ne_bytes()).set("height", height.to_ne_bytes())
    }

    fn bits(&mut self, field: &str) -> u64 {
        let bytes = self.bytes(field);
        match bytes.len() {
            4 => u32::from_ne_bytes(bytes.try_into().unwrap()).into(),
            _ => u64::from_ne_bytes(bytes.try_into().unwrap()),
        }
    }

    fn number(&mut self, field: &str) -> f64 {
        f64::from_bits(self.bits(field))
    }

    fn is_whole(&self) -> bool {
        self.words.ends_with(&OWN)
    }
}

const SIZE: [u32; 2] = [160, 120];

/// A pipe of radius 50 mm across the view, 0.6 m away, in tenths of millimetres.
fn pipe() -> Vec<u16> {
    let depth = |k: u32| {
        let x = (f64::from(k % SIZE[0]) - 79.5) / 150.0;
        let a = x * x + 1.0;
        let root = 0.36 - a * (0.36 - 0.0025);
        if root < 0.0 { 0 } else { ((0.6 - root.sqrt()) / a * 10_000.0).round() as u16 }
    };
    (0..SIZE[0] * SIZE[1]).map(depth).collect()
}

/// Runs a call that must succeed.
fn ok(status: cylfuse_status) {
    assert_eq!(status, cylfuse_status::OK);
}

#[test]
#[cfg(target_pointer_width = "64")]
fn programs_with_the_structs_of_the_wheel_and_the_jar_run() {
    for (_, layout) in kept() {
        fits(&layout);
    }
}

fn fits(layout: &Layout) {
    let depth = pipe();
    let mask: Vec<u8> = depth.iter().map(|z| u8::from(*z > 0)).collect();
    let image: Vec<u8> = mask.iter().map(|inside| 40 + 120 * inside).collect();
    let address = |data: *const u8| (data as usize).to_ne_bytes();
    let memory = |name: &str| Memory::new(layout, &format!("cylfuse_{name}"), 4);

    let mut options = Memory::filled(layout, "cylfuse_options", cylfuse_options_init)
        .set("radius_max", 1.0_f64.to_ne_bytes());
    assert_eq!((options.number("edge_weight"), options.bits("max_iterations")), (0.6, 400));
    let mut intrinsics = Memory::filled(layout, "cylfuse_intrinsics", cylfuse_intrinsics_init);
    intrinsics = intrinsics.size(SIZE[0], SIZE[1]);
    for (field, value) in [("fx", 150.0_f64), ("fy", 150.0), ("cx", 79.5), ("cy", 59.5)] {
        intrinsics = intrinsics.set(field, value.to_ne_bytes());
    }
    let mut depth_view = Memory::filled(layout, "cylfuse_depth_view", cylfuse_depth_view_init)
        .size(SIZE[0], SIZE[1])
        .set("format", cylfuse_depth_format::U16.0.to_ne_bytes())
        .set("data", address(depth.as_ptr().cast()))
        .set("scale", 0.0001_f64.to_ne_bytes());
    let mut mask_view = Memory::filled(layout, "cylfuse_mask_view", cylfuse_mask_view_init)
        .size(SIZE[0], SIZE[1])
        .set("data", address(mask.as_ptr()));
    let mut image_view = Memory::filled(layout, "cylfuse_image_view", cylfuse_image_view_init)
        .size(SIZE[0], SIZE[1])
        .set("format", cylfuse_image_format::U8.0.to_ne_bytes())
        .set("data", address(image.as_ptr()));
    let mut counts = Memory::filled(layout, "cylfuse_counts", cylfuse_counts_init);
    let mut result = Memory::filled(layout, "cylfuse_result", cylfuse_result_init);
    let mut estimate = Memory::filled(layout, "cylfuse_cylinder_estimate", cylfuse_cylinder_estimate_init);
    let mut extent = Memory::filled(layout, "cylfuse_extent", cylfuse_extent_init);
    let (mut limb, mut found, mut count) = (memory("limb"), memory("detection"), 0);
    let (mut fitter, mut frame, mut detector) = (null_mut(), null_mut(), null_mut());
    // SAFETY: the memory has the sizes that it says, and lives until all handles are gone.
    unsafe {
        ok(cylfuse_fitter_create(CYLFUSE_ABI_VERSION, &raw mut fitter));
        ok(cylfuse_fitter_set_options(fitter, options.pointer()));
        ok(cylfuse_fitter_set_intrinsics(fitter, intrinsics.pointer()));
        ok(cylfuse_fitter_push_depth(fitter, depth_view.pointer(), mask_view.pointer()));
        ok(cylfuse_fitter_push_image(fitter, image_view.pointer()));
        ok(cylfuse_fitter_counts(fitter, counts.pointer()));
        ok(cylfuse_fitter_fit(fitter, result.pointer(), estimate.pointer()));
        ok(cylfuse_fitter_extent(fitter, null(), null(), extent.pointer()));
        ok(cylfuse_fitter_limbs(fitter, limb.pointer(), limb.of.size, 4, &raw mut count));
        ok(cylfuse_fitter_destroy(fitter));
        // The second element: view and limb.
        limb.words.rotate_left(limb.of.size / 8);
        assert_eq!((count, limb.bits("view"), limb.bits("limb")), (2, 0, 1));
        limb.words.rotate_right(limb.of.size / 8);
        ok(cylfuse_frame_create(CYLFUSE_ABI_VERSION, &raw mut frame));
        ok(cylfuse_frame_set_intrinsics(frame, intrinsics.pointer()));
        ok(cylfuse_frame_set_depth(frame, depth_view.pointer()));
        ok(cylfuse_detector_create(CYLFUSE_ABI_VERSION, &raw mut detector));
        ok(cylfuse_detector_detect(detector, frame));
        ok(cylfuse_detector_detections(detector, found.pointer(), found.of.size, 4, &raw mut count));
        ok(cylfuse_detector_destroy(detector));
        ok(cylfuse_frame_destroy(frame));
    }
    let of_model = |memory: &mut Memory, field: &str| {
        let place = memory.of.fields["model"].offset + layout["cylfuse_cylinder"].fields[field].offset;
        f64::from_bits(memory.words[place / 8])
    };
    let used = counts.bits("points_used");
    assert!(used > 1000 && result.bits("points_used") == used, "{used}");
    assert!((of_model(&mut estimate, "radius") - 0.05).abs() < 3e-3);
    assert!((of_model(&mut found, "radius") - 0.05).abs() < 2e-3);
    assert!(estimate.number("radius_deviation") > 0.0 && extent.number("length") > 0.3);
    for written in [&counts, &result, &estimate, &extent, &limb, &found] {
        assert!(written.is_whole(), "the library writes behind {:?}", written.of);
    }
}

//! Input that is wrong: its own status, a message with file, value and remedy, never a panic.

use crate::support::{Copy, data, fails, fit, fitted, run};
use image::{DynamicImage, GrayImage, ImageBuffer, Luma};
use serde_json::{Value, json};

#[test]
fn missing_fields_are_named() {
    for field in ["camera", "depth", "depth_scale"] {
        let mut copy = Copy::new();
        copy.json.as_object_mut().unwrap().remove(field);
        let missing = format!("missing field `{field}`");
        fails(
            &copy.write(),
            &[],
            "BAD_FRAME",
            &["frame.json", &missing, "cylfuse fit --help lists the fields"],
        );
    }
    for field in ["width", "height", "fx", "fy", "cx", "cy"] {
        let mut copy = Copy::new();
        copy.json["camera"].as_object_mut().unwrap().remove(field);
        fails(&copy.write(), &[], "BAD_FRAME", &["frame.json: camera", &format!("missing field `{field}`")]);
    }
}

#[test]
fn unknown_fields_are_named() {
    let mut copy = Copy::new();
    copy.json["colour"] = "image.png".into();
    fails(&copy.write(), &[], "BAD_FRAME", &["frame.json", "unknown field `colour`"]);
    let mut copy = Copy::new();
    copy.json["camera"]["skew"] = 0.into();
    fails(&copy.write(), &[], "BAD_FRAME", &["frame.json: camera", "unknown field `skew`"]);
}

#[test]
fn fields_of_another_type_are_named() {
    for (pointer, value, fragments) in [
        ("/camera/fx", json!("570"), &["camera.fx", "expected f64"][..]),
        ("/camera/width", json!(640.5), &["camera.width", "expected u32"]),
        ("/camera/width", json!(-640), &["camera.width", "-640"]),
        ("/camera/distortion", json!(null), &["camera.distortion", "null"]),
        ("/camera/distortion/2", json!("x"), &["camera.distortion[2]"]),
        ("/depth", json!(3), &["depth"]),
        ("/depth_scale", json!(null), &["depth_scale"]),
        ("/edges/1/0", json!([1.0]), &["edges[1][0]"]),
        ("/edges/0", json!([[1, 2], [3, 4], [5, 6]]), &["edges[0]"]),
        ("/edges/0/0/1", json!(null), &["edges[0][0][1]"]),
    ] {
        let mut copy = Copy::new();
        *copy.json.pointer_mut(pointer).unwrap() = value;
        fails(&copy.write(), &[], "BAD_FRAME", &[&["frame.json"], fragments].concat());
    }
}

#[test]
fn files_that_are_no_json_are_refused() {
    let copy = Copy::new();
    let whole = copy.json.to_string();
    let frame = copy.write();
    let huge_number = whole.replace("570.0", "1e999");
    for content in
        ["", "[]", "nonsense", "{\"camera\": 1}", "\u{feff}{}", &whole[..whole.len() / 2], &huge_number]
    {
        std::fs::write(&frame, content).unwrap();
        fails(&frame, &[], "BAD_FRAME", &["frame.json"]);
    }
    // An image that is named in place of its frame.
    fails(
        &data("r40_a20_f0").join("depth.png"),
        &[],
        "BAD_FRAME",
        &["depth.png", "name a frame.json or a folder"],
    );
    std::fs::write(&frame, format!("{whole} x")).unwrap();
    fails(&frame, &[], "BAD_FRAME", &["trailing characters"]);
    std::fs::write(&frame, [0xff, 0xfe, 0x00]).unwrap();
    fails(&frame, &[], "BAD_FRAME", &["frame.json"]);
    std::fs::write(&frame, "[".repeat(100_000)).unwrap();
    fails(&frame, &[], "BAD_FRAME", &["frame.json"]);
}

#[test]
fn values_that_no_camera_has_are_refused() {
    for (pointer, value, status, fragments) in [
        ("/camera/fx", json!(0), "INVALID_INTRINSICS", ["fx is 0", "above 0"]),
        ("/camera/fy", json!(-570.0), "INVALID_INTRINSICS", ["fy is -570", "above 0"]),
        ("/camera/width", json!(0), "INVALID_INTRINSICS", ["width is 0", "at least 1"]),
        ("/camera/height", json!(4_000_000_000_u32), "INVALID_INTRINSICS", ["640 x 4000000000", "at most"]),
        ("/depth_scale", json!(0), "INVALID_ARGUMENT", ["depth scale is 0", "greater than 0"]),
        ("/depth_scale", json!(-0.001), "INVALID_ARGUMENT", ["depth scale is -0.001", "greater than 0"]),
        ("/image_gamma", json!(22), "INVALID_ARGUMENT", ["gamma of the image is 22", "[0.1, 10]"]),
    ] {
        let mut copy = Copy::new();
        copy.json["image_gamma"] = json!(1);
        *copy.json.pointer_mut(pointer).unwrap() = value;
        fails(&copy.write(), &[], status, &fragments);
    }
}

#[test]
fn files_that_cannot_be_read_are_named() {
    for name in ["image", "depth", "mask"] {
        let mut copy = Copy::new();
        copy.json[name] = "missing.png".into();
        fails(&copy.write(), &[], "FILE_NOT_READABLE", &["missing.png"]);
        copy.json[name] = ".".into();
        fails(&copy.write(), &[], "FILE_NOT_READABLE", &["directory"]);
    }
    fails(&data("missing/frame.json"), &[], "FILE_NOT_READABLE", &["frame.json"]);
    let empty = tempfile::tempdir().unwrap();
    fails(empty.path(), &[], "NO_FRAMES", &["no frame.json"]);
}

#[test]
fn damaged_images_are_named() {
    for name in ["image.png", "depth.png", "mask.png"] {
        let copy = Copy::new();
        let frame = copy.write();
        let whole = std::fs::read(copy.path(name)).unwrap();
        for length in [0, 5, 30, 60, whole.len() / 2, whole.len() - 30] {
            std::fs::write(copy.path(name), &whole[..length]).unwrap();
            fails(&frame, &[], "BAD_IMAGE", &[name]);
        }
        std::fs::write(copy.path(name), "no image").unwrap();
        fails(&frame, &[], "BAD_IMAGE", &[name]);
    }
}

#[test]
fn garbage_never_ends_in_a_panic() {
    let copy = Copy::new();
    let frame = copy.write();
    for name in ["depth.png", "mask.png"] {
        let whole = std::fs::read(copy.path(name)).unwrap();
        for step in 1..20 {
            let mut spoilt = whole.clone();
            for at in (step * 3..spoilt.len()).step_by(step * 97 + 13) {
                spoilt[at] ^= (at % 255 + 1) as u8;
            }
            std::fs::write(copy.path(name), &spoilt).unwrap();
            let run = fit(&frame, &[]);
            assert!(run.code == 0 || run.code == 1, "{}", run.stderr);
            assert_eq!(run.objects().len(), 1);
        }
        std::fs::write(copy.path(name), whole).unwrap();
    }
}

/// The start of a PNG file that promises an image.
fn png_header(width: u32, height: u32, depth: u8) -> Vec<u8> {
    let mut chunk = b"IHDR".to_vec();
    chunk.extend([width.to_be_bytes(), height.to_be_bytes()].concat());
    chunk.extend([depth, 0, 0, 0, 0]);
    let mut crc = u32::MAX;
    for &byte in &chunk {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    [b"\x89PNG\r\n\x1a\n\0\0\0\x0d", &chunk[..], &(!crc).to_be_bytes(), b"\0\0\0\x04IDAT"].concat()
}

#[test]
fn huge_images_are_refused_by_their_header() {
    for name in ["image", "depth", "mask"] {
        let copy = Copy::new();
        let file = format!("{name}.png");
        for (width, height) in [(100_000, 100_000), (i32::MAX as u32, i32::MAX as u32), (1 << 28, 2)] {
            std::fs::write(copy.path(&file), png_header(width, height, 16)).unwrap();
            let size = format!("{width} x {height}");
            fails(&copy.write(), &[], "IMAGE_TOO_LARGE", &[&file, &size, "at most 268435456"]);
        }
        // The header alone decides here too.
        std::fs::write(copy.path(&file), png_header(641, 480, 16)).unwrap();
        fails(&copy.write(), &[], "SIZE_MISMATCH", &[&file, "641 x 480", "640 x 480"]);
    }
}

#[test]
fn images_of_another_size_than_the_camera_are_refused() {
    for name in ["image", "depth", "mask"] {
        let copy = Copy::new();
        let file = format!("{name}.png");
        ImageBuffer::<Luma<u16>, _>::new(640, 479).save(copy.path(&file)).unwrap();
        let remedy = match name {
            "image" => "intrinsics belong to one resolution",
            "depth" => "register the depth to the image, or describe its own camera as depth_camera",
            _ => "scale the mask to the image",
        };
        fails(&copy.write(), &[], "SIZE_MISMATCH", &[&file, "640 x 479", "640 x 480", remedy]);
    }
}

#[test]
fn depth_is_16_bit_grey() {
    let copy = Copy::new();
    let frame = copy.write();
    for (image, kind) in [
        (DynamicImage::new_luma8(640, 480), "8-bit grey pixels"),
        (DynamicImage::new_rgb8(640, 480), "8-bit RGB pixels"),
        (DynamicImage::new_rgb16(640, 480), "16-bit RGB pixels"),
        (DynamicImage::new_luma_a16(640, 480), "16-bit grey and alpha pixels"),
    ] {
        image.save(copy.path("depth.png")).unwrap();
        fails(&frame, &[], "BAD_IMAGE", &["depth.png", kind, "one 16-bit channel"]);
    }
}

#[test]
fn what_is_likely_a_mistake_is_a_note() {
    let notes = |changes: &[(&str, Value)]| {
        let mut copy = Copy::new();
        for (pointer, value) in changes {
            *copy.json.pointer_mut(pointer).unwrap() = value.clone();
        }
        let object = crate::support::fitted(&copy.write(), &[]);
        let notes = object["notes"].as_array().unwrap().iter();
        notes.map(|note| note.as_str().unwrap()).collect::<Vec<_>>().join("\n")
    };
    let swapped = notes(&[("/camera/cx", json!(239.5)), ("/camera/cy", json!(319.5))]);
    assert!(
        swapped.contains("(239.5, 319.5), far from the middle of 640 x 480 pixels; are cx and cy swapped?")
    );
    for (cx, cy) in [(639.5, 359.5), (159.5, 119.5), (165.0, 112.0)] {
        let of_another = notes(&[("/camera/cx", json!(cx)), ("/camera/cy", json!(cy))]);
        assert!(of_another.contains("are cx and cy those of another resolution?"), "{cx}: {of_another}");
    }
    // A distance of 0.7 m in units of 0.1 mm.
    assert!(notes(&[("/depth_scale", json!(1))]).contains("depth_scale is 1, by which the middle distance"));
    assert!(notes(&[("/depth_scale", json!(1e-7))]).contains("0.001 where it is in millimetres"));
    for scale in [1e-5, 1e-4, 1e-3] {
        let right = notes(&[("/depth_scale", json!(scale)), ("/camera/cx", json!(300))]);
        assert!(!right.contains("depth_scale") && !right.contains("principal"), "{right}");
    }
}

#[test]
fn a_failure_says_what_else_may_be_the_cause() {
    let mut copy = Copy::new();
    // Metres that were rounded.
    let depth = ImageBuffer::<Luma<u16>, _>::from_pixel(640, 480, Luma([1]));
    depth.save(copy.path("depth.png")).unwrap();
    copy.json["depth_scale"] = json!(0.001);
    fails(
        &copy.write(),
        &[],
        "PLANAR_POINTS",
        &["check the mask", "depth: the image has only 1 different values", "Write millimetres"],
    );
}

#[test]
fn files_of_another_format_are_told_which_one_is_read() {
    let copy = Copy::new();
    let frame = copy.write();
    // The start of a TIFF file, in which programs save depth in float, and of an array of numpy.
    for start in [&b"II*\0\x08\0\0\0"[..], b"\x93NUMPY\x01\0"] {
        std::fs::write(copy.path("depth.png"), start).unwrap();
        fails(&frame, &[], "BAD_IMAGE", &["depth.png", "give a PNG file of one 16-bit channel"]);
    }
}

#[test]
fn images_without_content_have_their_own_status() {
    let copy = Copy::new();
    GrayImage::new(640, 480).save(copy.path("mask.png")).unwrap();
    fails(&copy.write(), &[], "EMPTY_MASK", &["640 x 480", "zero"]);

    let copy = Copy::new();
    ImageBuffer::<Luma<u16>, _>::new(640, 480).save(copy.path("depth.png")).unwrap();
    fails(&copy.write(), &[], "NO_DEPTH", &["depth scale"]);

    let copy = Copy::new();
    let mut mask = GrayImage::new(640, 480);
    (0..4).for_each(|x| mask.put_pixel(330 + x, 240, Luma([1])));
    mask.save(copy.path("mask.png")).unwrap();
    fails(&copy.write(), &[], "TOO_FEW_POINTS", &["4 of 307200 points", "at least 5"]);
}

#[test]
fn edges_that_are_no_limbs_are_a_warning_and_no_error() {
    let mut copy = Copy::new();
    let edges = copy.json["edges"].as_array().unwrap().clone();
    copy.json["edges"] = vec![edges[0].clone(), edges[0].clone()].into();
    let object = crate::support::fitted(&copy.write(), &[]);
    assert_eq!(object["result"]["flags"], json!(["edges_ignored", "edges_coincide"]));
    assert_eq!(object["result"]["segments_used"], 0);
    assert!(object["notes"].as_array().unwrap().iter().all(Value::is_string));
}

/// The notes of a fit that must succeed.
fn notes(frame: &std::path::Path, options: &[&str]) -> String {
    fitted(frame, options)["notes"].to_string()
}

#[test]
fn focal_lengths_in_millimetres_or_of_two_sizes_are_noted() {
    let mut copy = Copy::new();
    copy.json["camera"]["fx"] = 3.6.into();
    copy.json["camera"]["fy"] = 3.6.into();
    let noted = notes(&copy.write(), &[]);
    assert!(noted.contains("fx = 3.6 and fy = 3.6") && noted.contains("not in millimetres"), "{noted}");
    let mut copy = Copy::new();
    copy.json["camera"]["fx"] = 400.into();
    let noted = notes(&copy.write(), &[]);
    assert!(noted.contains("fx is 400") && noted.contains("check them"), "{noted}");
    let noted = notes(&Copy::new().write(), &[]);
    assert!(!noted.contains("fx"), "{noted}");
}

#[test]
fn a_radius_in_millimetres_is_noted() {
    let noted = notes(&data("r40_a20_f0"), &["--radius", "37.8"]);
    assert!(noted.contains("37.8 m") && noted.contains("give radii in metres"), "{noted}");
}

#[test]
fn a_search_without_any_depth_says_so() {
    let copy = Copy::new();
    let frame = copy.write();
    ImageBuffer::<Luma<u16>, Vec<u16>>::new(640, 480).save(frame.with_file_name("depth.png")).unwrap();
    let searched = run(["detect", "--json", frame.to_str().unwrap()]);
    assert!(searched.stdout.contains("all pixels are 0"), "{}", searched.stdout);
    let cloud = frame.with_file_name("cloud.xyz");
    std::fs::write(&cloud, "nan nan nan\n").unwrap();
    let searched = run(["detect", "--json", "--points", cloud.to_str().unwrap()]);
    assert!(searched.stdout.contains("the cloud has no points"), "{}", searched.stdout);
    for name in ["empty.ply", "empty.pcd", "empty.xyz"] {
        let cloud = frame.with_file_name(name);
        std::fs::write(&cloud, "").unwrap();
        let searched = run(["detect", "--points", cloud.to_str().unwrap()]);
        assert!(searched.code == 1 && searched.stderr.contains("is an empty file"), "{}", searched.stderr);
    }
}

/// It said that there are no cylinders, and nothing else.
#[test]
fn a_search_in_coordinates_of_a_country_says_that_floats_are_too_coarse() {
    let arc = |k: u16| {
        let angle = f32::from(k % 100) * 0.02;
        [5.0e5 + 0.2 * angle.sin(), 4.0e6 + f32::from(k / 100) * 0.03, 100.0 - 0.2 * angle.cos()]
    };
    let nowhere = |_| [0.0; 3];
    let kinds: [(&dyn Fn(u16) -> [f32; 3], _, _); 3] = [
        (&arc, [0.0; 3], true),
        (&arc, [5.0e5, 4.0e6, 100.0], false),
        // As cameras write what they did not measure.
        (&nowhere, [0.0; 3], false),
    ];
    for (point, offset, is_noted) in kinds {
        let header = "ply\nformat binary_little_endian 1.0\nelement vertex 5000\nproperty float x\nproperty float y\n\
                      property float z\nend_header\n";
        let points = (0..5000).map(point).flat_map(|point| [0, 1, 2].map(|k| point[k] - offset[k]));
        let file = header.bytes().chain(points.flat_map(f32::to_le_bytes)).collect::<Vec<u8>>();
        let copy = Copy::new();
        let cloud = copy.write().with_file_name("cloud.ply");
        std::fs::write(&cloud, file).unwrap();
        let searched = run(["detect", "--json", "--points", cloud.to_str().unwrap()]);
        let notes = ["reach 4000001.5", "0.25 apart", "store them as doubles"];
        assert_eq!(notes.map(|note| searched.stdout.contains(note)), [is_noted; 3], "{}", searched.stdout);
    }
}

#[test]
fn what_is_no_json_says_what_to_do() {
    let copy = Copy::new();
    let (frame, whole) = (copy.write(), copy.json.to_string());
    for content in [whole.replace("\"fx\":", "\"fx\":NaN,\"f\":"), whole[..whole.len() - 1].into()] {
        std::fs::write(&frame, content).unwrap();
        fails(&frame, &[], "BAD_FRAME", &["is not valid JSON", "no NaN"]);
    }
}

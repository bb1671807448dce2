//! What a frame may look like.

use crate::support::{Copy, data, fails, fitted, vector};
use image::{DynamicImage, ImageFormat};
use serde_json::{Value, json};

/// The cylinder of the unchanged frame.
fn plain() -> Value {
    fitted(&data("r40_a20_f0"), &[])["cylinder"].clone()
}

#[test]
fn images_may_be_grey_or_colour_of_8_or_16_bits() {
    let expected = plain();
    let copy = Copy::new();
    let grey = image::open(copy.path("image.png")).unwrap();
    type Convert = fn(&DynamicImage) -> DynamicImage;
    let kinds: [(&str, Convert); 6] = [
        ("grey 8", |i| i.to_luma8().into()),
        ("grey 16", |i| i.to_luma16().into()),
        ("rgb 8", |i| i.to_rgb8().into()),
        ("rgb 16", |i| i.to_rgb16().into()),
        ("rgba 8", |i| i.to_rgba8().into()),
        ("rgba 16", |i| i.to_rgba16().into()),
    ];
    let out = copy.path("out");
    for (name, convert) in kinds {
        convert(&grey).save_with_format(copy.path("image.png"), ImageFormat::Png).unwrap();
        let object = fitted(&copy.write(), &["--out", out.to_str().unwrap()]);
        let numbers = |cylinder: &Value| {
            [
                vector(&cylinder["point"]),
                vector(&cylinder["direction"]),
                [cylinder["radius"].as_f64().unwrap(); 3],
            ]
        };
        let pairs = std::iter::zip(numbers(&object["cylinder"]), numbers(&expected));
        // In 16 bits the numbers are 257 times as large.
        let near = |(a, b): ([f64; 3], [f64; 3])| std::iter::zip(a, b).all(|(a, b)| (a - b).abs() < 1e-10);
        assert!(pairs.into_iter().all(near), "{name}: {} for {expected}", object["cylinder"]);
        assert!(image::open(out.join("overlay.png")).is_ok(), "{name}");
    }
    // The content tells the format, not the name.
    grey.to_rgb8().save_with_format(copy.path("image.png"), ImageFormat::Jpeg).unwrap();
    let radius = |cylinder: &Value| cylinder["radius"].as_f64().unwrap();
    let lossy = radius(&fitted(&copy.write(), &[])["cylinder"]);
    assert!((lossy / radius(&expected) - 1.0).abs() < 0.01, "{lossy}");
}

#[test]
fn an_image_may_be_coded_with_a_gamma() {
    let mut copy = Copy::of("w022");
    let mut grey = image::open(copy.path("image.png")).unwrap().to_luma16();
    grey.pixels_mut().for_each(|p| p.0[0] = (65535.0 * (f64::from(p.0[0]) / 65535.0).powf(1.0 / 2.2)) as u16);
    grey.save_with_format(copy.path("image.png"), ImageFormat::Png).unwrap();
    let radius = |cylinder: &Value| cylinder["radius"].as_f64().unwrap();
    let expected = radius(&fitted(&data("w022"), &[])["cylinder"]);
    let error = |copy: &Copy| (radius(&fitted(&copy.write(), &[])["cylinder"]) / expected - 1.0).abs();
    let without = error(&copy);
    copy.json["image_gamma"] = json!(null);
    assert_eq!(error(&copy), without);
    copy.json["image_gamma"] = json!(2.2);
    let with = error(&copy);
    assert!(with < 1e-5 && with < 0.1 * without, "{with} {without}");
}

#[test]
fn a_colour_counts_by_its_light_and_is_saturated_by_its_green() {
    let copy = Copy::of("w022");
    let grey = image::open(copy.path("image.png")).unwrap().to_luma8();
    let radius = |image: DynamicImage| {
        image.save_with_format(copy.path("image.png"), ImageFormat::Png).unwrap();
        fitted(&copy.write(), &[])["cylinder"]["radius"].as_f64().unwrap()
    };
    let expected = radius(grey.clone().into());
    let colour = |of: &dyn Fn(u8) -> [u8; 3]| {
        let colour = image::RgbImage::from_fn(grey.width(), grey.height(), |x, y| {
            let value = grey.get_pixel(x, y).0[0];
            image::Rgb(of(value / 2))
        });
        DynamicImage::from(colour)
    };
    let half = radius(colour(&|value| [value; 3]));
    assert!((half / expected - 1.0).abs() < 1e-3, "{half} for {expected}");
    copy.write();
    let located = |image: DynamicImage| {
        radius(image);
        fitted(&copy.write(), &[])["result"]["limbs_located"].as_u64().unwrap()
    };
    // Blue counts little in light, and tells little where it is cut off; green counts most.
    let blue = located(colour(&|value| [value, value, 255]));
    let green = located(colour(&|value| [value, 255, value]));
    assert_eq!((blue, green), (2, 0));
}

#[test]
fn masks_may_have_any_colour() {
    let expected = plain();
    let copy = Copy::new();
    let mask = image::open(copy.path("mask.png")).unwrap();
    // A small value in one channel only, and an opaque black elsewhere.
    let mut colour = mask.to_rgba8();
    for pixel in colour.pixels_mut() {
        pixel.0 = [0, 0, u8::from(pixel.0[0] != 0), 255];
    }
    let mut faint = mask.to_luma16();
    for pixel in faint.pixels_mut() {
        pixel.0[0] = u16::from(pixel.0[0] != 0);
    }
    for image in [DynamicImage::from(colour), DynamicImage::from(faint)] {
        image.save(copy.path("mask.png")).unwrap();
        assert_eq!(fitted(&copy.write(), &[])["cylinder"], expected);
    }
}

#[test]
fn image_and_edges_are_optional() {
    let remove = |json: &mut Value, name: &str| drop(json.as_object_mut().unwrap().remove(name));
    let set_null = |json: &mut Value, name: &str| json[name] = Value::Null;
    type Absent = fn(&mut Value, &str);
    for absent in [remove as Absent, set_null] {
        let mut copy = Copy::new();
        absent(&mut copy.json, "image");
        let without = fitted(&data("r40_a20_f0"), &["--no-image"]);
        assert_eq!(fitted(&copy.write(), &[])["cylinder"], without["cylinder"]);
        absent(&mut copy.json, "edges");
        assert_eq!(fitted(&copy.write(), &[])["result"]["segments_given"], 0);
        fails(&copy.write(), &["--objective", "paper"], "UNSUPPORTED", &["2 edge segments, not 0"]);
    }
}

#[test]
fn any_number_of_edges_is_taken() {
    let mut copy = Copy::new();
    let edges = copy.json["edges"].as_array().unwrap().clone();
    for count in [0, 1, 2, 3] {
        copy.json["edges"] = edges.iter().cycle().take(count).cloned().collect();
        let result = &fitted(&copy.write(), &[])["result"];
        assert_eq!(result["segments_given"], count);
        assert_eq!(result["segments_used"], count);
    }
    fails(&copy.write(), &["--objective", "paper"], "UNSUPPORTED", &["2 edge segments, not 3"]);
}

#[test]
fn distortion_has_0_4_5_or_8_numbers() {
    let mut copy = Copy::of("w004");
    let all = copy.json["camera"]["distortion"].as_array().unwrap().clone();
    let padded: Vec<Value> = all.iter().cloned().chain(vec![json!(0.0); 4]).collect();
    let mut radii = Vec::new();
    for count in [0, 4, 5, 8] {
        copy.json["camera"]["distortion"] = padded[..count].to_vec().into();
        radii.push(fitted(&copy.write(), &[])["cylinder"]["radius"].clone());
    }
    // k3 is zero here, and so is what follows.
    assert!(radii[0] != radii[1] && radii[1] == radii[2] && radii[2] == radii[3], "{radii:?}");
    for count in [1, 6, 9] {
        copy.json["camera"]["distortion"] = vec![0.0; count].into();
        let wrong = format!("coefficients is {count};");
        fails(&copy.write(), &[], "INVALID_INTRINSICS", &[&wrong, "0, 4, 5 or 8"]);
    }
}

#[test]
fn the_camera_model_may_be_named() {
    let expected = plain();
    let mut copy = Copy::new();
    copy.json["camera"]["model"] = "brown_conrady".into();
    assert_eq!(fitted(&copy.write(), &[])["cylinder"], expected);
    copy.json["camera"]["model"] = "kannala_brandt".into();
    for distortion in [vec![], vec![0.01, 0.0, 0.0, 0.0]] {
        copy.json["camera"]["distortion"] = distortion.into();
        let fisheye = fitted(&copy.write(), &[]);
        assert!(fisheye["cylinder"] != expected && fisheye["extent"]["length"].is_f64());
    }
    copy.json["camera"]["distortion"] = vec![0.0; 5].into();
    fails(&copy.write(), &[], "INVALID_INTRINSICS", &["is 5;", "0 or 4"]);
    copy.json["camera"]["model"] = "pinhole".into();
    fails(&copy.write(), &[], "BAD_FRAME", &["camera.model", "pinhole", "brown_conrady", "kannala_brandt"]);
}

#[test]
fn paths_may_be_absolute_and_frames_may_have_any_name() {
    let mut copy = Copy::new();
    for name in ["image", "depth", "mask"] {
        copy.json[name] = copy.path(&format!("{name}.png")).to_str().unwrap().into();
    }
    copy.write();
    let elsewhere = tempfile::tempdir().unwrap();
    let moved = elsewhere.path().join("view 1.json");
    std::fs::rename(copy.path("frame.json"), &moved).unwrap();
    assert_eq!(fitted(&moved, &[])["cylinder"], plain());
}

//! The page of `--report`: what stands in it. `tests/report.sh` opens it in a browser.

use crate::support::{Copy, run};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;
use tempfile::TempDir;

const FRAME: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/frames/r40_a20_f0");
const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/scene");

/// The data of a page, which needs nothing else.
fn content(page: &Path) -> Value {
    let text = std::fs::read_to_string(page).unwrap();
    for other in ["src=\"http", "href=\"http", "@import", "<link rel=\"stylesheet"] {
        assert!(!text.contains(other), "{other}");
    }
    let start = "<script type=\"application/json\" id=\"content\">";
    let (_, rest) = text.split_once(start).unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_page_about_fits_has_verdicts_pictures_and_points() {
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("page.html");
    let page_text = page.to_str().unwrap();
    for (limits, verdict, reason) in [
        ("radius=0.03..0.05", "pass", " mm within the limit of 30 mm"),
        ("radius=0.01..0.02", "fail", " mm above the limit of 20 mm"),
        ("radius=0.01..0.0377", "undecided", " mm, its uncertainty is "),
    ] {
        let run = run(["fit", FRAME, "--json", "--report", page_text, "--tolerance", limits]);
        assert_eq!(run.code, 0, "{}", run.stderr);
        let fitted = run.object();
        let content = content(&page);
        let frame = &content["frames"][0];
        let cylinder = &frame["cylinders"][0];
        assert_eq!(cylinder["judgement"]["verdict"], verdict);
        let reasons = cylinder["judgement"]["reasons"].as_array().unwrap();
        let said = reasons[0].as_str().unwrap();
        assert!(reasons.len() == 1 && said.starts_with("radius ") && said.contains(reason), "{said}");
        assert_eq!(cylinder["radius"], fitted["cylinder"]["radius"]);
        assert_eq!(cylinder["length_deviation"], fitted["extent"]["length_deviation"]);
        assert_eq!(
            (&content["millimetres"], &content["tolerances"][0]["quantity"]),
            (&1000.0.into(), &"radius".into())
        );
        // 12 bytes a point are 16 letters.
        let points = frame["points"].as_str().unwrap().len() / 16;
        assert!((500..=1500).contains(&points), "{points}");
        let picture = &cylinder["picture"];
        assert!(picture["jpeg"].as_str().unwrap().starts_with("/9j/"), "a JPEG");
        let labels: Vec<&Value> =
            picture["labels"].as_array().unwrap().iter().map(|one| &one["text"]).collect();
        assert_eq!(labels, [&fitted["extent"]["start_state"], &fitted["extent"]["end_state"]]);
    }
}

#[test]
fn a_page_about_scenes_has_a_row_a_cylinder() {
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("page.html");
    let run =
        run(["detect", SCENE, "--json", "--report", page.to_str().unwrap(), "--tolerance", "length=0.1..1"]);
    assert_eq!(run.code, 0, "{}", run.stderr);
    let found = run.object();
    let content = content(&page);
    let cylinders = content["frames"][0]["cylinders"].as_array().unwrap();
    assert_eq!(cylinders.len(), found["cylinders"].as_array().unwrap().len());
    assert_eq!(
        (&cylinders[1]["number"], &cylinders[1]["radius"]),
        (&2.into(), &found["cylinders"][1]["cylinder"]["radius"])
    );
    assert!(cylinders.iter().all(|cylinder| cylinder["judgement"]["verdict"].is_string()));
    // A picture of each, and one of all with their numbers.
    let pictures: BTreeSet<&str> =
        cylinders.iter().map(|cylinder| cylinder["picture"]["jpeg"].as_str().unwrap()).collect();
    assert_eq!(pictures.len(), cylinders.len());
    let all = &content["frames"][0]["picture"];
    assert!(all["jpeg"].as_str().unwrap().starts_with("/9j/"));
    let numbers = all["labels"].as_array().unwrap().iter().map(|one| one["text"].as_str().unwrap());
    let expected: Vec<String> = (1..=cylinders.len()).map(|number| number.to_string()).collect();
    assert!(numbers.eq(expected.iter()), "{}", all["labels"]);
}

#[test]
fn clouds_have_no_unit_and_a_page_that_cannot_be_written_is_told() {
    let folder = TempDir::new().unwrap();
    let cloud = folder.path().join("pipe.xyz");
    let line = |k: u32| {
        let angle = 0.01 * f64::from(k);
        format!("{} {} {}\n", 5000.0 + 0.5 * angle.cos(), 0.1 * f64::from(k % 7), 0.5 * angle.sin())
    };
    std::fs::write(&cloud, (0..200).map(line).collect::<String>()).unwrap();
    let cloud = cloud.to_str().unwrap();
    let page = folder.path().join("page.html");
    assert_eq!(run(["fit", "--points", cloud, "--report", page.to_str().unwrap()]).code, 0);
    let content = content(&page);
    assert!(content["millimetres"].is_null() && content["frames"][0]["cylinders"][0]["picture"].is_null());
    assert!((content["frames"][0]["origin"][0].as_f64().unwrap() - 5000.5).abs() < 1e-9);
    let refused = run(["fit", "--points", cloud, "--report", "no/such/folder/page.html"]);
    assert_eq!(refused.code, 1);
    assert!(refused.stderr.contains("FILE_NOT_WRITABLE"), "{}", refused.stderr);
    assert!(refused.stderr.contains("name a place in a folder that exists"), "{}", refused.stderr);
    // Before the work, not after it.
    assert_eq!(refused.stdout, "");
    let refused = run(["fit", FRAME, "--tolerance", "radius=1..2"]);
    assert!(refused.code == 2 && refused.stderr.contains("--report"), "{}", refused.stderr);
}

#[test]
fn no_verdict_rests_on_a_result_with_a_warning_that_puts_it_in_doubt() {
    let folder = TempDir::new().unwrap();
    let page = folder.path().join("page.html");
    let page_text = page.to_str().unwrap();
    let judged = |tolerance: &str, options: &[&str]| {
        let fixed = ["fit", FRAME, "--report", page_text, "--tolerance", tolerance];
        let run = run(fixed.iter().chain(options));
        assert_eq!(run.code, 0, "{}", run.stderr);
        content(&page)["frames"][0]["cylinders"][0]["judgement"].clone()
    };
    assert_eq!(judged("radius=0.03..0.05", &[])["verdict"], "pass");
    // A limit that holds the radius at a value within the tolerance makes it no good one.
    let judgement = judged("radius=0.03..0.05", &["--radius-max", "0.035"]);
    assert_eq!(judgement["verdict"], "undecided", "{judgement}");
    let first = judgement["reasons"][0].as_str().unwrap();
    assert!(first.starts_with("in doubt: "), "{judgement}");
    // The number and the verdict that it would have given stand behind.
    let last = judgement["reasons"].as_array().unwrap().last().unwrap().as_str().unwrap();
    assert!(last.ends_with(" mm within the limit of 30 mm"), "{judgement}");
}

#[test]
fn a_report_replaces_no_input_and_a_quantity_has_one_tolerance() {
    let folder = TempDir::new().unwrap();
    let frame = folder.path().join("frame.json");
    std::fs::write(&frame, "{}").unwrap();
    let name = frame.to_str().unwrap();
    for command in ["fit", "detect"] {
        let refused = run([command, name, "--report", name]);
        assert!(refused.code == 2 && refused.stderr.contains("must end in .html"), "{}", refused.stderr);
        assert_eq!(std::fs::read_to_string(&frame).unwrap(), "{}");
        let page = folder.path().join("page.HTML");
        let mut arguments = vec![command, name, "--report", page.to_str().unwrap()];
        arguments.extend(["--tolerance", "radius=0.01..0.02", "--tolerance", "radius=0.03..0.04"]);
        let refused = run(&arguments);
        let reason = "--tolerance limits the radius 2 times";
        assert!(refused.code == 2 && refused.stderr.contains(reason), "{}", refused.stderr);
    }
}

#[test]
fn a_cylinder_whose_end_nobody_saw_is_not_too_short() {
    let copy = Copy::new();
    let mut depth = image::open(copy.path("depth.png")).unwrap().into_luma16();
    let half = depth.height() / 2;
    depth.rows_mut().skip(half as usize).flatten().for_each(|pixel| pixel.0 = [0]);
    depth.save(copy.path("depth.png")).unwrap();
    let page = copy.path("page.html");
    let (frame, page_text) = (copy.write(), page.to_str().unwrap());
    let judged = |frame: &str, options: &[&str]| {
        let fixed = ["fit", frame, "--report", page_text, "--tolerance", "length=0.3..0.4"];
        assert_eq!(run(fixed.iter().chain(options)).code, 0);
        content(&page)["frames"][0]["cylinders"][0]["judgement"].clone()
    };
    let whole = judged(FRAME, &[]);
    assert_eq!(whole["verdict"], "fail", "{whole}");
    let cut = judged(frame.to_str().unwrap(), &["--no-image", "--no-edges"]);
    assert_eq!(cut["verdict"], "undecided", "{cut}");
    assert!(cut["reasons"].to_string().contains("not seen"), "{cut}");
}

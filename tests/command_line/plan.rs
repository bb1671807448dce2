//! `cylfuse plan`.

use crate::support::run;
use serde_json::Value;

fn number(value: &Value, path: &str) -> f64 {
    value.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {value}"))
}

#[test]
fn a_row_a_value_and_where_the_radius_is_good_enough() {
    let vary = ["plan", "--radius", "0.01", "--length", "0.3", "--vary", "distance=0.4..1.2:5"];
    let rows = run(vary.iter().chain(&["--json"])).objects();
    let distances: Vec<f64> = rows.iter().map(|row| number(row, "/distance")).collect();
    assert_eq!(distances.len(), 5);
    assert!(distances.iter().zip([0.4, 0.6, 0.8, 1.0, 1.2]).all(|(a, b)| (a - b).abs() < 1e-12));
    let radii: Vec<f64> = rows.iter().map(|row| number(row, "/expected/total/radius")).collect();
    assert!(radii.is_sorted() && radii[0] > 0.0, "{radii:?}");
    let table = run(vary.iter().chain(&["--within", "0.5"]));
    assert_eq!(table.code, 0, "{}", table.stderr);
    let line = table.stdout.lines().last().unwrap();
    let start = "The radius is within 0.5 % (standard deviation, total) at a distance of 0.400 to ";
    let reach: f64 = line.strip_prefix(start).unwrap().strip_suffix(" m").unwrap().parse().unwrap();
    // There it is 0.5 % of 10 mm.
    let there =
        run(["plan", "--radius", "0.01", "--length", "0.3", "--json", "--distance", &reach.to_string()]);
    assert!((number(&there.object(), "/expected/total/radius") / 0.5e-4 - 1.0).abs() < 0.01, "{line}");
    let none = run(vary.iter().chain(&["--within", "0.001"]));
    let line = none.stdout.lines().last().unwrap();
    assert_eq!(line, "The radius is not within 0.001 % at any distance from 0.4 to 1.2 m");
}

#[test]
fn the_camera_of_a_frame_and_other_noise() {
    let frame = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/frames/r40_a20_f0/frame.json");
    let of_frame = run(["plan", "--json", "--frame", frame]).object();
    let same = run(["plan", "--json", "--width", "640", "--height", "480", "--focal-length", "570"]).object();
    let radius = "/expected/total/radius";
    assert!((number(&of_frame, radius) / number(&same, radius) - 1.0).abs() < 0.05);
    let position = "/expected/scatter/position";
    let noisy = run(["plan", "--json", "--depth-noise", "0.01,0,0", "--correlation", "9"]).object();
    assert!(number(&noisy, position) > 2.0 * number(&same, position));
    assert_eq!(noisy["depth_noise"][0], 0.01);
    let faint = run(["plan", "--json", "--limb-noise", "0.014,0.4"]).object();
    assert!(number(&faint, radius) > 1.5 * number(&same, radius), "a faint limb");
    assert!(faint["step_noise"].is_null());
    assert_eq!((number(&faint, "/limb_noise/1"), number(&faint, "/end_noise/1")), (0.4, 0.014));
    let length = "/expected/scatter/length";
    let faint = run(["plan", "--json", "--end-noise", "0.4,0.014"]).object();
    assert!(number(&faint, length) > 2.0 * number(&same, length), "a faint end");
}

#[test]
fn what_cannot_be_planned_is_said() {
    let far = run(["plan", "--distance", "9"]);
    assert_eq!(far.code, 1);
    assert!(
        far.stdout.contains("not measured: ") && far.stdout.contains("points are usable"),
        "{}",
        far.stdout
    );
    // Every reason, with the rows that have it.
    let many = run(["plan", "--vary", "distance=0.02..3.62:10", "--radius", "0.01", "--length", "0.2"]);
    assert_eq!(many.code, 1, "{}", many.stderr);
    let reasons: Vec<&str> = many.stdout.lines().filter(|line| line.starts_with("not measured at")).collect();
    assert_eq!(reasons.len(), 2, "{}", many.stdout);
    assert!(reasons[0].starts_with("not measured at a distance of 0.02 m: length is "), "{}", reasons[0]);
    let few = reasons[1].strip_prefix("not measured at a distance of ").unwrap();
    assert!(few.contains(" to 3.62 m (numbers at ") && few.contains("points are usable"), "{few}");
    let missed = many.stdout.lines().filter(|line| line.trim_end().ends_with("not measured")).count();
    assert!(missed > 2, "{}", many.stdout);
    for (arguments, expected) in [
        (&["--vary", "weight=1..2"][..], "\"weight\" cannot be varied"),
        (&["--within", "1"], "--vary"),
        (&["--within", "nan", "--vary", "distance=1..2"], "is no percentage greater than 0"),
        (&["--within", "1", "--vary", "distance=1..2", "--json"], "cannot be used with"),
        (&["--radius=-1"], "radius is -1; it must be finite and greater than 0 (INVALID_ARGUMENT)"),
        (&["--radius", "2"], "the distance of the axis from the camera (INVALID_ARGUMENT)"),
        (&["--distance", "nan"], "distance is NaN"),
        (&["--step-noise", "0", "--vary", "distance=0.5..1:3"], "noise of a step is 0"),
        (&["--vary", "radius=-2..-1"], "radius is -2"),
        (&["--width", "0"], "(INVALID_INTRINSICS)"),
        (&["--focal-length=-5"], "(INVALID_INTRINSICS)"),
        (&["--field-of-view", "180"], "is no angle greater than 0 and less than 180 degrees"),
        (&["--tilt", "91"], "a tilt of 91 degrees; it must be from -80 to 80"),
        (&["--depth-noise", "1,2"], "2 numbers were given, but 3 are needed"),
        (&["--depth-noise", "1,2,3"], "--correlation"),
        (&["--frame", "x.json", "--focal-length", "5"], "cannot be used with"),
    ] {
        let run = run(["plan"].iter().chain(arguments));
        assert_eq!(run.code, 2, "{arguments:?}");
        assert!(run.stderr.contains(expected), "{arguments:?}: {}", run.stderr);
    }
    let missing = run(["plan", "--frame", "no/frame.json"]);
    assert_eq!(missing.code, 1);
    assert!(missing.stderr.contains("FILE_NOT_READABLE"), "{}", missing.stderr);
}

#[cfg(feature = "twin")]
#[test]
fn captures_stand_beside_what_is_expected_for_any_number_of_threads() {
    let with = |threads: &str| {
        run(["plan", "--json", "--simulate", "3", "--seed", "5", "--threads", threads]).stdout
    };
    let one = with("1");
    assert_eq!(one, with("2"));
    let row: Value = serde_json::from_str(&one).unwrap();
    assert_eq!((&row["captures"]["count"], &row["captures"]["far_off"]), (&3.into(), &0.into()));
    assert!(number(&row, "/captures/scatter/radius") > 0.0 && number(&row, "/captures/bias/radius") >= 0.0);
}

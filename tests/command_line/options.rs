//! Options, alone and together.

use crate::support::{data, fitted, run, vector};

/// Checks that a command line is refused with exit status 2, nothing on stdout and a reason.
fn refused(options: &[&str], reason: &str) {
    let frame = data("w004");
    let run = run(["fit", "--json", frame.to_str().unwrap()].iter().chain(options));
    assert_eq!(run.code, 2, "{options:?}: {}", run.stdout);
    assert!(run.stdout.is_empty());
    assert!(run.stderr.contains(reason), "{options:?}: no '{reason}' in {}", run.stderr);
}

#[test]
fn combinations_that_make_no_sense_are_refused() {
    for method in ["points", "ransac", "eberly"] {
        refused(&["--method", method, "--objective", "paper"], "--objective belongs to --method fused");
        refused(&["--method", method, "--objective", "robust"], "--objective belongs to --method fused");
        refused(&["--method", method, "--edge-weight", "0.5"], "--edge-weight belongs to --method fused");
        refused(&["--method", method, "--edges-as-given"], "--edges-as-given belongs to --method fused");
    }
    refused(&["--edge-weight", "0.6"], "--edge-weight belongs to --objective paper");
    refused(&["--objective", "robust", "--edge-weight", "0.6"], "--edge-weight belongs to --objective paper");
    refused(&["--start-from", "model"], "--start=");
    refused(&["--start=0,0,1,0,1,0,0.05", "--start-from", "limbs"], "--start-from");
    refused(&["--points", "cloud.ply"], "--points");
    refused(&["--edges-as-given", "--no-edges"], "cannot be used with");
    refused(&["--radius", "1", "--radius-max", "2"], "cannot be used with");
    refused(&["--axis-max-angle", "5"], "--axis");
}

#[test]
fn values_out_of_range_are_named_with_their_limit() {
    for weight in ["1.5", "-0.1", "nan", "inf"] {
        let reason = format!(
            "--edge-weight is {}; it must lie in [0, 1] (INVALID_ARGUMENT)",
            weight.replace("nan", "NaN")
        );
        refused(&["--objective", "paper", "--edge-weight", weight], &reason);
    }
    refused(&["--max-iterations", "0"], "--max-iterations is 0; it must be at least 1");
    refused(&["--start=0,0,1,0,1,0"], "6 numbers");
    refused(&["--start=0,0,1,0,1,0,wide"], "'wide' is not a number");
    refused(&["--start=0,0,1,0,1,0,-0.05"], "radius is -0.05; it must be finite and greater than 0");
    refused(&["--start=0,0,1,0,0,0,0.05"], "axis direction");
    refused(&["--start=0,0,nan,0,1,0,0.05"], "axis point");
    refused(&["--radius-min", "-1"], "--radius-min is -1; it must be finite and at least 0");
    refused(
        &["--radius-min", "2", "--radius-max", "1"],
        "--radius-max is 1; it must be greater than 0 and at least",
    );
    refused(&["--radius", "0"], "--radius is 0; it must be finite and greater than 0");
    refused(&["--axis", "0,0,0"], "--axis is [0.0, 0.0, 0.0]; it must not be zero");
    refused(&["--axis", "0,1"], "2 numbers were given, but 3 are needed");
    refused(
        &["--axis", "0,1,0", "--axis-max-angle", "91"],
        "--axis-max-angle is 91; it must lie in [0, 90] degrees",
    );
    refused(&["--method", "magic"], "magic");
    refused(&["--noise", "edge-endpoint=0"], "--noise edge-endpoint is 0; it must be finite and greater");
    refused(&["--noise=depth=-1"], "--noise depth is -1; it must be finite and at least 0; 0 = estimated");
    refused(&["--noise", "edge-endpoint"], "give NAME=VALUE, such as edge-endpoint=0.3");
    refused(&["--noise", "edge=1"], "'edge' is none of edge-endpoint, mask-side,");
    refused(&["--noise=depth-shared=-1"], "--noise depth-shared is -1; it must be finite and at least 0");
    refused(&["--noise", "blur=much"], "'much' is not a number");
    refused(&["--independent-points", "-2"], "--independent-points is -2; it must be finite and at least 0");
    refused(&["--threads", "many"], "--threads");
}

#[test]
fn something_must_be_fitted() {
    assert_eq!(run(["fit"]).code, 2);
    assert_eq!(run(["measure"]).code, 2);
    assert_eq!(run::<&str>([]).code, 2);
}

#[test]
fn help_and_version_are_there() {
    let help = run(["fit", "--help"]);
    assert_eq!(help.code, 0);
    for word in [
        "--objective",
        "--edge-weight",
        "--start",
        "--no-image",
        "depth_scale",
        "kannala_brandt",
        "depth_camera",
        "views",
        "mask-growth",
    ] {
        assert!(help.stdout.contains(word), "no {word} in the help");
    }
    assert_eq!(run(["--version"]).stdout, concat!("cylfuse ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn a_start_is_where_the_iteration_starts() {
    for start in
        ["--start=9.6e-2,.02,0.7,-3.5e-1,-0.75,0.56,5.7E-2", "--start= 0.096, 0.02,0.7,-3.5,-7.5,5.6,0.057"]
    {
        let object = fitted(&data("w004"), &["--objective", "paper", start]);
        let result = &object["result"];
        assert_eq!(result["start_kind"], "model");
        assert_eq!(vector(&result["start"]["point"]), [0.096, 0.02, 0.7]);
        let direction = vector(&result["start"]["direction"]);
        assert!((direction[0] / direction[1] - 3.5 / 7.5).abs() < 1e-12);
        assert_eq!(result["start"]["radius"], 0.057);
    }
}

#[test]
fn the_paper_objective_has_its_weight_and_the_others_none() {
    let frame = data("w004");
    let weight = |options: &[&str]| fitted(&frame, options)["result"]["edge_weight"].clone();
    assert_eq!(weight(&["--objective", "paper"]), 0.6);
    assert_eq!(weight(&["--method", "fused", "--objective", "paper", "--edge-weight", "2.5e-1"]), 0.25);
    assert!(weight(&["--method", "points"]).is_null());
    assert!(weight(&[]).is_null());
}

#[test]
fn other_methods_fit_the_points_alone() {
    let points = fitted(&data("w004"), &["--method", "points"]);
    let result = &points["result"];
    assert_eq!(result["method"], "points");
    assert!(result["objective"].is_null());
    assert_eq!(result["segments_used"], 0);
    let (cost, energy) = (result["cost"].as_f64().unwrap(), result["energy_points"].as_f64().unwrap());
    assert!((cost / energy - 1.0).abs() < 1e-12);

    let eberly = fitted(&data("w004"), &["--method", "eberly"]);
    let result = &eberly["result"];
    assert_eq!((&result["method"], &result["start_kind"]), (&"eberly".into(), &"moments".into()));
    // It does not iterate.
    assert_eq!(result["iterations"], 0);
    for name in ["termination", "lambda", "step_norm", "initial_cost", "rejected_steps"] {
        assert!(result[name].is_null(), "{name}");
    }
}

#[test]
fn what_is_known_of_the_noise_can_be_told() {
    let frame = data("w004");
    let deviation = |options: &[&str]| fitted(&frame, options)["uncertainty"]["radius"].as_f64().unwrap();
    let points = |count: &str| fitted(&frame, &["--method", "points", "--independent-points", count]);
    assert_eq!(points("50")["result"]["independent_points"], 50.0);
    let [few, many] = ["50", "200"].map(|count| points(count)["uncertainty"]["radius"].as_f64().unwrap());
    assert!(few > 1.5 * many, "{few} {many}");
    // Edges that are set better, and depth that is better, tell more of the radius.
    let given = ["--edges-as-given", "--noise"];
    let edges = |value: &str| deviation(&[&given[..], &[value]].concat());
    assert!(edges("edge-endpoint=0.1") < edges("edge-endpoint=1"));
    let depth = |value: &str| deviation(&["--no-edges", "--no-image", "--noise", value]);
    assert!(depth("depth=0.0001") < depth("depth=0.01"));
    // What all points share is in the uncertainty.
    let shared = |value: &str| deviation(&["--no-edges", "--no-image", "--noise", value]);
    assert!(shared("depth-shared=0") < shared("depth-shared=0.01"));
    let sides = ["--no-edges", "--noise", "mask-side=5", "--noise", "mask-unevenness=3"];
    assert_ne!(fitted(&frame, &sides)["cylinder"], fitted(&frame, &sides[..1])["cylinder"]);
}

#[test]
fn limits_hold_and_are_said() {
    let known =
        fitted(&data("w004"), &["--radius", "0.057", "--axis=-0.3,-0.75,0.56", "--axis-max-angle", "2"]);
    assert_eq!(known["cylinder"]["radius"], 0.057);
    let limits = &known["result"]["limits"];
    assert_eq!((&limits["radius_min"], &limits["radius_max"]), (&0.057.into(), &0.057.into()));
    assert_eq!(vector(&limits["axis"]), [-0.3, -0.75, 0.56]);
    assert!((limits["axis_max_angle_degrees"].as_f64().unwrap() - 2.0).abs() < 1e-12);
    let held = fitted(&data("w004"), &["--radius-max", "0.0565"]);
    assert_eq!(held["cylinder"]["radius"], 0.0565);
    assert_eq!(held["result"]["flags"], serde_json::json!(["radius_at_limit"]));
    assert_eq!(held["notes"][0], "the radius is at its limit; the data fit better beyond it");
    assert!(fitted(&data("w004"), &[])["result"]["limits"].is_null());
}

#[test]
fn edges_can_be_taken_as_they_are() {
    let located = |options: &[&str]| fitted(&data("w004"), options)["result"]["limbs_located"].clone();
    assert!(located(&[]).as_u64().unwrap() > 0);
    assert_eq!(located(&["--edges-as-given"]), 0);
}

#[test]
fn the_rule_of_the_extent_can_be_chosen() {
    let length = |options: &[&str]| fitted(&data("w004"), options)["extent"]["length"].clone();
    assert_eq!(length(&[]), length(&["--extent-rule", "located"]));
    assert_ne!(length(&[]), length(&["--extent-rule", "extremes"]));
    let paper = ["--objective", "paper", "--extent-rule"];
    assert_eq!(length(&paper[..2]), length(&[&paper[..], &["extremes"]].concat()));
    assert_ne!(length(&paper[..2]), length(&[&paper[..], &["located"]].concat()));
}

#[test]
fn both_charts_reach_the_same_minimum() {
    let radius = |chart: &str| {
        let object = fitted(&data("w004"), &["--objective", "paper", "--chart", chart]);
        object["cylinder"]["radius"].as_f64().unwrap()
    };
    assert!((radius("local") / radius("orthonormal") - 1.0).abs() < 1e-6);
}

#[test]
fn the_limit_of_iterations_is_kept_and_said() {
    let object =
        fitted(&data("w004"), &["--objective", "paper", "--edge-weight", "0", "--max-iterations", "1"]);
    let result = &object["result"];
    assert_eq!((&result["iterations"], &result["termination"]), (&1.into(), &"max_iterations".into()));
    assert_eq!(result["flags"], serde_json::json!(["not_converged"]));
    assert_eq!(object["notes"][0], "not converged; allow more iterations");
}

#[test]
fn the_near_wall_rule_can_be_switched_off() {
    let fraction = |options: &[&str]| fitted(&data("w004"), options)["result"]["near_wall_fraction"].clone();
    assert!(fraction(&[]).as_f64().unwrap() > 0.9);
    assert!(fraction(&["--no-near-wall"]).is_null());
}
